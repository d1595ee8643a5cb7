/* SPDX-License-Identifier: MIT */
/* One request, from its head to the end of its answer.
 *
 *   HEAD ──admit──► BODY ───────────────────────► dispatch ──► ANSWERED ──► (sent, freed)
 *     │               │ no memory (intake.h)         │            ▲
 *     │               ▼                              ▼            │ resume
 *     └─refused──► DISCARD (read, not kept) ──►    WORK ──────────┘
 *
 * HEAD, BODY, DISCARD and ANSWERED belong to the thread of the connection's loop. WORK belongs to
 * exactly one other thread: a store or compute thread, which may pass the request to the watcher.
 * The hand-over back is pen_http_resume; the thread that has resumed a request must not touch it
 * any more. */
#ifndef PEN_HTTP_INTERNAL_REQUEST_H
#define PEN_HTTP_INTERNAL_REQUEST_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/buf.h"
#include "http/internal/addresses.h"
#include "http/internal/reply.h"
#include "http/internal/routes.h"
#include "http/message.h"
#include "store/store.h"

struct conn;
struct pen_http;
struct route;

enum phase { PHASE_HEAD, PHASE_BODY, PHASE_DISCARD, PHASE_WORK, PHASE_ANSWERED };

/* The header fields that the server reads; NULL: not sent. They point into the request's head. */
struct fields {
    const char *host, *origin, *content_type, *content_length, *transfer_encoding;
    const char *if_none_match, *range, *if_range, *idempotency_key, *request_id, *expect;
    const char *last_event_id, *accept, *connection;
    const char *accept_encoding, *content_encoding;
    const char *traceparent;   /* NULL also if it is malformed, which W3C says to ignore */
    const char *forwarded_for; /* X-Forwarded-For; means nothing unless the trusted proxy sent it */
    bool repeated;             /* a field that must be sent at most once was sent twice */
};

enum { REQUEST_ID_BYTES = 65 };

struct request {
    struct pen_http *http;
    struct conn *conn;
    enum phase phase;

    int64_t begun_ns;
    char id[REQUEST_ID_BYTES];
    char *text;                      /* the head as it was received, in pieces; later what
                                      * pen_http_request_drop_head keeps of it */
    size_t head_bytes;               /* counted in pen_http.head_bytes for this head */
    const char *raw_target, *method; /* "-" if the head could not be read */
    int minor;                       /* the version is HTTP/1.minor */
    bool head;                       /* the method is HEAD */
    bool close;                      /* nothing may follow it on its connection */
    bool at_once;                    /* it may not wait for a job to change */
    struct pen_address_key client;   /* its address */
    bool client_is_shared;           /* many clients can be behind the address */
    struct fields fields;
    struct pen_target target;
    const struct route *route; /* NULL: refused */
    const char *arg;           /* {id} or {name} of the path */
    char job_id[PEN_ID_BYTES]; /* {id}, in lower case */

    uint64_t declared_bytes; /* Content-Length */
    uint64_t received_bytes; /* of the body, kept or not */
    size_t work_bytes;       /* what it will take, as far as is known: bytes of the body as it
                              * will be parsed (pen_http_request_work), of the picture that is to
                              * be made, or of the answer that is to be compressed */
    struct pen_buf body;
    struct intake_place {
        bool entered; /* intake.h counts it; the thread's that has the request */
        /* Guarded by pen_http.intake_lock, as what follows. */
        bool listed, gives_way, complete;
        struct request *slower, *faster; /* in the list */
        int64_t since_ns;                /* when its window began */
        size_t bytes;                    /* kept */
    } intake;
    enum queue_id queue; /* in which it waits, or whose thread has it */
    bool is_handled;     /* the reply is complete, but for compressing its body */
    bool changed;        /* it has changed the store */
    struct reply reply;
    struct reader_place {                /* see answers.h */
        bool listed;                     /* the loop's: it is a reader of reply.body */
        size_t window_bytes;             /* the loop's: of the body, sent when its window began */
        struct request *previous, *next; /* guarded by the lock of reply.body's memory */
    } reading;
    struct stream *stream; /* of an event stream; NULL: none */

    bool is_probed;       /* of the loop: see pen_http_exchange_probes */
    struct request *next; /* link in the queue or list of the thread that holds it */
    uint64_t last_turn;   /* guarded by the executor's lock: see waiting.c */
    int64_t deadline_ns;  /* of a long poll */
    bool resumed;         /* guarded by the loop's lock: pen_http_resume was called for it */
    bool watched;         /* guarded by the watcher's lock: it is in the watcher's list */
    atomic_bool unwanted; /* nobody waits for its answer: its connection is closed, or to be closed.
                           * atomic: relaxed, it only spares work; where it decides that there is no
                           * answer, the loop's lock orders it */
    bool gone;            /* guarded by the watcher's lock: its client has closed the connection */
};

/* A request with this head; one that cannot be parsed is answered already. Without a head (0 bytes)
 * it is for the caller to answer. Fails: NULL when out of memory. */
struct request *pen_http_request_new(struct pen_http *http, const char *head, size_t bytes);
void pen_http_request_free(struct request *request); /* NULL is allowed */

/* Whether nothing comes of the request but its answer, at least until its handler has made a job.
 */
bool pen_http_request_only_answers(const struct request *request);

/* Frees the head of a request that is answered, but for what the log tells of it: `fields`,
 * `target` and `arg` have nothing else afterwards. Where there is no memory for that, the head
 * stays. Threads: the loop's. */
void pen_http_request_drop_head(struct request *request);

/* Frees the body and gives its bytes back to the intake budget. */
void pen_http_request_drop_body(struct request *request);

/* Answers with an HTTP status that no pen_code has, such as 431, and closes the connection. */
void pen_http_request_refuse(struct request *request, int http_status, const struct pen_status *st);

/* Answers with the problem document of a status. */
void pen_http_request_fail(struct request *request, const struct pen_status *st);

/* The value of a query parameter, which admission has checked. NULL, or `otherwise`: not given. */
const char *pen_http_request_param(const struct request *request, const char *name);
long pen_http_request_number(const struct request *request, const char *name, long otherwise);

/* Answers with a representation; takes the blob. A NULL blob is an allocation that failed.
 * If-None-Match is obeyed, and Range if `ranges` is set. */
struct content {
    struct blob *blob;
    const char *type, *etag, *cache_control;
    bool ranges;
};
void pen_http_request_content(struct request *request, const struct content *content);

#endif
