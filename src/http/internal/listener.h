/* SPDX-License-Identifier: MIT */
/* The listening socket and libmicrohttpd: start, accept, stop. */
#ifndef PEN_HTTP_INTERNAL_LISTENER_H
#define PEN_HTTP_INTERNAL_LISTENER_H

#include <microhttpd.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct listener;
struct pen_http;
struct pen_http_options;

/* Starts the guard (http->guard) and libmicrohttpd; no connection is accepted yet.
 * Owns: pen_http_listener_stop frees.
 * Fails: PEN_UNAVAILABLE, PEN_NO_MEMORY. */
struct listener *pen_http_listener_start(struct pen_http *http,
                                         const struct pen_http_options *options,
                                         struct pen_status *st);

/* Starts the acceptor thread.
 * Fails: PEN_UNAVAILABLE. */
bool pen_http_listener_accept(struct listener *listener, struct pen_status *st);

/* Ends the acceptor thread. No new connections are accepted; existing ones continue. */
void pen_http_listener_stop_accepting(struct listener *listener);

/* Closes all connections and frees the listener and the guard. No connection may be suspended. NULL
 * is allowed. */
void pen_http_listener_stop(struct listener *listener);

/* The callbacks of libmicrohttpd for each request, in adapter.c. cls is the struct pen_http.
 * Threads: those of libmicrohttpd. */

/* Called when the request line was read. Makes the request, which becomes *state below. */
void *pen_http_adapter_on_line(void *cls, const char *uri, struct MHD_Connection *connection);

/* Called once when the head is complete, then for each part of the body, then once more without
 * data; and again after the connection was resumed. */
enum MHD_Result pen_http_adapter_on_access(void *cls, struct MHD_Connection *connection,
                                           const char *url, const char *method, const char *version,
                                           const char *data, size_t *bytes, void **state);

/* Called when the request has ended, whether its answer was sent or not. Frees the request. */
void pen_http_adapter_on_completed(void *cls, struct MHD_Connection *connection, void **state,
                                   enum MHD_RequestTerminationCode why);

#endif
