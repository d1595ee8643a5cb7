/* SPDX-License-Identifier: MIT */
/* A client of the daemon's HTTP API: one connection, kept open, requests one after the other.
 * What can be repeated safely is repeated: a refused connection, 429 and 503 (after Retry-After),
 * and for requests without or with idempotent effect also a connection that broke; with growing
 * pauses, within a bounded time. libcurl is seen in client.c only. */
#ifndef PEN_CMD_CLIENT_HTTP_CLIENT_H
#define PEN_CMD_CLIENT_HTTP_CLIENT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"
#include "cmd/client/sse.h"
#include "cmd/options.h"

/* What all commands that talk to a daemon take. The rows expect a field `remote` of this type. */
struct pen_remote {
    const char *server, *token;
    double retry_seconds;
};

#define PEN_REMOTE_DEFAULT                                                                         \
    {                                                                                              \
        .server = "http://127.0.0.1:8080", .retry_seconds = 10                                     \
    }

#define PEN_REMOTE_OPTIONS(values)                                                                 \
    {.name = "server",                                                                             \
     .kind = PEN_OPTION_TEXT,                                                                      \
     .offset = offsetof(values, remote.server),                                                    \
     .value = "URL",                                                                               \
     .env = "PENUMBRA_URL",                                                                        \
     .help = "the daemon, http://127.0.0.1:8080 by default"},                                      \
        {.name = "token",                                                                          \
         .kind = PEN_OPTION_TEXT,                                                                  \
         .offset = offsetof(values, remote.token),                                                 \
         .value = "TOKEN",                                                                         \
         .env = "PENUMBRA_TOKEN",                                                                  \
         .help = "sent as a bearer token; better given by the environment, since command lines "   \
                 "are public"},                                                                    \
    {                                                                                              \
        .name = "retry", .kind = PEN_OPTION_NUMBER,                                                \
        .offset = offsetof(values, remote.retry_seconds), .value = "SECONDS", .max = 86400,        \
        .help = "how long to go on trying while the daemon is out of reach or busy, 10 by default" \
    }

struct pen_client;

/* A client of the daemon at remote->server. Owns: close it. Fails: PEN_USAGE (URL),
 * PEN_NO_MEMORY. */
struct pen_client *pen_client_open(const struct pen_remote *remote, struct pen_status *st);
void pen_client_close(struct pen_client *client);

struct pen_request {
    const char *method, *path; /* path with query, "/v1/jobs" */
    const char *body, *type;   /* NULL: none */
    size_t body_bytes;
    const char *idempotency_key; /* NULL: none */
    const char *if_none_match;   /* NULL: none */
    const char *accept;          /* media type; NULL: any */
    bool repeatable;             /* may be sent again after a connection that broke */
    int timeout_s;               /* how long the answer may take to begin */
};

struct pen_reply {
    long status; /* 2xx or 304 */
    struct pen_buf body;
    char etag[128], location[512];
    int retry_after_s; /* 0: none */
};

void pen_reply_release(struct pen_reply *reply);

/* Sends and receives. An answer of 400 or more is an error: its problem document becomes *errors.
 * Owns: release *reply in any case. Fails: PEN_NETWORK, or what the daemon said. */
bool pen_client_send(struct pen_client *client, const struct pen_request *request,
                     struct pen_reply *reply, struct pen_errors *errors);

/* As pen_client_send, for an answer that is JSON. Owns: *json; the caller json_decref()s. */
bool pen_client_json(struct pen_client *client, const struct pen_request *request,
                     struct pen_reply *reply, json_t **json, struct pen_errors *errors);

/* Follows a stream of events until it ends; once, without a second attempt.
 * Returns false when there was no stream, or it broke; sse->events and sse->last_id tell how far
 * it came. */
bool pen_client_events(struct pen_client *client, const char *path, struct pen_sse *sse,
                       int silence_s);

/* Called before each pause of a repeated request, with the reason; for a note to people. */
typedef void pen_client_pause_fn(void *user, const char *reason);
void pen_client_on_pause(struct pen_client *client, pen_client_pause_fn *fn, void *user);

/* Appends text to a URL, escaped. Returns false when out of memory. */
bool pen_client_escape(struct pen_client *client, struct pen_buf *url, const char *text);

#endif
