/* SPDX-License-Identifier: MIT */
/* Differences between two pictures of the same size, value by value. Unless stated otherwise, they
 * use all 3 * width * height values, sRGB-encoded in [0, 1] and not quantised, for any transfer
 * function of the files. Sums run in a fixed order, so the results are the same on every machine.
 * Measures of visible differences are in ssim.h and flip.h. */
#ifndef PEN_FILM_METRICS_H
#define PEN_FILM_METRICS_H

#include <stdint.h>

#include "base/status.h"
#include "film/picture.h"

/* The differences of two pictures. For two PFM files, max_error, differing and over use values that
 * are not clamped to [0, 1]; the formula of the encoding is continued there. */
struct pen_difference {
    double rmse;
    /* The mean of (a - b)^2 / (b^2 + 0.01) over all values, linear and not clamped; b is the
     * reference. Not finite if a value is not finite. */
    double relative_mse;
    double psnr;       /* dB, peak 1: -20 log10(rmse); infinite for equal pictures */
    double max_error;  /* the largest difference of one value */
    int max_x, max_y;  /* the first pixel with that difference */
    int64_t differing; /* pixels that differ at all */
    int64_t alpha;     /* of these, pixels that differ in alpha */
    double tolerance;
    int64_t over;       /* pixels with a value that differs by more than the tolerance */
    double rmse_within; /* rmse of the other pixels; 0 if there are none */
};

/* Compares two pictures. `b` is the reference of relative_mse; all other results are symmetric.
 * Fails: PEN_INVALID (different sizes), PEN_NO_MEMORY. */
bool pen_picture_compare(const struct pen_picture *a, const struct pen_picture *b, double tolerance,
                         struct pen_difference *out, struct pen_status *st);

/* Whether two pictures have the same size.
 * Fails: PEN_INVALID, with both sizes. */
bool pen_picture_same_size(const struct pen_picture *a, const struct pen_picture *b,
                           struct pen_status *st);

#endif
