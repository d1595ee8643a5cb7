/* SPDX-License-Identifier: MIT */
/* Pools errors. A weighted quantile is found without sorting, because floats >= 0 have the order of
 * their bits. A first pass sums the errors that share their upper 16 bits. A second pass divides
 * the sum that contains the quantile by the lower 16 bits. */
#include "film/internal/flip_pool.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { HALF = 1 << 16 };

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* sum[i] is the sum of all errors whose upper bits are i. */
static void sum_by_upper_bits(const float *errors, size_t count, double sum[HALF])
{
    memset(sum, 0, HALF * sizeof *sum);
    for (size_t i = 0; i < count; i++)
        sum[bits_of(errors[i]) >> 16] += (double)errors[i];
}

/* sum[i] is the sum of all errors with these upper bits whose lower bits are i. */
static void sum_by_lower_bits(const float *errors, size_t count, uint32_t upper, double sum[HALF])
{
    memset(sum, 0, HALF * sizeof *sum);
    for (size_t i = 0; i < count; i++)
        if (bits_of(errors[i]) >> 16 == upper)
            sum[bits_of(errors[i]) & (HALF - 1)] += (double)errors[i];
}

/* The first sum with which the running total exceeds `limit`; if none, the last that is not 0.
 * *before becomes the total before it. */
static uint32_t find(const double sum[HALF], double limit, double *before)
{
    uint32_t last = 0;
    double running = *before;
    for (uint32_t i = 0; i < HALF; i++) {
        if (sum[i] > 0) {
            last = i;
            *before = running;
            running += sum[i];
        }
        if (running > limit)
            break;
    }
    return last;
}

/* The error up to which errors make up the share `p` of their sum. upper[] has the sums by upper
 * bits; sum[] is scratch. */
static double quantile(const float *errors, size_t count, double p, const double upper[HALF],
                       double sum[HALF])
{
    double total = 0, before = 0;
    for (int i = 0; i < HALF; i++)
        total += upper[i];
    const uint32_t high = find(upper, p * total, &before);
    sum_by_lower_bits(errors, count, high, sum);
    return (double)float_of(high << 16 | find(sum, p * total, &before));
}

/* Mean, least and largest error. Each row is summed separately, which keeps rounding errors small.
 */
static void pool_plainly(const float *errors, int width, int height, struct pen_flip *out)
{
    float min = errors[0], max = errors[0];
    double sum = 0;
    for (int y = 0; y < height; y++) {
        double row = 0;
        for (int x = 0; x < width; x++, errors++) {
            row += (double)*errors;
            min = *errors < min ? *errors : min;
            max = *errors > max ? *errors : max;
        }
        sum += row;
    }
    out->mean = sum / ((double)width * height);
    out->min = (double)min;
    out->max = (double)max;
}

bool pen_flip_pool(const float *errors, int width, int height, struct pen_flip *out,
                   struct pen_status *st)
{
    const size_t count = (size_t)width * (size_t)height;
    double *upper = malloc(2 * HALF * sizeof *upper);
    if (!upper)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to pool errors");
    double *lower = upper + HALF;
    pool_plainly(errors, width, height, out);
    sum_by_upper_bits(errors, count, upper);
    out->first_quartile = quantile(errors, count, 0.25, upper, lower);
    out->weighted_median = quantile(errors, count, 0.5, upper, lower);
    out->third_quartile = quantile(errors, count, 0.75, upper, lower);
    free(upper);
    return true;
}
