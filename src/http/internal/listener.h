/* SPDX-License-Identifier: MIT */
/* The listening socket and libmicrohttpd: start, accept, stop. */
#ifndef PEN_HTTP_INTERNAL_LISTENER_H
#define PEN_HTTP_INTERNAL_LISTENER_H

#include <stdbool.h>

#include "base/status.h"

struct listener;
struct pen_http;
struct pen_http_options;

/* Starts the guard (http->guard) and libmicrohttpd; no connection is accepted yet. Owns:
 * pen_http_listener_stop frees. Fails: PEN_UNAVAILABLE, PEN_NO_MEMORY. */
struct listener *pen_http_listener_start(struct pen_http *http,
                                         const struct pen_http_options *options,
                                         struct pen_status *st);

/* Starts the acceptor thread. Fails: PEN_UNAVAILABLE. */
bool pen_http_listener_accept(struct listener *listener, struct pen_status *st);

/* Ends the acceptor thread. No new connections are accepted; those that exist go on. */
void pen_http_listener_stop_accepting(struct listener *listener);

/* Closes all connections and frees the listener and the guard. No connection may be suspended. NULL
 * is allowed. */
void pen_http_listener_stop(struct listener *listener);

#endif
