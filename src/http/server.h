/* SPDX-License-Identifier: MIT */
/* The HTTP server of the api process, in front of the module jobs. There is one route table.
 * api/openapi.yaml defines every route's method, path, parameters and answers; a test compares the
 * two. libmicrohttpd serves the connections with a few threads that never block. Work on the store
 * runs on other threads. README.md lists the files and threads. */
#ifndef PEN_HTTP_SERVER_H
#define PEN_HTTP_SERVER_H

#include <stdatomic.h>
#include <stdbool.h>

#include "base/status.h"
#include "io/scene_json.h"

/* The options of a server. */
struct pen_http_options {
    int listen_fd; /* a listening socket, which becomes non-blocking; the caller closes it */
    const char *store_url;
    struct pen_limits limits;
    /* Time after which an idle connection is closed; 0: 30. The deadlines of heads, bodies and
     * readers are not longer than this. */
    int idle_seconds;
    int connections; /* open at once; 0: 8192. At most the number of files that the process may open
                      */
    /* A numeric address, whose X-Forwarded-For and X-Forwarded-Host are used; NULL: none. */
    const char *trusted_proxy;
    int heartbeat_ms;   /* time after which a silent event stream gets a heartbeat; 0: 10 s */
    const char *tokens; /* a token file; NULL: everybody may do everything */
    const char *tls_cert, *tls_key; /* PEM files; NULL: plain HTTP */
    /* Called by any thread when the store has an I/O error. This process cannot rely on the store
     * after that; a new process can. May be called often. NULL: nothing happens. */
    void (*broken)(void *user, const struct pen_status *why);
    void *broken_user;
    const char *cors; /* origins whose pages may use the API, separated by spaces; NULL: none */
};

struct pen_http;

/* Whether a text is a numeric IPv4 or IPv6 address. */
bool pen_http_is_address(const char *text);

/* Starts serving, without the store. Requests that need the store are answered 503 until
 * pen_http_open has opened it.
 * Owns: stop with pen_http_stop; the strings in options are not needed after the call.
 * Fails: PEN_UNAVAILABLE (sockets, threads), PEN_NO_MEMORY; as pen_tokens_open and pen_tls_open. */
struct pen_http *pen_http_start(const struct pen_http_options *options, struct pen_status *st);

/* Opens the store, once. May be tried again after a failure, whose reason clients get.
 * Threads: the one that called pen_http_start.
 * Fails: as pen_jobs_open; PEN_UNAVAILABLE (threads), PEN_NO_MEMORY. */
bool pen_http_open(struct pen_http *http, const struct pen_http_options *options,
                   struct pen_status *st);

/* Answers all later submits 503 with Retry-After. All other requests work as before.
 * Threads: any. */
void pen_http_drain(struct pen_http *http);

/* Sets the reason for which /readyz answers 503, even if the store takes writes. With "", /readyz
 * answers 200 again. The reason is cut to PEN_MSG_BYTES.
 * Threads: any. */
void pen_http_set_not_ready(struct pen_http *http, const char *reason);

/* Stops the server: answers waiting long polls, ends event streams, finishes requests in progress
 * (within 1.5 seconds) and frees everything. NULL is allowed. */
void pen_http_stop(struct pen_http *http);

/* Reads the route table, for tests: method and path template of entry i, and the scope that it
 * needs (access/token_file.h). Returns false past the end. */
bool pen_http_route(int i, const char **method, const char **path, int *scope);

#endif
