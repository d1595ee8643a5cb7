/* SPDX-License-Identifier: MIT */
/* One request, from its request line to the end of its answer.
 *
 *   LINE ──admit──► BODY ───────────────────────► dispatch ──► ANSWERED ──► (sent, freed)
 *     │               │ no room: budget              │            ▲
 *     │               ▼                              ▼            │ wake
 *     └─refused──► SWALLOW (read and drop) ──►       HELD ────────┘
 *
 * LINE, BODY, SWALLOW and ANSWERED belong to the connection's libmicrohttpd thread. HELD belongs
 * to exactly one other thread: a store thread, which may pass it to the watcher. The hand-over is
 * pen_http_adapter_hold and pen_http_adapter_wake; whoever woke a request must not touch it any
 * more. */
#ifndef PEN_HTTP_INTERNAL_REQUEST_H
#define PEN_HTTP_INTERNAL_REQUEST_H

#include <stdbool.h>
#include <stdint.h>

#include "base/buf.h"
#include "http/internal/reply.h"
#include "http/message.h"
#include "store/store.h"

struct MHD_Connection;
struct pen_http;
struct route;

enum phase { PHASE_LINE, PHASE_BODY, PHASE_SWALLOW, PHASE_HELD, PHASE_ANSWERED };

/* Header fields that somebody looks at. Owns: libmicrohttpd, as long as the request lives. */
struct fields {
    const char *host, *origin, *content_type, *content_length, *transfer_encoding;
    const char *if_none_match, *range, *if_range, *idempotency_key, *request_id, *expect;
    const char *last_event_id, *accept;
    bool repeated; /* one of those that must be single came twice */
};

enum { REQUEST_ID_BYTES = 65 };

struct request {
    struct pen_http *http;
    struct MHD_Connection *connection;
    enum phase phase;
    bool held, woken; /* guarded by the adapter's parking lock */

    int64_t begun_ns;
    char id[REQUEST_ID_BYTES];
    char *raw_target;
    const char *method; /* as fields */
    bool head;
    struct fields fields;
    struct pen_target target;
    const struct route *route; /* NULL: refused */
    const char *arg;           /* {id} or {name} of the path */
    char job_id[PEN_ID_BYTES]; /* {id}, in lower case */

    uint64_t declared_bytes; /* Content-Length */
    uint64_t received_bytes; /* of the body, kept or not */
    struct pen_buf body;
    struct reply reply;
    struct stream *stream; /* an answer that goes on; NULL: none */

    struct request *next; /* link in the queue or list of the thread that holds it */
    int64_t deadline_ns;  /* of a long poll */
};

/* A request whose line is `raw_target`. Fails: NULL when out of memory. */
struct request *pen_http_request_new(struct pen_http *http, const char *raw_target);
void pen_http_request_free(struct request *request); /* NULL is allowed */

/* Looks at line and fields. Afterwards the request is in BODY; or, refused, in SWALLOW if its body
 * is to be read before the answer, else in ANSWERED. */
void pen_http_request_admit(struct request *request);

/* Takes a part of the body. False if there is more of it than may be: drop the connection. */
bool pen_http_request_receive(struct request *request, const char *data, size_t bytes);

/* Drops the body and gives its bytes back to the intake budget. */
void pen_http_request_drop_body(struct request *request);

/* Answers with the problem that the status says. */
void pen_http_request_fail(struct request *request, const struct pen_status *st);

/* A query parameter, checked by admission. */
const char *pen_http_request_param(const struct request *request, const char *name);
long pen_http_request_number(const struct request *request, const char *name, long otherwise);

/* Answers with a representation; takes the blob, NULL being an allocation that failed.
 * Conditions are honoured, ranges too where the resource has them. */
struct content {
    struct blob *blob;
    const char *type, *etag, *cache_control;
    bool ranges;
};
void pen_http_request_content(struct request *request, const struct content *content);

#endif
