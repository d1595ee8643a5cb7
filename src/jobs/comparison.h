/* SPDX-License-Identifier: MIT */
/* The comparison of two pictures, for the command line and the API. */
#ifndef PEN_JOBS_COMPARISON_H
#define PEN_JOBS_COMPARISON_H

#include <jansson.h>
#include <stdbool.h>

#include "base/buf.h"
#include "base/status.h"
#include "film/flip.h"
#include "film/metrics.h"
#include "film/picture.h"

struct pen_comparison {
    int width, height;
    struct pen_difference difference;
    double ssim;
    struct pen_flip flip;
    bool tags_differ; /* although the samples are equal: pen_picture_match */
};

/* Returns the figures as an object of numbers. The PSNR of equal pictures is null, because JSON has
 * no infinity.
 * Owns: the caller.
 * Fails: NULL when out of memory. */
json_t *pen_comparison_json(const struct pen_comparison *comparison);

/* Appends FLIP's error of each pixel as a picture in the format "png", "png16" or "pfm".
 * Fails: PEN_NO_MEMORY. */
bool pen_comparison_map(const float *errors, int width, int height, const char *format,
                        struct pen_buf *out, struct pen_status *st);

/* Measures two pictures of the same size. Appends the map as PNG, or else the figures as a line of
 * JSON.
 * Fails: PEN_NO_MEMORY. */
bool pen_comparison_write(struct pen_picture *a, struct pen_picture *b, bool map,
                          struct pen_buf *out, struct pen_status *st);

#endif
