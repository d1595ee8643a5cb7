/* SPDX-License-Identifier: MIT */
/* The points of a light's disk that are sampled from one shaded point, by the setting
 * light_pattern, some at a time. Which they are is said at struct pen_sample_key. */
#ifndef SHADE_POINTS_H
#define SHADE_POINTS_H

#include <math.h>

#include "pen/accel/fan.h"
#include "pen/math/sample.h"
#include "pen/scene/settings.h"

struct points {
    uint64_t hash;
    int pattern;
    uint32_t samples; /* sobol, random: how many; grid: cells along an edge */
    uint32_t next;    /* sobol, random: index; grid: row */
    uint32_t column;  /* grid */
    bool none;        /* grid: no point so far was in the circle */
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

/* Cells of a row of the grid: those in [out, stop) may have their point in the circle, those in
 * [in, in_stop) surely have. Symmetric, and cut with more than rounding to spare. */
struct points_row {
    uint32_t out, in, in_stop, stop;
};

static inline struct points_row points_row(uint32_t edge, uint32_t row)
{
    const double slack = 0x1p-30, half = 0.5 * edge;
    double low = fabs(row - half), high = fabs(row + 1 - half);
    double near = (low < high ? low : high) / half, far = (low < high ? high : low) / half;
    if (2 * row + 1 == edge)
        near = 0;
    double reach = sqrt(1 - near * near + slack) * half;
    double inner = far < 1 ? sqrt(1 - far * far) * half - 1 - slack * half : -1;
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

/* The point of a grid's cell, in the square around the unit disk; whether it is in the disk. */
static inline bool points_cell(const struct points *p, uint32_t row, uint32_t column,
                               struct pen_point2 *at)
{
    struct pen_point2 in = pen_grid2(p->hash, p->samples, row * p->samples + column);
    *at = (struct pen_point2){2 * in.x - 1, 2 * in.y - 1};
    return at->x * at->x + at->y * at->y <= 1;
}

static inline int points_fill_grid(struct points *p, double a[PEN_FAN_RAYS], double b[PEN_FAN_RAYS])
{
    int n = 0;
    for (; p->next < p->samples; p->next++, p->column = 0) {
        struct points_row row = points_row(p->samples, p->next);
        if (p->column < row.out)
            p->column = row.out;
        for (; p->column < row.stop; p->column++) {
            struct pen_point2 at;
            if (n == PEN_FAN_RAYS)
                return n;
            if (!points_cell(p, p->next, p->column, &at))
                continue;
            a[n] = at.x;
            b[n++] = at.y;
            p->none = false;
        }
    }
    if (n == 0 && p->none) { /* the centre */
        p->none = false;
        a[0] = b[0] = 0;
        n = 1;
    }
    return n;
}

/* The next points, up to PEN_FAN_RAYS of them; 0 when there are no more. */
static inline int points_fill(struct points *p, double a[PEN_FAN_RAYS], double b[PEN_FAN_RAYS])
{
    if (p->pattern == PEN_PATTERN_GRID)
        return points_fill_grid(p, a, b);
    uint32_t left = p->samples - p->next;
    int n = left < PEN_FAN_RAYS ? (int)left : PEN_FAN_RAYS;
    for (int i = 0; i < n; i++) {
        uint32_t index = p->next + (uint32_t)i;
        struct pen_point2 at =
            pen_disk_of_square(p->pattern == PEN_PATTERN_SOBOL ? pen_sobol2(p->hash, index)
                                                               : pen_random2(p->hash, index));
        a[i] = at.x;
        b[i] = at.y;
    }
    p->next += (uint32_t)n;
    return n;
}

/* How many points there are in all. */
static inline uint32_t points_count(const struct points *p)
{
    uint32_t count = 0;
    if (p->pattern != PEN_PATTERN_GRID)
        return p->samples;
    for (uint32_t i = 0; i < p->samples; i++) {
        struct points_row row = points_row(p->samples, i);
        struct pen_point2 at;
        for (uint32_t column = row.out; column < row.in; column++)
            count += points_cell(p, i, column, &at);
        for (uint32_t column = row.in_stop; column < row.stop; column++)
            count += points_cell(p, i, column, &at);
        count += row.in_stop - row.in;
    }
    return count > 0 ? count : 1;
}

#endif
