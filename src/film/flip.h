/* SPDX-License-Identifier: MIT */
/* FLIP: the visible difference of two pictures for a viewer who flips between them. This is the
 * metric for pictures of a display's range (LDR), at 67.0206 pixels per degree: a display of 3840
 * pixels and 0.7 m, seen from 0.7 m. Pixels are compared by colour and by features. Before the
 * colour comparison, details that the eye does not see are blurred. Features are edges and points,
 * which make a difference of colour stand out.
 *
 * Values are clamped to [0, 1]; NaN counts as 0. Beyond its border a picture continues with the
 * values at the border. Neither picture is the reference: exchanging them changes no bit. Sums run
 * in a fixed order, so the results are the same on every machine.
 *
 * Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference
 * Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. */
#ifndef PEN_FILM_FLIP_H
#define PEN_FILM_FLIP_H

#include "base/status.h"
#include "film/picture.h"

/* The errors of all pixels, pooled. Each error is from 0 (no difference) to 1. The median and the
 * quartiles are weighted: errors up to weighted_median make up half of the sum of all errors. So
 * they describe the pixels that differ, even if these are few. */
struct pen_flip {
    double mean; /* the usual figure */
    double weighted_median, first_quartile, third_quartile;
    double min, max;
};

/* Compares two pictures of the same size.
 * Shape: errors[] has width * height values, row 0 at the top; NULL if they are not wanted.
 * Fails: PEN_INVALID (different sizes), PEN_NO_MEMORY; errors[] is then undefined.
 * Cost: about 0.3 us per pixel, and 2 MB besides errors[]; if it is NULL, also the size of
 * errors[]. */
bool pen_picture_flip(const struct pen_picture *a, const struct pen_picture *b, float *errors,
                      struct pen_flip *out, struct pen_status *st);

#endif
