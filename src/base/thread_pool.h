/* SPDX-License-Identifier: MIT */
/* A pool of threads that run one function in parallel: rendering, and other work that can use all
 * cores.
 *
 * Threads: one run at a time per pool. During a run each thread's floating-point unit is in its
 * default state (round to nearest, gradual underflow, no traps). The state of the thread that made
 * the pool does not matter. Other rounding would give another picture. */
#ifndef PEN_BASE_THREAD_POOL_H
#define PEN_BASE_THREAD_POOL_H

#include <stdint.h>

#include "base/status.h"

struct pen_thread_pool;

/* Starts exactly `threads` threads (0: one per processor), which the pool keeps for its lifetime.
 * Owns: free with pen_thread_pool_free.
 * Fails: NULL; PEN_NO_MEMORY. */
struct pen_thread_pool *pen_thread_pool_new(int threads, struct pen_status *st);
void pen_thread_pool_free(struct pen_thread_pool *pool);

/* The number of threads. */
int pen_thread_pool_size(const struct pen_thread_pool *pool);

/* The work of one thread; `index` numbers the threads of this run from 0. */
typedef void pen_thread_pool_work(void *user, int index);

/* Calls work(user, i) for i = 0 .. threads - 1, each on its own thread, and returns when all calls
 * have returned. threads is 1 .. pen_thread_pool_size(pool). Returns the number of threads whose
 * floating-point state was not the default: before the run, which resets it, or after the run, if
 * its work changed it. */
int pen_thread_pool_run(struct pen_thread_pool *pool, int threads, pen_thread_pool_work *work,
                        void *user);

/* pen_thread_pool_mark records the processor time that each thread has used. pen_thread_pool_most
 * returns the largest processor time of a thread since then, in ns.
 * Threads: any, one at a time. */
void pen_thread_pool_mark(struct pen_thread_pool *pool);
int64_t pen_thread_pool_most_ns(const struct pen_thread_pool *pool);

#endif
