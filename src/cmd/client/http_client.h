/* SPDX-License-Identifier: MIT */
/* A client of the daemon's HTTP API: one connection, kept open, and one request at a time. A
 * request is sent again, with growing pauses and within a bounded time:
 *   - after a refused connection;
 *   - after 429 and 503, at the time in Retry-After;
 *   - after a broken connection, if sending it twice does no harm (pen_request.repeatable).
 * A certificate is always verified. A redirect is an error, so a token is sent to one server only.
 * Only http_client.c calls libcurl, see curl_library.h. */
#ifndef PEN_CMD_CLIENT_HTTP_CLIENT_H
#define PEN_CMD_CLIENT_HTTP_CLIENT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/buf.h"
#include "base/status.h"
#include "cmd/client/sse.h"
#include "cmd/options.h"

/* The options of all commands that talk to a daemon. PEN_REMOTE_OPTIONS expects a member `remote`
 * of this type in the command's values. */
struct pen_remote {
    const char *server;
    const char *token; /* NULL: the token of the user's file; "": none (token.h) */
    const char *ca;    /* NULL: the system's authorities */
    double retry_seconds;
    bool quiet; /* no warning if the token is sent unencrypted */
};

#define PEN_REMOTE_DEFAULT                                                                         \
    {                                                                                              \
        .server = "http://127.0.0.1:8080", .retry_seconds = 10                                     \
    }

#define PEN_REMOTE_OPTIONS(values)                                                                 \
    PEN_SERVER_OPTION(values, "the daemon, http://HOST:PORT or https://HOST:PORT; "                \
                              "http://127.0.0.1:8080 by default"),                                 \
        PEN_ACCESS_OPTIONS(values)

#define PEN_SERVER_OPTION(values, text)                                                            \
    {                                                                                              \
        .name = "server", .kind = PEN_OPTION_TEXT, .offset = offsetof(values, remote.server),      \
        .value = "URL", .env = "PENUMBRA_URL", .help = text                                        \
    }

#define PEN_ACCESS_OPTIONS(values)                                                                 \
    {.name = "token",                                                                              \
     .kind = PEN_OPTION_TEXT,                                                                      \
     .offset = offsetof(values, remote.token),                                                     \
     .value = "TOKEN",                                                                             \
     .env = "PENUMBRA_TOKEN",                                                                      \
     .help = "the token that identifies this user to the daemon. Other users can read command "    \
             "lines, so better set the environment variable, or write it to "                      \
             "~/.config/penumbra/token with mode 0600"},                                           \
        {.name = "ca",                                                                             \
         .kind = PEN_OPTION_TEXT,                                                                  \
         .offset = offsetof(values, remote.ca),                                                    \
         .value = "FILE",                                                                          \
         .env = "PENUMBRA_CA",                                                                     \
         .help = "the certificate authority of https, in PEM, instead of the system's"},           \
    {                                                                                              \
        .name = "retry", .kind = PEN_OPTION_NUMBER,                                                \
        .offset = offsetof(values, remote.retry_seconds), .value = "SECONDS", .max = 86400,        \
        .help = "how long to try again while the daemon is out of reach or busy, 10 by default"    \
    }

struct pen_client;

/* Makes a client of the daemon at remote->server. Prints a warning if a token is sent unencrypted
 * to another machine.
 * Owns: close it.
 * Fails: PEN_USAGE (URL, the file of --ca), PEN_NETWORK (no libcurl), PEN_NO_MEMORY, and as
 * pen_client_token_find. */
struct pen_client *pen_client_open(const struct pen_remote *remote, struct pen_status *st);
void pen_client_close(struct pen_client *client);

struct pen_request {
    const char *method, *path; /* path with query, "/v1/jobs" */
    const char *body, *type;   /* NULL: none */
    size_t body_bytes;
    const char *idempotency_key; /* NULL: none */
    const char *if_none_match;   /* NULL: none */
    const char *accept;          /* media type; NULL: any */
    bool repeatable;             /* may be sent again after a broken connection */
    int timeout_s;               /* the longest silence before and within the answer */
};

struct pen_reply {
    long status; /* 2xx or 304 */
    struct pen_buf body;
    char etag[128], location[512];
    int retry_after_s; /* 0: none */
};

void pen_reply_release(struct pen_reply *reply);

/* Returns the error code of a problem document, whose type ends in the name of the code:
 * "…/problems/invalid-scene". If the name is unknown, the HTTP status decides. */
enum pen_code pen_problem_code(const json_t *problem, long status);

/* Sends a request and receives the answer. A status of 400 or more is an error, and its problem
 * document becomes *errors. A redirect is an error too.
 * Owns: release *reply in any case.
 * Fails: PEN_NETWORK, PEN_NO_MEMORY, or the code of the problem document. */
bool pen_client_send(struct pen_client *client, const struct pen_request *request,
                     struct pen_reply *reply, struct pen_errors *errors);

/* As pen_client_send, for an answer that is JSON. *json is NULL after 204, 304 and errors.
 * Owns: the caller calls json_decref() for *json. */
bool pen_client_json(struct pen_client *client, const struct pen_request *request,
                     struct pen_reply *reply, json_t **json, struct pen_errors *errors);

/* Reads a stream of events until it ends, in one attempt. It resumes after sse->last_id, and stops
 * after silence_s seconds without a byte. Returns false if there was no stream or it broke.
 * sse->events and sse->last_id are up to date in any case. */
bool pen_client_events(struct pen_client *client, const char *path, struct pen_sse *sse,
                       int silence_s);

/* Called before each pause of a repeated request, with the reason, for a progress note. */
typedef void pen_client_pause_fn(void *user, const char *reason);
void pen_client_on_pause(struct pen_client *client, pen_client_pause_fn *fn, void *user);

/* Appends text to a URL, escaped. Returns false when out of memory. */
bool pen_client_escape(struct pen_client *client, struct pen_buf *url, const char *text);

#endif
