/* SPDX-License-Identifier: MIT */
/* The time of a run, and what it is worth: whether others used the processors meanwhile, and which
 * of two rows is quicker.
 *
 * A run is spoiled if others had a part of the processors that it could have used:
 *
 * - its threads waited: their processor time is less than 95 % of the time from their call to their
 *   return, and that by 0.5 ms for each, within which threads wake up and are moved. A thread that
 *   finds no more work returns, so neither a tree that one thread builds nor a picture of few
 *   blocks counts as waiting. Of more threads than there are processors, those that have one count.
 * - a hypervisor gave more than 5 % of all processors to others, and a clock tick besides, since
 *   the kernel counts in ticks.
 *
 * 5 %: while nothing else ran, runs of 2 to 55 ms on 2 cores had 0.98 to 0.999 of their time, and
 * beside a busy loop 0.50 (README.md of this room). What is taken from a run lengthens it by about
 * the same share, so a run that is not spoiled was disturbed by 5 % at most.
 *
 * Alone, a run would have taken no longer than it did, and no less than the share of its time in
 * which it had the processors. Two rows are distinguished if these intervals, over all runs of each
 * that are not spoiled, lie apart. */
#ifndef PEN_STUDY_RUN_TIME_H
#define PEN_STUDY_RUN_TIME_H

#include "render/render.h"

/* How often a study repeats a run that is spoiled; the most runs of a row whose times are kept. */
enum { PEN_SPOILED_REPEATS = 2, PEN_RUN_TIMES_MAX = 128 };

/* The smallest difference of times that counts, as a share. */
#define PEN_LEAST_EFFECT 0.02

/* What a run had of the processors. */
struct pen_run_use {
    double used;     /* the processor time of its threads over what they could have used */
    double steal_ms; /* of all processors, given to others by a hypervisor; below 0: unknown */
    bool spoiled;
};

/* A run that goes on. */
struct pen_run_watch {
    int64_t begun_ns;
    double steal_ms;
};
struct pen_run_watch pen_run_begin(void);

/* What a run had that ends now. `stats` is of its renders; besides, the calling thread has worked
 * alone for so long, and had so much processor time. */
struct pen_run_use pen_run_end(const struct pen_run_watch *watch,
                               const struct pen_render_stats *stats, double alone_ms,
                               double alone_cpu_ms);

/* One run of a row. */
struct pen_run_time {
    double ms, used;
    bool spoiled;
};

/* The times of a row: of the runs that are not spoiled, or of all if every one is. Units: ms. */
struct pen_row_time {
    double median, min, max;
    double alone; /* the least that a run would have taken alone */
    int runs, spoiled;
};
struct pen_row_time pen_row_time_of(const struct pen_run_time *runs, int count);

/* Which row is quicker: below 0 if it is a, above 0 if it is b; 0 if they are not distinguished. */
int pen_row_time_compare(const struct pen_row_time *a, const struct pen_row_time *b);

uint64_t pen_rays_total(const struct pen_ray_counts *rays);

/* The same, but rows that times do not distinguish are distinguished by their rays. */
int pen_row_cost_compare(const struct pen_row_time *a, const struct pen_ray_counts *a_rays,
                         const struct pen_row_time *b, const struct pen_ray_counts *b_rays);

/* All timed runs of a study. */
struct pen_runs_use {
    int runs, spoiled;
    double used; /* the mean of their shares */
};
void pen_runs_use_add(struct pen_runs_use *sum, const struct pen_run_time *runs, int count);

/* Whether over half of the runs are spoiled: then nothing follows from their times. */
static inline bool pen_runs_spoiled(const struct pen_runs_use *use)
{
    return 2 * use->spoiled > use->runs;
}

#endif
