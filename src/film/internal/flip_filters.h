/* SPDX-License-Identifier: MIT */
/* The filters of FLIP, along one axis. Each of its filters of the plane is a product of two of
 * these, one along each axis, or a sum of two such products.
 * Source: Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM
 * Comput. Graph. Interact. Tech. 3(2), 2020: spatial filtering, and feature detection. */
#ifndef PEN_FILM_INTERNAL_FLIP_FILTERS_H
#define PEN_FILM_INTERNAL_FLIP_FILTERS_H

#include <stdbool.h>

/* The radius of filters in pixels: three standard deviations, rounded up. All contrast filters have
 * that of the widest one; the features have that of their Gaussian. */
enum { FLIP_CONTRAST_RADIUS = 10, FLIP_FEATURE_RADIUS = 9 };

/* The contrast filters are the resolution of the eye: a contrast sensitivity function for each
 * channel, as a Gaussian, or as a sum of two for blue and yellow. The features are a Gaussian, and
 * its first and second derivative. */
enum flip_filter_name {
    FLIP_LUMINANCE,
    FLIP_RED_GREEN,
    FLIP_BLUE_YELLOW_1,
    FLIP_BLUE_YELLOW_2,
    FLIP_SMOOTH,
    FLIP_EDGE,
    FLIP_POINT,
    FLIP_FILTERS
};

/* Weights of the pixels at distances 0 to radius. On the other side they are the same; negative if
 * the filter is odd. */
struct flip_filter {
    double weight[FLIP_CONTRAST_RADIUS + 1];
    int radius;
    bool odd;
};

/* Makes all filters. Contrast filters and FLIP_SMOOTH have sum 1 over the plane. For FLIP_EDGE and
 * FLIP_POINT, the positive weights have sum 1 and the negative ones -1. */
void pen_flip_filters(struct flip_filter out[FLIP_FILTERS]);

#endif
