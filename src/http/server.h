/* SPDX-License-Identifier: MIT */
/* The HTTP server of the api process: libmicrohttpd in front of pen/jobs. One route table; every
 * route's method, path, parameters and answers are in api/openapi.yaml, and a test holds the two
 * against each other. Nothing blocks in a libmicrohttpd callback: store work runs on a small pool
 * of store threads while the connection is suspended. */
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
    int store_threads; /* 0: a sensible number */
    int idle_seconds;  /* a connection on which nothing happens is closed; 0: 30 */
    int beat_ms;       /* between heartbeats of a silent event stream; 0: 10 s */
};

struct pen_http;

/* Starts serving. Fails: PEN_STORAGE (store), PEN_UNAVAILABLE (sockets). */
struct pen_http *pen_http_start(const struct pen_http_options *options, struct pen_status *st);

/* From now on submits are answered 503 with Retry-After; everything else goes on. */
void pen_http_drain(struct pen_http *http);

/* Says why the daemon is not ready although its store is, for /readyz; "" when it is. Cut to
 * PEN_MSG_BYTES. */
void pen_http_note(struct pen_http *http, const char *trouble);

/* Stops: answers waiting long polls, ends event streams, finishes requests in progress, frees
 * everything. */
void pen_http_stop(struct pen_http *http);

/* The route table, for tests and documentation: method and path template of entry i, or false
 * past the end. */
bool pen_http_route(int i, const char **method, const char **path);

#endif
