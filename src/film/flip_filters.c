/* SPDX-License-Identifier: MIT */
#include "film/internal/flip_filters.h"

#include <math.h>

#include "math/fn.h"

static const double pi = 3.14159265358979323846;

/* 3840 pixels on 0.7 m, seen from 0.7 m: 67.0206, the paper's default. */
static double pixels_per_degree(void)
{
    return 3840 * pi / 180;
}

/* The Gaussian exp(-falloff d^2) at distances of 0 to radius. */
static void gaussian(struct flip_filter *f, double falloff, int radius)
{
    f->radius = radius;
    for (int d = 0; d <= radius; d++)
        f->weight[d] = pen_exp(-falloff * d * d);
}

static void scale(struct flip_filter *f, double factor)
{
    for (int d = 0; d <= f->radius; d++)
        f->weight[d] *= factor;
}

/* The sum of all weights of an even filter. */
static double total(const struct flip_filter *f)
{
    double sum = f->weight[0];
    for (int d = 1; d <= f->radius; d++)
        sum += 2 * f->weight[d];
    return sum;
}

/* A contrast sensitivity filter exp(-pi^2 d^2 / b), d in degrees. */
static void contrast(struct flip_filter *f, double b)
{
    const double per_degree = pixels_per_degree();
    gaussian(f, pi * pi / (b * per_degree * per_degree), FLIP_CONTRAST_RADIUS);
}

/* The two Gaussians of blue and yellow are a sqrt(pi / b) times the exponential, and are normalised
 * together. Each is used along both axes, so its factor is the root of its share. */
static void share_blue_yellow(struct flip_filter *first, struct flip_filter *second)
{
    const double sum_1 = total(first), sum_2 = total(second), factor_1 = 34.1 * sqrt(pi / 0.04),
                 factor_2 = 13.5 * sqrt(pi / 0.025),
                 sum = factor_1 * sum_1 * sum_1 + factor_2 * sum_2 * sum_2;
    scale(first, sqrt(factor_1 / sum));
    scale(second, sqrt(factor_2 / sum));
}

/* The first derivative of the Gaussian without its sign; its positive half has sum 1. */
static void differentiate(const struct flip_filter *smooth, struct flip_filter *edge)
{
    double sum = 0;
    *edge = *smooth;
    edge->odd = true;
    for (int d = 0; d <= smooth->radius; d++)
        sum += edge->weight[d] = d * smooth->weight[d];
    scale(edge, 1 / sum);
}

/* The second derivative of the Gaussian of variance `variance`, scaled so that the positive weights
 * have sum 1 and the negative ones -1. */
static void differentiate_twice(const struct flip_filter *smooth, double variance,
                                struct flip_filter *point)
{
    double positive = 0, negative = 0;
    *point = *smooth;
    for (int d = 0; d <= smooth->radius; d++) {
        const double w = (d * d / variance - 1) * smooth->weight[d], both = d > 0 ? 2 * w : w;
        point->weight[d] = w;
        *(w > 0 ? &positive : &negative) += both;
    }
    for (int d = 0; d <= smooth->radius; d++)
        point->weight[d] /= point->weight[d] > 0 ? positive : -negative;
}

void pen_flip_filters(struct flip_filter out[FLIP_FILTERS])
{
    /* The eye resolves a feature best if it is 0.082 degrees wide. */
    const double deviation = 0.5 * 0.082 * pixels_per_degree(), variance = deviation * deviation;
    for (int i = 0; i < FLIP_FILTERS; i++)
        out[i] = (struct flip_filter){.odd = false};
    contrast(&out[FLIP_LUMINANCE], 0.0047);
    contrast(&out[FLIP_RED_GREEN], 0.0053);
    contrast(&out[FLIP_BLUE_YELLOW_1], 0.04);
    contrast(&out[FLIP_BLUE_YELLOW_2], 0.025);
    scale(&out[FLIP_LUMINANCE], 1 / total(&out[FLIP_LUMINANCE]));
    scale(&out[FLIP_RED_GREEN], 1 / total(&out[FLIP_RED_GREEN]));
    share_blue_yellow(&out[FLIP_BLUE_YELLOW_1], &out[FLIP_BLUE_YELLOW_2]);
    gaussian(&out[FLIP_SMOOTH], 1 / (2 * variance), FLIP_FEATURE_RADIUS);
    differentiate(&out[FLIP_SMOOTH], &out[FLIP_EDGE]);
    differentiate_twice(&out[FLIP_SMOOTH], variance, &out[FLIP_POINT]);
    scale(&out[FLIP_SMOOTH], 1 / total(&out[FLIP_SMOOTH]));
}
