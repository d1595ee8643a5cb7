/* SPDX-License-Identifier: MIT */
/* The memory for bodies, and which body gives way to another when it is used up.
 *
 * A body that is being received is in the list from its first kept byte until it is complete. Each
 * window of it (loop.h) begins at the end of the list, so the first one is the slowest. When the
 * memory is used up, slow bodies are told to give way, the slowest first: their loops answer them
 * with 503. Until they have, a body may be kept in their place, beyond the limit.
 *
 * A complete body gives way to none, and may have to wait for those before it. So large ones take
 * half of the memory at most: the next is refused. And small ones have a reserve beyond it.
 *
 * Locks: pen_http.intake_lock, and a loop's lock within it. */
#ifndef PEN_HTTP_INTERNAL_INTAKE_H
#define PEN_HTTP_INTERNAL_INTAKE_H

#include <stdbool.h>
#include <stddef.h>

struct request;

enum { INTAKE_SMALL = 64 << 10 }; /* bytes; larger bodies take some milliseconds to parse */

/* Keeps a part of a body. Returns false, with nothing kept, if there is no memory for it. Threads:
 * the loop's. */
bool pen_http_intake_keep(struct request *request, const void *data, size_t bytes);

/* A window of the body begins. Threads: the loop's. */
void pen_http_intake_begin_window(struct request *request);

/* The body is complete. Returns false if it was told to give way, or would be too much beside the
 * large bodies that are complete; it is then to be dropped. Threads: the loop's. */
bool pen_http_intake_complete(struct request *request);

/* The body is dropped. Threads: the one that has the request. */
void pen_http_intake_leave(struct request *request);

#endif
