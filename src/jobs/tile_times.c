/* SPDX-License-Identifier: MIT */
/* The times of a batch's tiles, as they are stored with the batch. */
#include <stdlib.h>

#include "io/figures.h"
#include "io/json_build.h"
#include "jobs/internal/stats.h"

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
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
    /* The last index is count - 1: the largest time of the batch is always kept. */
    for (size_t i = 0; i < kept; i++)
        json_array_append_new(list, pen_figure(sorted[(i + 1) * count / kept - 1]));
    free(sorted);
    return pen_json_all(list, kept);
}
