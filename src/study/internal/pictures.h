/* SPDX-License-Identifier: MIT */
/* The pictures of a benchmark. The first picture of each kind is the reference, and each later
 * picture of that kind must equal it. */
#ifndef PEN_STUDY_INTERNAL_PICTURES_H
#define PEN_STUDY_INTERNAL_PICTURES_H

#include "study/bench.h"

/* Whether two rows do the same work: they differ in threads and tile alone. */
bool pen_bench_rows_same_work(const struct pen_bench_row *a, const struct pen_bench_row *b);

/* Whether two rows should show the scene equally well. They differ in the way of computing alone:
 * in accelerator, threads, tile and precision. */
bool pen_bench_rows_same_quality(const struct pen_bench_row *a, const struct pen_bench_row *b);

struct pen_bench_pictures;

/* Allocates the pictures of a benchmark.
 * Owns: free with pen_bench_pictures_free; borrows the benchmark.
 * Fails: NULL when out of memory. */
struct pen_bench_pictures *pen_bench_pictures_new(const struct pen_bench *bench);
void pen_bench_pictures_free(struct pen_bench_pictures *pictures);

/* The buffer into which a view is rendered; large enough for every row. */
float *pen_bench_pictures_target(struct pen_bench_pictures *pictures, int view);

/* Checks the pictures of a row, which are in the targets. The first pictures of a kind become its
 * reference; later ones are compared with it.
 * Fails: PEN_DIFFERENT, PEN_NO_MEMORY. */
bool pen_bench_pictures_check(struct pen_bench_pictures *pictures, int row, struct pen_status *st);

/* The first row that must show the same picture. */
int pen_bench_pictures_first(const struct pen_bench *bench, int row);

/* The hash of a row's pictures, which have been checked. For several views, it is a hash of their
 * hashes. */
uint64_t pen_bench_pictures_hash(const struct pen_bench_pictures *pictures, int row);

/* Sets picture_hash, same_as, compared_with, identical, max_difference and rmse of a row's result.
 * Fails: PEN_NO_MEMORY. */
bool pen_bench_pictures_measure(const struct pen_bench_pictures *pictures, int row,
                                struct pen_bench_row_result *out, struct pen_status *st);

#endif
