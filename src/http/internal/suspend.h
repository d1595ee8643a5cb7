/* SPDX-License-Identifier: MIT */
/* Suspending the connection of a request, and resuming it from another thread.
 *
 * libmicrohttpd requires exactly one resume after each suspension. pen_http_suspend and
 * pen_http_resume therefore work with one token, like park and unpark of a thread: a resume that
 * comes before its suspension makes that suspension return at once. A thread may resume a request
 * whenever it has something for it, without knowing whether the connection is suspended.
 *
 * All threads that answer requests call this file, and it calls libmicrohttpd alone: this keeps
 * executor, watcher and streams free of the adapter above them. */
#ifndef PEN_HTTP_INTERNAL_SUSPEND_H
#define PEN_HTTP_INTERNAL_SUSPEND_H

#include <stdbool.h>

struct request;

/* Suspends the request's connection. Call it in a libmicrohttpd callback only, and before another
 * thread gets to know the request. Returns false, without suspending, if a resume came first. */
bool pen_http_suspend(struct request *request);

/* Lets the connection go on. The caller must not touch the request afterwards.
 * Locks: pen_http.suspend_lock, and within it one of libmicrohttpd. */
void pen_http_resume(struct request *request);

#endif
