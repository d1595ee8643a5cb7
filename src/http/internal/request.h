/* SPDX-License-Identifier: MIT */
/* One request, from its request line to the end of its answer.
 *
 *   LINE ──admit──► BODY ──► dispatch ────► ANSWERED ──► (sent, freed)
 *     │               │          │            ▲   ▲
 *     │               │          └──► WORK ───┘   │
 *     └───────────────┴──refused──────────────────┘
 *
 * LINE, BODY and ANSWERED belong to the connection's libmicrohttpd thread. WORK belongs to exactly
 * one other thread while the connection is suspended: a thread of the executor, which may pass the
 * request to the watcher. The thread that has resumed a request must not touch it again. */
#ifndef PEN_HTTP_INTERNAL_REQUEST_H
#define PEN_HTTP_INTERNAL_REQUEST_H

#include <stdbool.h>
#include <stdint.h>

#include "access/tokens.h"
#include "base/buf.h"
#include "http/internal/reply.h"
#include "http/internal/routes.h"
#include "http/message.h"
#include "store/store.h"

struct MHD_Connection;
struct pen_http;

/* The phases of a request, as in the diagram. */
enum phase { PHASE_LINE, PHASE_BODY, PHASE_WORK, PHASE_ANSWERED };

/* The header fields that the server reads; NULL: not sent.
 * Owns: libmicrohttpd, as long as the request lives. */
struct fields {
    const char *host, *origin, *content_type, *content_length, *transfer_encoding;
    const char *if_none_match, *range, *if_range, *idempotency_key, *request_id;
    const char *last_event_id, *accept, *authorization;
    const char *accept_encoding, *content_encoding;
    const char *traceparent; /* NULL also if it is malformed: W3C says to ignore it then */
    /* X-Forwarded-For and X-Forwarded-Host; ignored unless the trusted proxy sent them. */
    const char *forwarded_for;
    const char *forwarded_host;
    bool repeated;  /* a field that may be sent only once was sent twice */
    bool malformed; /* a name or a value has a character that is not allowed */
};

enum { REQUEST_ID_BYTES = 65, CLIENT_BYTES = 64 };

struct request {
    struct pen_http *http;
    struct MHD_Connection *connection;
    int fd;
    enum phase phase;

    int64_t begun_ns;
    char id[REQUEST_ID_BYTES];
    const char *method; /* owned as fields are; "-": not known yet */
    bool head;          /* the method is HEAD */
    bool is_http_1_0;
    bool close;                     /* the connection closes after it */
    bool refused_early;             /* answered while its client still sends the body */
    unsigned char address[16];      /* of the client (addresses.h) */
    bool address_is_shared;         /* several clients can have it */
    bool is_from_proxy;             /* the connection is the trusted proxy's */
    bool is_cross_origin;           /* sent by a page of an origin in --cors */
    struct pen_token_holder holder; /* all zero: there are no tokens, or none is needed */
    struct fields fields;
    struct pen_target target;
    const struct route *route; /* NULL: refused */
    const char *arg;           /* {id} or {name} of the path */
    char job_id[PEN_ID_BYTES]; /* {id}, in lower case */

    uint64_t declared_bytes; /* Content-Length */
    uint64_t received_bytes; /* of the body */
    struct pen_buf body;
    size_t counted_bytes; /* bytes of the body that are counted in pen_http.body_bytes */

    bool changed; /* it has changed the store */
    /* The client has gone, so no answer is needed. guarded by the watcher's lock, while the watcher
     * has the request. */
    bool gone;
    struct reply reply;
    struct stream *stream; /* of an event stream; NULL: none */

    struct request *next; /* link in the queue or list that holds it */
    int64_t deadline_ns;  /* of a long poll */
    enum {
        WATCHED_LISTED,  /* in the watcher's list */
        WATCHED_CHECKED, /* the watcher's thread is reading its job */
        WATCHED_LEFT     /* its wait is over */
    } watch;             /* guarded by the watcher's lock, while it has the request */

    char raw_target[];
};

/* Makes a request with this target.
 * Fails: NULL when out of memory. */
struct request *pen_http_request_new(struct pen_http *http, const char *raw_target);
void pen_http_request_free(struct request *request); /* NULL is allowed */

/* Checks request line, header fields and token: the first phase, in admit.c. The request is then in
 * PHASE_BODY. If it is answered already, it is in PHASE_ANSWERED, and its body must not be read.
 * `head_bytes` is the length of the head.
 * Threads: the connection's. */
void pen_http_request_admit(struct request *request, size_t head_bytes);

/* Receives a part of the body. Returns false if the body is too long or memory is missing. The
 * request is then answered, and no more of the body may be read.
 * Threads: the connection's. */
bool pen_http_request_receive(struct request *request, const char *data, size_t bytes);

/* Logs a request that has ended, in access_log.c. The level is info if it changed the store, warn
 * if it failed (5xx other than 503), else debug, so that clients cannot fill the log. Counts
 * refused and failed requests for /metrics. `streamed`: bytes of its event stream. `complete`: the
 * whole answer was sent. */
void pen_http_access_log_add(const struct request *request, uint64_t streamed, bool complete);

/* Gives the request an id: the client's own if it is safe in logs, else a new one. */
void pen_http_request_name(struct request *request);

/* Whether the store is open, so that another thread can answer.
 * Fails: PEN_UNAVAILABLE, with the reason. */
bool pen_http_request_has_store(const struct request *request, struct pen_status *st);

/* Removes from *st the reason why the daemon is not ready, unless the client has a token. */
void pen_http_request_hide_reason(const struct request *request, struct pen_status *st);

/* Suspends the connection until another thread has answered the request.
 * Threads: libmicrohttpd's. */
void pen_http_suspend(struct request *request);

/* Gives a request back to libmicrohttpd. It is answered, or its stream has something to send. The
 * caller must not touch it afterwards.
 * Threads: the one that has the request. */
void pen_http_resume(struct request *request);

/* Counts bytes of the body in memory. If all bodies together would exceed their limit, counts
 * nothing and returns false. */
bool pen_http_request_count_body(struct request *request, size_t bytes);

/* Frees the body and gives its memory back. */
void pen_http_request_drop_body(struct request *request);

/* Answers with the problem document of a status; `http_status` 0: that of its code. */
void pen_http_request_refuse(struct request *request, int http_status, const struct pen_status *st);
enum outcome pen_http_request_fail(struct request *request, const struct pen_status *st);

/* The value of a query parameter, which admission has checked. NULL or `otherwise` if it is not
 * given. */
const char *pen_http_request_param(const struct request *request, const char *name);
long pen_http_request_number(const struct request *request, const char *name, long otherwise);

/* Whether a query parameter is "true". */
bool pen_http_request_is_true(const struct request *request, const char *name);

/* Writes the client's name, "token:NAME" or "address:IP", and returns it. */
const char *pen_http_request_client(const struct request *request, char text[CLIENT_BYTES]);

/* The client whose jobs the request may change, as in pen_http_request_client. NULL: all clients.
 */
const char *pen_http_request_owner(const struct request *request, char text[CLIENT_BYTES]);

/* Answers 200, 304, 206 or 416 with a representation, and takes the blob. A NULL blob stands for a
 * failed allocation. If-None-Match is obeyed, and Range if `ranges` is set. */
struct content {
    struct blob *blob;
    const char *type, *etag, *cache_control;
    bool ranges;
};
enum outcome pen_http_request_content(struct request *request, const struct content *content);

/* Answers with JSON that must not be cached.
 * Owns: takes the reference to `json`; NULL stands for a failed allocation. */
enum outcome pen_http_request_json(struct request *request, int http_status, json_t *json);

#endif
