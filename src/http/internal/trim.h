/* SPDX-License-Identifier: MIT */
/* Gives memory back to the system when many connections have closed.
 *
 * What many clients held at once was taken in small blocks between others, so the allocator keeps
 * its pages. To give them back takes a while, and other threads wait meanwhile for the allocator,
 * so a thread of its own does it, some seconds after the last time at the earliest.
 *
 * Threads: any, except start and stop. */
#ifndef PEN_HTTP_INTERNAL_TRIM_H
#define PEN_HTTP_INTERNAL_TRIM_H

#include "base/status.h"

struct trim;

/* Owns: stop frees. Fails: PEN_UNAVAILABLE, PEN_NO_MEMORY. */
struct trim *pen_http_trim_start(struct pen_status *st);
/* Ends the thread and frees it. No connection may be open. NULL is allowed. */
void pen_http_trim_stop(struct trim *trim);

/* A connection has closed. */
void pen_http_trim_note(struct trim *trim);

#endif
