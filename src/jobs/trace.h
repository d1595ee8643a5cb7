/* SPDX-License-Identifier: MIT */
/* What a worker is doing, in memory shared with the supervisor, which outlives the worker. It has
 * the pixel of each render thread, the thread that crashed, the last lines of the log, and the job
 * of the current batch. All bytes are zero at first. The worker writes it. The supervisor reads it,
 * to report why the worker died and whether a job was the reason.
 *
 * Threads: each render thread writes only its own place. All fields but `job` are atomic and
 * relaxed, because the reader needs the last state only roughly. */
#ifndef PEN_JOBS_TRACE_H
#define PEN_JOBS_TRACE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/log.h"
#include "store/store.h"

enum { PEN_TRACE_THREADS = 256 };

struct pen_trace_place {
    atomic_uintptr_t thread;    /* pthread_self() of the thread; 0: none */
    atomic_uint_fast64_t pixel; /* 1 + (y << 32 | x); 0: no pixel */
};

struct pen_trace {
    atomic_int crashed; /* 1 + the number of the thread that crashed; 0: unknown */
    struct pen_trace_place place[PEN_TRACE_THREADS]; /* by the number of the render thread */
    struct pen_log_ring log;
    char job[PEN_ID_BYTES]; /* "": no batch. The worker's own thread writes it; the supervisor reads
                               it after the worker has ended */
    atomic_bool proven;     /* a batch has ended well, so the worker itself works */
};

/* Notes that work on a batch of this job begins. */
void pen_trace_batch(struct pen_trace *trace, const char *job);

/* Notes that work on a batch has ended. `proven`: the store has its result. */
void pen_trace_batch_ended(struct pen_trace *trace, bool proven);

/* Notes that a thread is about to begin a pixel. */
void pen_trace_pixel(struct pen_trace *trace, int thread, int x, int y);

/* Notes that no thread is rendering a pixel. */
void pen_trace_idle(struct pen_trace *trace);

/* Notes that the calling thread has crashed. May be called in a signal handler. */
void pen_trace_crash(struct pen_trace *trace);

/* Sets *x and *y to the pixel of the thread that crashed. If this thread is not known, to the pixel
 * of the only thread that was rendering. Returns false if neither is known. */
bool pen_trace_where(const struct pen_trace *trace, int *x, int *y);

#endif
