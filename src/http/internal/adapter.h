/* SPDX-License-Identifier: MIT */
/* Everything that touches libmicrohttpd: its threads, the callbacks, and parking.
 *
 * Parking. A connection that waits for another thread is suspended; only one resume may follow
 * each suspension. pen_http_adapter_hold and pen_http_adapter_wake are a park and an unpark with
 * one token: a wake that comes before its hold makes that hold return at once. So a thread may wake
 * a request whenever it has news, without knowing whether the connection sleeps. */
#ifndef PEN_HTTP_INTERNAL_ADAPTER_H
#define PEN_HTTP_INTERNAL_ADAPTER_H

#include <stdbool.h>

#include "base/status.h"

struct adapter;
struct pen_http;
struct request;

/* Fails: PEN_UNAVAILABLE. */
struct adapter *pen_http_adapter_start(struct pen_http *http, int listen_fd, int idle_seconds,
                                       struct pen_status *st);

/* Begins to take connections, once http->adapter is set. Fails: PEN_UNAVAILABLE. */
bool pen_http_adapter_accept(struct adapter *adapter, struct pen_status *st);

/* No new connections; those that exist go on. */
void pen_http_adapter_stop_accepting(struct adapter *adapter);

/* Closes all connections and frees. No request may be held. NULL is allowed. */
void pen_http_adapter_stop(struct adapter *adapter);

/* Suspends the request's connection. To be called in a libmicrohttpd callback only, and before
 * another thread gets to know the request. False if a wake was waiting: not suspended then. */
bool pen_http_adapter_hold(struct request *request);

/* Lets the connection go on. The caller must not touch the request afterwards.
 * Locks: the parking lock, and within it one of libmicrohttpd. */
void pen_http_adapter_wake(struct request *request);

#endif
