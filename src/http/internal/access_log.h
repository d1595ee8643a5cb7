/* SPDX-License-Identifier: MIT */
/* What the log says of requests. Clients decide how many there are, but not how fast the log grows:
 * above level debug it gets some 600 lines in a minute, of 1000 bytes at most.
 *   - Of requests that were refused for load (429, 503) the first in a minute is a line at level
 *     warn, and of those that failed (other 5xx) the first ten.
 *   - Of others that have changed the store the first 600 in a minute are lines at level info.
 *   - For each of these kinds one line more tells how many others there were: it comes with the
 *     first request after that minute, or with the end.
 *   - All others are lines at level debug.
 * Threads: any. */
#ifndef PEN_HTTP_INTERNAL_ACCESS_LOG_H
#define PEN_HTTP_INTERNAL_ACCESS_LOG_H

#include <stdbool.h>
#include <stdint.h>

struct access_log;
struct request;

/* The most that a line has of a request's method and target. */
enum { LOGGED_METHOD_BYTES = 20, LOGGED_TARGET_BYTES = 300 };

/* Fails: NULL when out of memory. */
struct access_log *pen_http_access_log_new(void);
/* Tells what is not told yet, and frees it. NULL is allowed. */
void pen_http_access_log_free(struct access_log *log);

/* Logs a request that has ended. `streamed`: bytes of its event stream; complete: the whole answer
 * was sent. */
void pen_http_access_log_add(struct access_log *log, const struct request *request,
                             uint64_t streamed, bool complete);

/* How many requests this process has refused and failed. Those whose clients had gone are not
 * counted. */
struct access_counts {
    uint64_t refused_429, refused_503, failed;
};
struct access_counts pen_http_access_log_counts(const struct access_log *log);

#endif
