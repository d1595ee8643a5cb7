/* SPDX-License-Identifier: MIT */
/* The HTTP server of the api process: libmicrohttpd in front of the room jobs. There is one route
 * table; api/openapi.yaml defines every route's method, path, parameters and answers, and a test
 * compares the two. Nothing blocks in a libmicrohttpd callback: work on the store runs on a few
 * threads of its own while the connection is suspended. README.md lists the files and threads. */
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
    int idle_seconds;  /* an idle connection is closed after so long; 0: 30 */
    int heartbeat_ms;  /* until a silent event stream gets a heartbeat; 0: 10 s */
};

struct pen_http;

/* Starts serving. Fails: PEN_STORAGE (store), PEN_UNAVAILABLE (sockets). */
struct pen_http *pen_http_start(const struct pen_http_options *options, struct pen_status *st);

/* From now on submits are answered 503 with Retry-After; everything else works as before. */
void pen_http_drain(struct pen_http *http);

/* Sets why /readyz answers 503 although the store takes writes; "": it answers 200. Cut to
 * PEN_MSG_BYTES. */
void pen_http_set_not_ready(struct pen_http *http, const char *reason);

/* Stops: answers waiting long polls, ends event streams, finishes requests in progress and frees
 * everything. NULL is allowed. */
void pen_http_stop(struct pen_http *http);

/* The route table, for tests and documentation: method and path template of entry i, or false
 * past the end. */
bool pen_http_route(int i, const char **method, const char **path);

#endif
