/* SPDX-License-Identifier: MIT */
/* What a worker is at, in memory that can be shared with another process and outlives the worker:
 * where each render thread is, which of them crashed, the last lines of the log. All zeros at
 * first. Written by the worker, read by whoever is to say what it died of.
 *
 * Threads: a place is written by its render thread alone; all fields are atomic and relaxed, since
 * a reader wants only to know about where things stood. */
#ifndef PEN_JOBS_TRACE_H
#define PEN_JOBS_TRACE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/log.h"

enum { PEN_TRACE_THREADS = 256 };

struct pen_trace_place {
    atomic_uintptr_t thread;    /* pthread_self() of the thread; 0: none */
    atomic_uint_fast64_t pixel; /* 1 + (y << 32 | x); 0: at none */
};

struct pen_trace {
    atomic_int crashed; /* 1 + the number of the thread that crashed; 0: unknown */
    struct pen_trace_place place[PEN_TRACE_THREADS]; /* by number of the render thread */
    struct pen_log_ring log;
};

/* Notes that a thread is about to begin a pixel. */
void pen_trace_pixel(struct pen_trace *trace, int thread, int x, int y);

/* Notes that no thread is at any. */
void pen_trace_idle(struct pen_trace *trace);

/* Notes that the calling thread has crashed. May be called in a signal handler. */
void pen_trace_crash(struct pen_trace *trace);

/* Where the thread that crashed was, or, if it is not known which did, the only one that was
 * anywhere. Returns false if that is not known either. */
bool pen_trace_where(const struct pen_trace *trace, int *x, int *y);

#endif
