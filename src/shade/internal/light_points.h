/* SPDX-License-Identifier: MIT */
/* The sampled points of a light's disk for one shaded point, by the setting light_pattern, in
 * groups of up to PEN_DISK_RAYS. struct pen_sample_key defines the points. */
#ifndef PEN_SHADE_INTERNAL_LIGHT_POINTS_H
#define PEN_SHADE_INTERNAL_LIGHT_POINTS_H

#include <math.h>

#include "accel/disk_packet.h"
#include "math/sample_lanes.h"
#include "scene/settings.h"

struct points {
    uint64_t hash;
    int pattern;
    uint32_t samples; /* sobol, random: their number; grid: cells along an edge */
    uint32_t next;    /* sobol, random: index; grid: row */
    uint32_t column;  /* grid */
    uint32_t first;   /* grid: the number of its first cell, larger after a redraw */
    bool none;        /* grid: no point so far was in the disk */
};

/* A grid with no point in the disk is drawn again, so that one cell gives a point that is uniform
 * in the disk. Only grids of 1 and 2 cells along an edge can need this: larger grids have a cell
 * inside the disk. With one cell, a drawing fails with probability 1 - pi / 4, and 64 in a row with
 * 2^-142. No hash of the 2^64 is expected to do so; it would get the centre. */
enum { POINTS_DRAWINGS = 64 };

/* A group of points, as coordinates on the unit disk. */
struct point_list {
    double a[PEN_DISK_RAYS], b[PEN_DISK_RAYS];
    int count;
};

/* The least m with m^2 >= n. */
static inline uint32_t points_edge(uint32_t n)
{
    uint32_t m = (uint32_t)sqrt(n);
    return m * m < n ? m + 1 : m;
}

static inline struct points points_begin(const struct pen_settings *settings, uint64_t hash)
{
    uint32_t samples = (uint32_t)settings->light_samples;
    bool grid = settings->light_pattern == PEN_PATTERN_GRID;
    return (struct points){.hash = hash,
                           .pattern = settings->light_pattern,
                           .samples = grid ? points_edge(samples) : samples,
                           .none = grid};
}

/* Skips the points of the camera rays before ray `ray`, in a sequence of sobol or random. */
static inline void points_skip(struct points *p, uint32_t ray)
{
    const uint32_t before = p->samples * ray;
    p->next += before;
    p->samples += before;
}

/* The columns of a row of the grid. The points of [out, stop) may be in the disk; those of [in,
 * in_stop) certainly are. Symmetric; the margins are larger than rounding. */
struct points_row {
    uint32_t out, in, in_stop, stop;
};

static inline struct points_row points_row(uint32_t edge, uint32_t row)
{
    const double half = 0.5 * edge;
    double low = fabs(row - half), high = fabs(row + 1 - half);
    double near = (low < high ? low : high) / half, far = (low < high ? high : low) / half;
    if (2 * row + 1 == edge)
        near = 0;
    double reach = sqrt(1 + 0x1p-30 - near * near) * half;
    double inner = far < 1 ? sqrt(1 - far * far) * half - 1 - 0x1p-30 * half : -1;
    struct points_row r = {0, 0, 0, edge};
    if (half - reach > 0)
        r.out = (uint32_t)(half - reach);
    r.stop = edge - r.out;
    r.in = r.in_stop = r.stop;
    if (inner >= 0.5) {
        r.in = (uint32_t)(half - inner);
        r.in_stop = edge - r.in;
    }
    return r;
}

/* Computes the points of LANES cells of a row of the grid, in the square around the unit disk.
 * Returns the points that are in the disk and before column `stop`, as bits. */
static inline unsigned points_cells(const struct points *p, uint32_t row, uint32_t column,
                                    uint32_t stop, struct lanes_point2 *at)
{
    const uint32_t left = stop - column;
    const lanes columns = lanes_splat(column) + lanes_of_small(lane_words_count());
    *at = lanes_random2(p->hash, p->first + row * p->samples + column);
    at->x = 2 * ((columns + at->x) / lanes_splat(p->samples)) - 1;
    at->y = 2 * ((lanes_splat(row) + at->y) / lanes_splat(p->samples)) - 1;
    return lane_mask_bits(lanes_at_most(at->x * at->x + at->y * at->y, lanes_splat(1))) &
           (left < LANES ? (1u << left) - 1 : LANES_ALL);
}

/* Appends the points of LANES cells of a row that are in the disk and before column `stop`. Returns
 * the length of the list. */
static inline int points_add_cells(const struct points *p, uint32_t row, uint32_t column,
                                   uint32_t stop, struct point_list *list)
{
    struct lanes_point2 at;
    double x[LANES], y[LANES];
    unsigned in = points_cells(p, row, column, stop, &at);
    lanes_store(x, at.x);
    lanes_store(y, at.y);
    for (; in; in &= in - 1) {
        list->a[list->count] = x[__builtin_ctz(in)];
        list->b[list->count++] = y[__builtin_ctz(in)];
    }
    return list->count;
}

/* Begins the next drawing of the grid. Returns false if there are no more. */
static inline bool points_draw_again(struct points *p)
{
    uint32_t cells = p->samples * p->samples;
    if (p->first >= (POINTS_DRAWINGS - 1) * cells)
        return false;
    p->first += cells;
    p->next = p->column = 0;
    return true;
}

/* Fills the list with the next points of this drawing of the grid. If it is full, the next call
 * continues the row. */
static inline void points_fill_drawing(struct points *p, struct point_list *list)
{
    for (; p->next < p->samples; p->next++, p->column = 0) {
        struct points_row row = points_row(p->samples, p->next);
        if (p->column < row.out)
            p->column = row.out;
        for (; p->column < row.stop; p->column += LANES) {
            if (list->count > PEN_DISK_RAYS - LANES)
                return;
            if (points_add_cells(p, p->next, p->column, row.stop, list) > 0)
                p->none = false;
        }
    }
}

/* Fills the list with the grid's next points. */
static inline void points_fill_grid(struct points *p, struct point_list *list)
{
    points_fill_drawing(p, list);
    while (p->none && points_draw_again(p))
        points_fill_drawing(p, list);
    if (p->none) {
        p->none = false;
        list->a[0] = list->b[0] = 0;
        list->count = 1;
    }
}

/* Fills the list with the next points and returns their number; 0 at the end. */
static inline int points_fill(struct points *p, struct point_list *list)
{
    list->count = 0;
    if (p->pattern == PEN_PATTERN_GRID) {
        points_fill_grid(p, list);
        return list->count;
    }
    uint32_t left = p->samples - p->next;
    list->count = left < PEN_DISK_RAYS ? (int)left : PEN_DISK_RAYS;
    for (int i = 0; i < list->count; i += LANES) {
        const uint32_t index = p->next + (uint32_t)i;
        const struct lanes_point2 at =
            lanes_disk_of_square(p->pattern == PEN_PATTERN_SOBOL ? lanes_sobol2(p->hash, index)
                                                                 : lanes_random2(p->hash, index));
        lanes_store(list->a + i, at.x);
        lanes_store(list->b + i, at.y);
    }
    p->next += (uint32_t)list->count;
    return list->count;
}

/* The number of cells [column, stop) of a row whose points are in the disk. */
static inline uint32_t points_count_cells(const struct points *p, uint32_t row, uint32_t column,
                                          uint32_t stop)
{
    struct lanes_point2 at;
    uint32_t count = 0;
    for (; column < stop; column += LANES)
        count += (uint32_t)__builtin_popcount(points_cells(p, row, column, stop, &at));
    return count;
}

/* The number of points of this drawing of the grid. */
static inline uint32_t points_count_drawing(const struct points *p)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < p->samples; i++) {
        struct points_row row = points_row(p->samples, i);
        count += row.in_stop - row.in;
        count += points_count_cells(p, i, row.out, row.in);
        count += points_count_cells(p, i, row.in_stop, row.stop);
    }
    return count;
}

/* The number of all points. */
static inline uint32_t points_count(const struct points *points)
{
    struct points p = *points;
    if (p.pattern != PEN_PATTERN_GRID)
        return p.samples - p.next;
    uint32_t count;
    do
        count = points_count_drawing(&p);
    while (count == 0 && points_draw_again(&p));
    return count > 0 ? count : 1;
}

#endif
