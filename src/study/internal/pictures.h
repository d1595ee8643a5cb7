/* SPDX-License-Identifier: MIT */
/* The pictures of a benchmark. The first picture of each kind is kept as the reference; every other
 * picture of that kind must equal it. */
#ifndef PEN_STUDY_INTERNAL_PICTURES_H
#define PEN_STUDY_INTERNAL_PICTURES_H

#include "study/bench.h"

/* Whether two rows do the same work, only divided otherwise: they differ in threads and tile alone.
 */
bool pen_bench_rows_same_work(const struct pen_bench_row *a, const struct pen_bench_row *b);

/* Whether two rows are meant to show the same scene equally well: they differ in how it is computed
 * alone, in accelerator, threads, tile and precision. */
bool pen_bench_rows_same_quality(const struct pen_bench_row *a, const struct pen_bench_row *b);

struct pen_bench_pictures;

/* Fails: NULL when out of memory. Owns: free with pen_bench_pictures_free; borrows the benchmark.
 */
struct pen_bench_pictures *pen_bench_pictures_new(const struct pen_bench *bench);
void pen_bench_pictures_free(struct pen_bench_pictures *pictures);

/* The pixels to render a view into; large enough for every row. */
float *pen_bench_pictures_target(struct pen_bench_pictures *pictures, int view);

/* Takes the targets' pixels as the pictures of a row: keeps them as references if they are the
 * first of their kind, else compares them with the references. Fails: PEN_DIFFERENT, PEN_NO_MEMORY.
 */
bool pen_bench_pictures_check(struct pen_bench_pictures *pictures, int row, struct pen_status *st);

/* The first row that shows the same picture. */
int pen_bench_pictures_first(const struct pen_bench *bench, int row);

/* The hash of the film of a row's pictures, which have been checked; of several views, a hash of
 * theirs. */
uint64_t pen_bench_pictures_hash(const struct pen_bench_pictures *pictures, int row);

/* Fills picture_hash, same_as, compared_with, identical, max_difference and rmse of a row's result.
 * Fails: PEN_NO_MEMORY. */
bool pen_bench_pictures_measure(const struct pen_bench_pictures *pictures, int row,
                                struct pen_bench_row_result *out, struct pen_status *st);

#endif
