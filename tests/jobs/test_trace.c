/* SPDX-License-Identifier: MIT */
/* The trace of a worker: the pixels of its threads, and the thread that crashed. */
#include <pthread.h>

#include "jobs/trace.h"
#include "support/suite.h"

static struct pen_trace trace;

static void *crash_elsewhere(void *user)
{
    pen_trace_pixel(&trace, *(int *)user, 70000, 3);
    pen_trace_crash(&trace);
    return NULL;
}

START_TEST(test_trace__finds_the_only_rendering_thread)
{
    int x = 1, y = 1;
    ck_assert(!pen_trace_where(&trace, &x, &y));
    pen_trace_pixel(&trace, 5, 0, 0);
    ck_assert(pen_trace_where(&trace, &x, &y));
    ck_assert(x == 0 && y == 0);
    pen_trace_pixel(&trace, 5, 12, 65536);
    ck_assert(pen_trace_where(&trace, &x, &y));
    ck_assert(x == 12 && y == 65536);
    pen_trace_pixel(&trace, 0, 1, 2); /* now two threads render, and either may have crashed */
    ck_assert(!pen_trace_where(&trace, &x, &y));
    pen_trace_idle(&trace);
    ck_assert(!pen_trace_where(&trace, &x, &y));
    pen_trace_pixel(&trace, PEN_TRACE_THREADS, 1, 2); /* one thread more than the trace holds */
    ck_assert(!pen_trace_where(&trace, &x, &y));
}
END_TEST

START_TEST(test_trace__finds_the_crashed_thread)
{
    int x, y, other = 9;
    pthread_t thread;
    pen_trace_pixel(&trace, 0, 1, 2);
    pen_trace_crash(&trace);
    ck_assert(pen_trace_where(&trace, &x, &y));
    ck_assert(x == 1 && y == 2);
    ck_assert_int_eq(pthread_create(&thread, NULL, crash_elsewhere, &other), 0);
    pthread_join(thread, NULL);
    ck_assert(pen_trace_where(&trace, &x, &y));
    ck_assert(x == 70000 && y == 3);
}
END_TEST

PEN_SUITE("trace", test_trace__finds_the_only_rendering_thread,
          test_trace__finds_the_crashed_thread)
