/* SPDX-License-Identifier: MIT */
/* Sorts the times and walks along their cumulated weights. */
#include "render/percentiles.h"

#include <stdlib.h>

static int by_ms(const void *a, const void *b)
{
    double x = ((const struct pen_weighted_time *)a)->ms;
    double y = ((const struct pen_weighted_time *)b)->ms;
    return (x > y) - (x < y);
}

/* The first time at which the cumulated weights reach `target`. Rounding may keep their sum 1e-12
 * below. */
static double time_at(const struct pen_weighted_time *times, size_t count, double target)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += times[i].weight;
        if (sum >= target * (1 - 1e-12))
            return times[i].ms;
    }
    return times[count - 1].ms;
}

struct pen_percentiles pen_percentiles_weighted(struct pen_weighted_time *times, size_t count)
{
    if (count == 0)
        return (struct pen_percentiles){0};
    qsort(times, count, sizeof *times, by_ms);
    double total = 0;
    for (size_t i = 0; i < count; i++)
        total += times[i].weight;
    return (struct pen_percentiles){.p50 = time_at(times, count, 0.5 * total),
                                    .p95 = time_at(times, count, 0.95 * total),
                                    .max = times[count - 1].ms};
}

bool pen_percentiles_of(const double *ms, size_t count, struct pen_percentiles *out)
{
    struct pen_weighted_time *times = malloc((count + 1) * sizeof *times);
    if (!times)
        return false;
    for (size_t i = 0; i < count; i++)
        times[i] = (struct pen_weighted_time){.ms = ms[i], .weight = 1};
    *out = pen_percentiles_weighted(times, count);
    free(times);
    return true;
}
