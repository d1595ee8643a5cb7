/* SPDX-License-Identifier: MIT */
/* The state of a benchmark in progress, which bench_state.c saves. */
#ifndef PEN_STUDY_INTERNAL_BENCH_STATE_H
#define PEN_STUDY_INTERNAL_BENCH_STATE_H

#include "study/bench.h"
#include "study/internal/making.h"
#include "study/internal/pictures.h"

struct pen_bench_state {
    struct pen_making making; /* rows: the slots of a pass, which are the rows and then the twin */
    const struct pen_bench *bench;
    struct pen_bench_result *result; /* `repeats` counts whole repeats */
    struct pen_bench_pictures *pictures;
    double *tile_ms;             /* of the baseline's last repeat, view after view */
    double *values;              /* scratch space, one number for each repeat */
    int *order;                  /* the order of slots in the current pass */
    bool *hashed;                /* by row: this process has computed picture_hash */
    int repeats_max;             /* places in each row's runs */
    int passes;                  /* whole passes, including warm-up */
    int place;                   /* finished runs of the current pass */
    int counting;                /* number of runs that count tests */
    uint64_t order_seed, warmup; /* as in `bench` */
    double load_before;
};

extern const struct pen_kept_shape pen_bench_shape;

/* The number of whole repeats. */
int pen_bench_repeats(const struct pen_bench_state *state);

#endif
