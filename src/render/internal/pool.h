/* SPDX-License-Identifier: MIT */
/* Runs one function on several threads of a pool at once. */
#ifndef PEN_RENDER_INTERNAL_POOL_H
#define PEN_RENDER_INTERNAL_POOL_H

#include "render/render.h"

/* Work for one thread; `index` counts the threads of this run from 0. The thread's floating-point
 * unit is in its default state: round to nearest, gradual underflow, no traps. */
typedef void pen_pool_work(void *user, int index);

/* Calls work(user, 0 .. threads - 1), each on a thread of its own, and returns when all have
 * returned. threads is 1 .. pen_pool_threads(pool). One run at a time.
 * Returns the number of threads whose state was another one before the run, where it is reset, or
 * after it: then something in the run has changed it. */
int pen_pool_run(struct pen_pool *pool, int threads, pen_pool_work *work, void *user);

#endif
