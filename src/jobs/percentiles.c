/* SPDX-License-Identifier: MIT */
/* Percentiles of tile times, by the nearest rank: the least time that at least p of the tiles did
 * not exceed. */
#include <stdlib.h>

#include "jobs/internal/jobs.h"
#include "jobs/internal/stats.h"
#include "study/figures.h"

static int by_ms(const void *a, const void *b)
{
    double x = ((const struct pen_weighted *)a)->ms, y = ((const struct pen_weighted *)b)->ms;
    return (x > y) - (x < y);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double rank(const struct pen_weighted *times, size_t count, double wanted)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += times[i].weight;
        if (sum >= wanted * (1 - 1e-12))
            return times[i].ms;
    }
    return times[count - 1].ms;
}

struct pen_percentiles pen_percentiles_weighted(struct pen_weighted *times, size_t count)
{
    if (count == 0)
        return (struct pen_percentiles){0};
    qsort(times, count, sizeof *times, by_ms);
    double total = 0;
    for (size_t i = 0; i < count; i++)
        total += times[i].weight;
    return (struct pen_percentiles){.p50 = rank(times, count, 0.5 * total),
                                    .p95 = rank(times, count, 0.95 * total),
                                    .max = times[count - 1].ms};
}

bool pen_percentiles_of(const double *ms, size_t count, struct pen_percentiles *out)
{
    struct pen_weighted *times = malloc((count + 1) * sizeof *times);
    if (!times)
        return false;
    for (size_t i = 0; i < count; i++)
        times[i] = (struct pen_weighted){ms[i], 1};
    *out = pen_percentiles_weighted(times, count);
    free(times);
    return true;
}

json_t *pen_tile_times(const double *ms, size_t count)
{
    if (count == 0)
        return json_array();
    double *sorted = malloc(count * sizeof *sorted);
    if (!sorted)
        return NULL;
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        sorted[i] = ms[i];
    qsort(sorted, count, sizeof *sorted, by_value);
    size_t kept = count < PEN_TILE_TIMES ? count : PEN_TILE_TIMES;
    /* The largest is always among them: the list's maximum is that of the batch. */
    for (size_t i = 0; i < kept; i++)
        json_array_append_new(list, pen_figure(sorted[(i + 1) * count / kept - 1]));
    free(sorted);
    return pen_json_all(list, kept);
}
