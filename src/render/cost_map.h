/* SPDX-License-Identifier: MIT */
/* A cost map: which part of a job's work lies where in its views, measured on a few pixels before
 * the others are rendered. Readers of a job see from it how much is left; no pixel depends on it.
 *
 * A view is cut into cells. A block of pixels in each cell is rendered and timed, by the processor
 * time of its thread, with the kernel that renders the picture. Blocks have PEN_BLOCK_SIDE pixels a
 * side, since a ray costs less in a block than alone; they take fewer camera rays, and are smaller
 * in small pictures, so that the map has cells enough. */
#ifndef PEN_RENDER_COST_MAP_H
#define PEN_RENDER_COST_MAP_H

#include "base/buf.h"
#include "math/rect.h"
#include "render/forecast.h"

/* One pixel of so many is rendered, or as much as that takes. */
enum { PEN_COST_MAP_PART = 52 };

struct pen_cost_map {
    int views, width, height;    /* all views have the same size */
    int columns, rows;           /* cells of a view */
    struct pen_estimate time_ms; /* of all views, with the threads that have measured it */
    double *cell;                /* views * rows * columns: the share of all work; their sum is 1 */
};

/* Measures the views, whose numbers are `view`. Of the task, `view` and `quick` do not count; what
 * its deadline leaves out counts as the mean of the others. Fails: PEN_NO_MEMORY, PEN_CANCELLED.
 * Owns: release *map after success. Threads: as pen_render_run. */
bool pen_cost_map_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       const int *view, int view_count, struct pen_cost_map *map,
                       struct pen_status *st);
void pen_cost_map_release(struct pen_cost_map *map);

/* The share of all work that lies in some pixels of the view with this place. A map that is empty,
 * without cells, takes all pixels for equal. */
double pen_cost_map_share(const struct pen_cost_map *map, int view, struct pen_rect rect);

/* A map in at most PEN_COST_MAP_BYTES, with the shares of cells rounded to 1/16 of an octave; and
 * back. Fails: false, *map is as it was: no memory, or the bytes are no map of such views. */
enum { PEN_COST_MAP_BYTES = 1100 };
bool pen_cost_map_save(const struct pen_cost_map *map, struct pen_buf *out);
bool pen_cost_map_load(const unsigned char *data, size_t bytes, struct pen_cost_map *map);

#endif
