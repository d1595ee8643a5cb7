/* SPDX-License-Identifier: MIT */
/* Suspending the connection of a request, and resuming it from another thread.
 *
 * libmicrohttpd requires exactly one resume after each suspension. pen_http_suspend and
 * pen_http_resume therefore work with one token, like park and unpark of a thread: if the resume
 * comes first, the next suspension returns at once. So a thread may resume a request whenever it
 * has something for it, without knowing whether the connection is suspended.
 *
 * Executor, watcher and streams call these functions, which call nothing but libmicrohttpd. So
 * those three need not know the adapter, which calls them. */
#ifndef PEN_HTTP_INTERNAL_SUSPEND_H
#define PEN_HTTP_INTERNAL_SUSPEND_H

#include <stdbool.h>

struct request;

/* Suspends the request's connection. Call it in a libmicrohttpd callback only, and before the
 * request is given to another thread. Returns false, without suspending, if a resume came first. */
bool pen_http_suspend(struct request *request);

/* Resumes the connection. The caller must not touch the request afterwards. Locks:
 * pen_http.suspend_lock, and within it one of libmicrohttpd. Threads: any. */
void pen_http_resume(struct request *request);

#endif
