/* SPDX-License-Identifier: MIT */
/* The statistics of a batch, as they are stored with it (stats.h). */
#include <stdlib.h>

#include "base/clock.h"
#include "io/figures.h"
#include "jobs/internal/batch_context.h"
#include "jobs/internal/stats.h"

bool pen_batch_write_stats(struct pen_batch_context *context, json_t *stats,
                           struct pen_batch_output *output, struct pen_status *st)
{
    stats = pen_json_with(stats, "store_before_ms", pen_figure(context->store_ms));
    context->store_ms = 0;
    output->stats = stats ? json_dumps(stats, PEN_JSON_STORED) : NULL;
    json_decref(stats);
    output->result.stats = output->stats;
    output->result.handed_ns = pen_clock_ns();
    return output->stats || pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The member tile_ms (stats.h). */
static json_t *tile_times(const double *ms, size_t count)
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

bool pen_batch_write_render_stats(struct pen_batch_context *context,
                                  const struct pen_stats_input *in, struct pen_batch_output *output,
                                  struct pen_status *st)
{
    json_t *json = pen_stats_json(in);
    if (json)
        json =
            pen_json_with(json, "tile_ms", tile_times(in->render->tile_ms, in->render->tile_count));
    return pen_batch_write_stats(context, json, output, st);
}
