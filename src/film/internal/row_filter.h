/* SPDX-License-Identifier: MIT */
/* Sums of weighted rows, the parts of separable filters. A filter along a row adds the row shifted
 * left and right. A filter across rows adds the rows above and below. Every value is summed in the
 * same order, so the results are the same on every machine. */
#ifndef PEN_FILM_INTERNAL_ROW_FILTER_H
#define PEN_FILM_INTERNAL_ROW_FILTER_H

static inline void row_scale(double *restrict out, const double *restrict in, double weight,
                             int count)
{
    for (int i = 0; i < count; i++)
        out[i] = weight * in[i];
}

static inline void row_add(double *restrict out, const double *restrict in, double weight,
                           int count)
{
    for (int i = 0; i < count; i++)
        out[i] += weight * in[i];
}

/* Adds weight * (a + b). */
static inline void row_add_sum(double *restrict out, const double *a, const double *b,
                               double weight, int count)
{
    for (int i = 0; i < count; i++)
        out[i] += weight * (a[i] + b[i]);
}

/* Adds weight * (a - b). */
static inline void row_add_difference(double *restrict out, const double *a, const double *b,
                                      double weight, int count)
{
    for (int i = 0; i < count; i++)
        out[i] += weight * (a[i] - b[i]);
}

#endif
