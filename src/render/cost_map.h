/* SPDX-License-Identifier: MIT */
/* A cost map: the distribution of a job's work over its views, measured on a few pixels before the
 * others are rendered. Clients of a job see from it how much work is left; no pixel depends on it.
 *
 * A view is divided into cells. One block of pixels in each cell is rendered and timed, by the
 * processor time of its thread, with the kernel that renders the picture. Blocks are PEN_BLOCK_SIDE
 * pixels wide and high, since a ray costs less in a block than alone. They take fewer camera rays.
 * In small pictures they are smaller, so that the map has enough cells. */
#ifndef PEN_RENDER_COST_MAP_H
#define PEN_RENDER_COST_MAP_H

#include "base/buf.h"
#include "math/rect.h"
#include "render/forecast.h"

/* One pixel of this number is rendered, or the same work. */
enum { PEN_COST_MAP_PART = 52 };

struct pen_cost_map {
    int views, width, height;    /* all views have the same size */
    int columns, rows;           /* cells of a view */
    struct pen_estimate time_ms; /* of all views, with the threads that measured it */
    double *cell; /* views * rows * columns values: the share of all work; their sum is 1 */
};

/* Measures the views, whose numbers are `view`. The task's `view` and `quick` are ignored. Blocks
 * that its deadline leaves out count as the mean of the others.
 * Owns: release *map after success.
 * Threads: as pen_render_run.
 * Fails: PEN_NO_MEMORY, PEN_CANCELLED. */
bool pen_cost_map_make(struct pen_thread_pool *pool, const struct pen_forecast_task *task,
                       const int *view, int view_count, struct pen_cost_map *map,
                       struct pen_status *st);
void pen_cost_map_release(struct pen_cost_map *map);

/* The share of all work that lies in some pixels of the view at this index. An empty map, without
 * cells, treats all pixels as equal. */
double pen_cost_map_share(const struct pen_cost_map *map, int view, struct pen_rect rect);

/* Encodes a map in at most PEN_COST_MAP_BYTES, with the shares of cells rounded to 1/16 of an
 * octave, and decodes it.
 * Fails: returns false and leaves *map as it was if there is no memory, or if the bytes are no map
 * of such views. */
enum { PEN_COST_MAP_BYTES = 1100 };
bool pen_cost_map_save(const struct pen_cost_map *map, struct pen_buf *out);
bool pen_cost_map_load(const unsigned char *data, size_t bytes, struct pen_cost_map *map);

#endif
