/* SPDX-License-Identifier: MIT */
/* A benchmark while it is made: what bench.c works on, and bench_state.c keeps. */
#ifndef PEN_STUDY_INTERNAL_BENCH_STATE_H
#define PEN_STUDY_INTERNAL_BENCH_STATE_H

#include "study/bench.h"
#include "study/internal/making.h"
#include "study/internal/pictures.h"

struct pen_bench_state {
    struct pen_making making; /* its rows are the slots of a pass: rows, and then the twin */
    const struct pen_bench *bench;
    struct pen_bench_result *result; /* its repeats are those that are whole */
    struct pen_bench_pictures *pictures;
    double *tile_ms;             /* of the baseline's last repeat, one view behind the other */
    double *values;              /* scratch, a number for each repeat */
    int *order;                  /* the slots of a pass */
    bool *hashed;                /* by row: its picture_hash is of this process */
    int repeats_max;             /* places in each row's runs */
    int passes;                  /* whole ones, also of warm-up */
    int place;                   /* runs made of the pass after these */
    int counting;                /* runs of step 3 */
    uint64_t order_seed, warmup; /* of the benchmark */
    double load_before;
};

extern const struct pen_kept_shape pen_bench_shape;

/* The repeats that are whole. */
int pen_bench_repeats(const struct pen_bench_state *state);

#endif
