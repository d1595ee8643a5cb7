/* SPDX-License-Identifier: MIT */
/* A benchmark between two runs: what bench.c works on, and bench_state.c writes and reads. */
#ifndef PEN_STUDY_INTERNAL_BENCH_STATE_H
#define PEN_STUDY_INTERNAL_BENCH_STATE_H

#include "study/bench.h"
#include "study/internal/pictures.h"

struct pen_bench_state {
    const struct pen_bench *bench;
    struct pen_bench_result *result; /* its repeats are those that are whole */
    struct pen_bench_pictures *pictures;
    json_t *host;     /* of this process; NULL unless the state may be kept */
    double *tile_ms;  /* of the baseline's last repeat, one view behind the other */
    double *values;   /* scratch, a number for each repeat */
    int *order;       /* the slots of a pass: rows, and row_count for the twin */
    uint64_t *hash;   /* by row: of the pictures of its kind, if the row is the first of it; 0: not
                         known */
    bool *hashed;     /* by row: hash is of this process */
    int slots;        /* of a pass */
    int repeats_max;  /* places in each row's runs */
    int done, total;  /* runs */
    int passes;       /* whole ones, also of warm-up */
    int place;        /* runs made of the pass after these */
    int counting;     /* runs of step 3 */
    int64_t begun_ns; /* of the first run; earlier processes have run before this one began */
};

/* Takes over the state that an earlier process kept, if it is of the same benchmark, host, build
 * and number of threads; else changes nothing. Returns whether it did. */
bool pen_bench_state_read(struct pen_bench_state *state, const json_t *kept);

#endif
