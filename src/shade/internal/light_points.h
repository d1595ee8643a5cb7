/* SPDX-License-Identifier: MIT */
/* The points of a light's disk that are sampled from one shaded point, by the setting
 * light_pattern, in groups of up to PEN_PACKET_RAYS. struct pen_sample_key defines which points
 * these are. */
#ifndef PEN_SHADE_INTERNAL_LIGHT_POINTS_H
#define PEN_SHADE_INTERNAL_LIGHT_POINTS_H

#include <math.h>
#include <string.h>

#include "accel/shadow_packet.h"
#include "math/sample.h"
#include "scene/settings.h"
#include "shade/internal/light_points4.h"

struct points {
    uint64_t hash;
    int pattern;
    uint32_t samples; /* sobol, random: how many; grid: cells along an edge */
    uint32_t next;    /* sobol, random: index; grid: row */
    uint32_t column;  /* grid */
    uint32_t first;   /* grid: the number of its first cell, larger when it is drawn again */
    bool none;        /* grid: no point so far was in the circle */
};

/* A grid of which no point is in the circle is drawn again, so that one cell gives a point that is
 * uniform in the disk. Only grids of 1 and 2 cells along an edge can be: larger ones have a cell
 * inside the disk. With one cell, a drawing fails with probability 1 - pi / 4, and 64 in a row with
 * 2^-142: not one of the 2^64 hashes is expected to come to that. It would have the centre. */
enum { POINTS_DRAWINGS = 64 };

/* A group of points, as coordinates on the unit disk. */
struct point_list {
    double a[PEN_PACKET_RAYS], b[PEN_PACKET_RAYS];
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

/* The columns of a row of the grid: those in [out, stop) may have their point in the circle, those
 * in [in, in_stop) surely have. Symmetric; the margins are larger than rounding. */
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

/* The points of four cells of a row of the grid, in the square around the unit disk. */
static inline void points_cells(const struct points *p, uint32_t row, uint32_t column, double4 *x,
                                double4 *y)
{
    double4 columns = {column, column + 1., column + 2., column + 3.};
    points_random(p->hash, p->first + row * p->samples + column, x, y);
    *x = 2 * ((columns + *x) / p->samples) - 1;
    *y = 2 * ((row + *y) / p->samples) - 1;
}

/* Appends the points of four cells of a row that are in the disk and before column `stop`. Returns
 * the length of the list. */
static inline int points_add_cells(const struct points *p, uint32_t row, uint32_t column,
                                   uint32_t stop, struct point_list *list)
{
    double4 x, y;
    points_cells(p, row, column, &x, &y);
    mask4 in = x * x + y * y <= 1;
    for (uint32_t i = 0; i < 4 && column + i < stop; i++) {
        list->a[list->count] = x[i];
        list->b[list->count] = y[i];
        list->count += in[i] & 1;
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

/* Fills the list with the next points of this drawing of the grid; where it is full, a row is
 * continued by the next call. */
static inline void points_fill_drawing(struct points *p, struct point_list *list)
{
    for (; p->next < p->samples; p->next++, p->column = 0) {
        struct points_row row = points_row(p->samples, p->next);
        if (p->column < row.out)
            p->column = row.out;
        for (; p->column < row.stop; p->column += 4) {
            if (list->count > PEN_PACKET_RAYS - 4)
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

/* Fills the list with the next points and returns their number; 0 when there are no more. */
static inline int points_fill(struct points *p, struct point_list *list)
{
    list->count = 0;
    if (p->pattern == PEN_PATTERN_GRID) {
        points_fill_grid(p, list);
        return list->count;
    }
    uint32_t left = p->samples - p->next;
    list->count = left < PEN_PACKET_RAYS ? (int)left : PEN_PACKET_RAYS;
    for (int i = 0; i < list->count; i += 4) {
        double4 x, y;
        if (p->pattern == PEN_PATTERN_SOBOL)
            points_sobol(p->hash, p->next + (uint32_t)i, &x, &y);
        else
            points_random(p->hash, p->next + (uint32_t)i, &x, &y);
        points_disk(&x, &y);
        memcpy(list->a + i, &x, sizeof x);
        memcpy(list->b + i, &y, sizeof y);
    }
    p->next += (uint32_t)list->count;
    return list->count;
}

/* The number of cells [column, stop) of a row that have their point in the disk. */
static inline uint32_t points_count_cells(const struct points *p, uint32_t row, uint32_t column,
                                          uint32_t stop)
{
    uint32_t count = 0;
    for (; column < stop; column += 4) {
        double4 x, y;
        mask4 in, number = {0, 1, 2, 3};
        points_cells(p, row, column, &x, &y);
        in = (x * x + y * y <= 1) & (number < (int64_t)(stop - column));
        count -= (uint32_t)(in[0] + in[1] + in[2] + in[3]);
    }
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
        return p.samples;
    uint32_t count;
    do
        count = points_count_drawing(&p);
    while (count == 0 && points_draw_again(&p));
    return count > 0 ? count : 1;
}

#endif
