/* SPDX-License-Identifier: MIT */
/* The times of runs: which runs other programs disturbed, and which of two rows is faster.
 *
 * A run is spoiled if other programs took a part of the processors that it could have used. This is
 * so in two cases:
 *
 * - Its threads waited. Their processor time is less than 95 % of the time from their call to their
 *   return. The difference also exceeds 0.5 ms for each thread, and 0.5 ms for the calling thread,
 *   since threads take that long to start and to move. A thread returns when it finds no more work.
 *   So a tree that one thread builds, and a picture of few blocks, do not count as waiting. If
 *   there are more threads than processors, only as many threads as processors are expected to run.
 * - A hypervisor gave more than 5 % of all processors to other machines. One clock tick is
 *   subtracted first, because the kernel counts in ticks.
 *
 * The limit of 5 % is measured: README.md has the figures. A disturbance lengthens a run by about
 * the share that it takes. So a run that is not spoiled is at most about 5 % too long.
 *
 * Without other programs, a run would take at most its time, and at least the share of its time in
 * which it had the processors. Each row has such an interval, over all runs that are not spoiled.
 * Two rows are distinguished if their intervals do not overlap and are PEN_LEAST_EFFECT apart. */
#ifndef PEN_STUDY_RUN_TIME_H
#define PEN_STUDY_RUN_TIME_H

#include "render/render.h"

/* How often a study repeats a spoiled run, and the most runs of a row whose times are used. */
enum { PEN_SPOILED_REPEATS = 2, PEN_RUN_TIMES_MAX = 128 };

/* The smallest relative difference of times that counts. */
#define PEN_LEAST_EFFECT 0.02

/* How much of the processors a run got. */
struct pen_run_use {
    double used;     /* processor time of its threads, divided by what they could have used */
    double steal_ms; /* steal time of all processors (pen_host_steal_ms); below 0: unknown */
    bool spoiled;
};

/* A run in progress. */
struct pen_run_watch {
    int64_t begun_ns;
    double steal_ms;
};
/* Begins a run. */
struct pen_run_watch pen_run_begin(void);

/* Ends a run. `stats` are those of its renders. alone_ms is the time in which the calling thread
 * worked alone, and alone_cpu_ms its processor time in it. */
struct pen_run_use pen_run_end(const struct pen_run_watch *watch,
                               const struct pen_render_stats *stats, double alone_ms,
                               double alone_cpu_ms);

/* The time of one run of a row. */
struct pen_run_time {
    double ms, used;
    bool spoiled;
};

/* The times of a row, over its runs that are not spoiled; over all runs if every run is spoiled.
 * Units: ms. */
struct pen_row_time {
    double median, min, max;
    double alone; /* the shortest time that a run would take without other programs */
    int runs, spoiled;
};
struct pen_row_time pen_row_time_of(const struct pen_run_time *runs, int count);

/* Compares the times of two rows. Below 0: a is faster. Above 0: b is faster. 0: they are not
 * distinguished. */
int pen_row_time_compare(const struct pen_row_time *a, const struct pen_row_time *b);

/* The number of rays of all kinds. */
uint64_t pen_rays_total(const struct pen_ray_counts *rays);

/* As pen_row_time_compare, but the number of rays decides where the times do not. */
int pen_row_cost_compare(const struct pen_row_time *a, const struct pen_ray_counts *a_rays,
                         const struct pen_row_time *b, const struct pen_ray_counts *b_rays);

/* A summary of all timed runs of a study. */
struct pen_runs_use {
    int runs, spoiled;
    double used; /* the mean of the runs' `used` */
};
/* Adds runs to a summary. */
void pen_runs_use_add(struct pen_runs_use *sum, const struct pen_run_time *runs, int count);

/* Whether over half of the runs are spoiled, so that their times prove nothing. */
static inline bool pen_runs_spoiled(const struct pen_runs_use *use)
{
    return 2 * use->spoiled > use->runs;
}

#endif
