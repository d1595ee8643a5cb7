/* SPDX-License-Identifier: MIT */
/* The HTTP server of the api process, in front of the room jobs. There is one route table;
 * api/openapi.yaml defines every route's method, path, parameters and answers, and a test compares
 * the two. Connections are served by a few threads that never block: work on the store runs on
 * threads of its own. README.md lists the files and threads. */
#ifndef PEN_HTTP_SERVER_H
#define PEN_HTTP_SERVER_H

#include <stdatomic.h>
#include <stdbool.h>

#include "base/status.h"
#include "io/scene_json.h"

struct pen_http_options {
    int listen_fd; /* a listening socket; stays the caller's, and becomes non-blocking */
    const char *store_url;
    struct pen_limits limits;
    int store_threads; /* 0: 4 */
    int idle_seconds;  /* time after which an idle connection is closed; 0: 30. The times for a head
                        * and for the beginning of a body are 10 s, and not longer than this */
    int connections;   /* open at once; 0: 8192. Not more than the process may open files */
    int waiting_per_address;   /* long polls of one client's address, and streams; 0: 32 */
    const char *trusted_proxy; /* a numeric address, whose waiting requests are not counted, and
                                * whose X-Forwarded-For names the client; NULL: none */
    const char *tokens;        /* the token file; NULL: everybody may do everything */
    const char *tls_cert;      /* a certificate as PEM, for HTTPS; NULL: plain HTTP */
    const char *tls_key;       /* its private key as PEM; NULL: none */
    const char *cors;          /* origins of web pages that may use the server, with spaces between
                                * them; NULL: none */
    bool count_loopback;       /* count the requests of loopback addresses too */
    int heartbeat_ms; /* time after which a silent event stream gets a heartbeat; 0: 10 s */
};

struct pen_http;

/* Whether a text is a numeric IPv4 or IPv6 address. */
bool pen_http_is_address(const char *text);

/* Starts serving. Owns: stop with pen_http_stop; the strings in options may go after the call.
 * Fails: PEN_STORAGE (store), PEN_UNAVAILABLE (sockets, threads), PEN_NO_MEMORY. */
struct pen_http *pen_http_start(const struct pen_http_options *options, struct pen_status *st);

/* From now on submits are answered 503 with Retry-After; everything else works as before. Threads:
 * any. */
void pen_http_drain(struct pen_http *http);

/* Sets the reason for which /readyz answers 503 although the store takes writes. With "" /readyz
 * answers 200 again. The reason is cut to PEN_MSG_BYTES. Threads: any. */
void pen_http_set_not_ready(struct pen_http *http, const char *reason);

/* Stops: answers waiting long polls, ends event streams, finishes requests in progress (1.5 seconds
 * at most) and frees everything. NULL is allowed. */
void pen_http_stop(struct pen_http *http);

/* Reads the route table, for tests: method and path template of entry i. Returns false past the
 * end. */
bool pen_http_route(int i, const char **method, const char **path);

#endif
