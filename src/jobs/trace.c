/* SPDX-License-Identifier: MIT */
/* Uses only atomic stores and loads, no lock, because a signal handler may call pen_trace_crash. */
#include "jobs/trace.h"

#include <pthread.h>
#include <stdio.h>

void pen_trace_batch(struct pen_trace *trace, const char *job)
{
    snprintf(trace->job, sizeof trace->job, "%s", job);
}

void pen_trace_batch_ended(struct pen_trace *trace, bool proven)
{
    trace->job[0] = '\0';
    if (proven)
        atomic_store_explicit(&trace->proven, true, memory_order_relaxed);
}

void pen_trace_pixel(struct pen_trace *trace, int thread, int x, int y)
{
    if (thread >= PEN_TRACE_THREADS)
        return;
    struct pen_trace_place *place = &trace->place[thread];
    atomic_store_explicit(&place->thread, (uintptr_t)pthread_self(), memory_order_relaxed);
    atomic_store_explicit(&place->pixel, 1 + ((uint64_t)(uint32_t)y << 32 | (uint32_t)x),
                          memory_order_relaxed);
}

void pen_trace_idle(struct pen_trace *trace)
{
    for (int i = 0; i < PEN_TRACE_THREADS; i++)
        atomic_store_explicit(&trace->place[i].pixel, 0, memory_order_relaxed);
}

void pen_trace_crash(struct pen_trace *trace)
{
    uintptr_t self = (uintptr_t)pthread_self();
    for (int i = 0; i < PEN_TRACE_THREADS; i++) {
        if (atomic_load_explicit(&trace->place[i].thread, memory_order_relaxed) == self)
            atomic_store_explicit(&trace->crashed, i + 1, memory_order_relaxed);
    }
}

bool pen_trace_where(const struct pen_trace *trace, int *x, int *y)
{
    int crashed = atomic_load_explicit(&trace->crashed, memory_order_relaxed);
    uint64_t found = 0;
    int count = 0;
    for (int i = 0; i < PEN_TRACE_THREADS; i++) {
        uint64_t pixel = atomic_load_explicit(&trace->place[i].pixel, memory_order_relaxed);
        if (pixel == 0 || (crashed && crashed != i + 1))
            continue;
        found = pixel - 1;
        count++;
    }
    *x = (int)(uint32_t)found;
    *y = (int)(found >> 32);
    return count == 1;
}
