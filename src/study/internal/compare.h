/* SPDX-License-Identifier: MIT */
/* The pictures of a benchmark: one of each kind is kept, and every other is held against it. */
#ifndef PEN_STUDY_INTERNAL_COMPARE_H
#define PEN_STUDY_INTERNAL_COMPARE_H

#include "study/bench.h"

/* Whether two rows must show the same picture, bit for bit: they differ in accelerator, threads and
 * tile alone. */
bool pen_rows_same_picture(const struct pen_bench_row *a, const struct pen_bench_row *b);

/* Whether two rows do the same work, divided otherwise: they differ in threads and tile alone. */
bool pen_rows_same_work(const struct pen_bench_row *a, const struct pen_bench_row *b);

struct pen_gallery;

/* Fails: NULL when out of memory. Owns: free with pen_gallery_free; borrows the benchmark. */
struct pen_gallery *pen_gallery_new(const struct pen_bench *bench);
void pen_gallery_free(struct pen_gallery *gallery);

/* Where the next picture of a view is to be drawn; has room for any row's. NULL when out of
 * memory. */
float *pen_gallery_canvas(struct pen_gallery *gallery, int view);

/* Takes what was drawn as the pictures of a row: keeps them if there are none of their kind, else
 * compares them. Fails: PEN_DIFFERENT, PEN_NO_MEMORY. */
bool pen_gallery_hang(struct pen_gallery *gallery, int row, struct pen_status *st);

/* Fills what the outcome says about pictures: same_as, compared_with, identical, max_difference and
 * rmse. Fails: PEN_NO_MEMORY. */
bool pen_gallery_compare(const struct pen_gallery *gallery, int row, struct pen_bench_outcome *out,
                         struct pen_status *st);

#endif
