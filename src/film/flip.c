/* SPDX-License-Identifier: MIT */
/* FLIP, pixel by pixel. A picture is processed in strips of columns. Within a strip its rows are
 * read from the top, filtered along themselves by each filter, and kept until filters across no
 * longer need them. So the memory does not depend on the size of the pictures. */
#include "film/flip.h"

#include <math.h>
#include <stdlib.h>

#include "film/internal/flip_colour.h"
#include "film/internal/flip_filters.h"
#include "film/internal/flip_pool.h"
#include "film/internal/picture.h"
#include "film/internal/row_filter.h"
#include "film/metrics.h"
#include "math/fn.h"

enum {
    RADIUS = FLIP_CONTRAST_RADIUS,
    RING = 2 * RADIUS + 1, /* rows that a filter across needs */
    STRIP = 256,           /* columns */
    PADDED = STRIP + 2 * RADIUS
};

/* The opponent (flip_colour.h) for each filter. */
static const int channel_of[FLIP_FILTERS] = {
    [FLIP_RED_GREEN] = 1, [FLIP_BLUE_YELLOW_1] = 2, [FLIP_BLUE_YELLOW_2] = 2};

/* One of the two pictures, in one strip. */
struct side {
    const struct pen_picture *picture;
    double linear[3 * PADDED];  /* a row as read */
    double opponent[3][PADDED]; /* and its colours, with RADIUS more columns at each end */
    double along[FLIP_FILTERS][RING][STRIP]; /* row y, filtered along itself, at y % RING */
    /* One row, filtered along and across. */
    double colour[3][STRIP], edge[2][STRIP], point[2][STRIP];
};

struct strip {
    struct flip_filter filter[FLIP_FILTERS];
    double colour_error_max;
    int x, count; /* its columns */
    int height;
    struct side side[2];
};

/* Reads row y and the pixels beside the strip. */
static void read_row(const struct strip *s, struct side *side, int y)
{
    const int width = pen_picture_width(side->picture), left = s->x - RADIUS,
              right = s->x + s->count + RADIUS, first = left > 0 ? left : 0,
              end = right < width ? right : width;
    pen_picture_linear_part(side->picture, (struct pen_picture_part){first, y, end - first},
                            side->linear);
    for (int x = first; x < end; x++) {
        double colour[3];
        pen_flip_opponents(side->linear + 3 * (x - first), colour);
        for (int c = 0; c < 3; c++)
            side->opponent[c][x - left] = colour[c];
    }
    for (int c = 0; c < 3; c++) {
        double *row = side->opponent[c];
        for (int x = left; x < first; x++)
            row[x - left] = row[first - left];
        for (int x = end; x < right; x++)
            row[x - left] = row[end - 1 - left];
    }
}

/* Adds, for each value, the two values at one distance from it. */
static void add_pair(const struct flip_filter *f, int distance, const double *before,
                     const double *after, int count, double *out)
{
    if (f->odd)
        row_add_difference(out, after, before, f->weight[distance], count);
    else
        row_add_sum(out, before, after, f->weight[distance], count);
}

/* Filters the current row along itself, with every filter. */
static void filter_along(const struct strip *s, struct side *side, int y)
{
    for (int i = 0; i < FLIP_FILTERS; i++) {
        const struct flip_filter *f = &s->filter[i];
        const double *in = side->opponent[channel_of[i]] + RADIUS;
        double *out = side->along[i][y % RING];
        row_scale(out, in, f->weight[0], s->count);
        for (int d = 1; d <= f->radius; d++)
            add_pair(f, d, in - d, in + d, s->count, out);
    }
}

/* Row y of the result of filter `i`; the first or last row if y is outside. */
static const double *row_along(const struct strip *s, const struct side *side, int i, int y)
{
    const int inside = y < 0 ? 0 : y < s->height ? y : s->height - 1;
    return side->along[i][inside % RING];
}

/* Adds row y of the result of filter `along`, filtered across by filter `across`, to out[]. */
static void add_across(const struct strip *s, const struct side *side, int y, int along, int across,
                       double *out)
{
    const struct flip_filter *f = &s->filter[across];
    row_add(out, row_along(s, side, along, y), f->weight[0], s->count);
    for (int d = 1; d <= f->radius; d++)
        add_pair(f, d, row_along(s, side, along, y - d), row_along(s, side, along, y + d), s->count,
                 out);
}

static void clear(double *row, int count)
{
    for (int x = 0; x < count; x++)
        row[x] = 0;
}

/* Filters row y across. The derivative along an axis is smoothed along the other one. */
static void filter_across(const struct strip *s, struct side *side, int y)
{
    const struct {
        int along, across;
        double *out;
    } steps[] = {
        {FLIP_LUMINANCE, FLIP_LUMINANCE, side->colour[0]},
        {FLIP_RED_GREEN, FLIP_RED_GREEN, side->colour[1]},
        {FLIP_BLUE_YELLOW_1, FLIP_BLUE_YELLOW_1, side->colour[2]},
        {FLIP_BLUE_YELLOW_2, FLIP_BLUE_YELLOW_2, side->colour[2]},
        {FLIP_EDGE, FLIP_SMOOTH, side->edge[0]},
        {FLIP_SMOOTH, FLIP_EDGE, side->edge[1]},
        {FLIP_POINT, FLIP_SMOOTH, side->point[0]},
        {FLIP_SMOOTH, FLIP_POINT, side->point[1]},
    };
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        if (i == 0 || steps[i].out != steps[i - 1].out)
            clear(steps[i].out, s->count);
        add_across(s, side, y, steps[i].along, steps[i].across, steps[i].out);
    }
}

static double length(const double vector[2][STRIP], int x)
{
    return sqrt(vector[0][x] * vector[0][x] + vector[1][x] * vector[1][x]);
}

/* The difference of the edge and the point at a pixel, from 0 to 1. */
static double feature_error(const struct side *a, const struct side *b, int x)
{
    const double edge = fabs(length(a->edge, x) - length(b->edge, x)),
                 point = fabs(length(a->point, x) - length(b->point, x)),
                 larger = (edge > point ? edge : point) / sqrt(2);
    return larger < 1 ? sqrt(larger) : 1;
}

static double colour_error(const struct strip *s, int x)
{
    double lab[2][3];
    for (int i = 0; i < 2; i++) {
        const struct side *side = &s->side[i];
        const double colour[3] = {side->colour[0][x], side->colour[1][x], side->colour[2][x]};
        pen_flip_lab(colour, lab[i]);
    }
    return pen_flip_colour_error(lab[0], lab[1], s->colour_error_max);
}

/* Writes the errors of one row of the strip. A difference of features increases that of colours. */
static void write_row(struct strip *s, int y, float *errors)
{
    for (int i = 0; i < 2; i++)
        filter_across(s, &s->side[i], y);
    for (int x = 0; x < s->count; x++) {
        const double colour = colour_error(s, x);
        errors[x] =
            colour > 0 ? (float)pen_pow(colour, 1 - feature_error(&s->side[0], &s->side[1], x)) : 0;
    }
}

/* Reads and filters each row, and writes each row for which all necessary rows below are available.
 */
static void write_strip(struct strip *s, float *errors)
{
    const size_t width = (size_t)pen_picture_width(s->side[0].picture);
    for (int y = 0; y < s->height + RADIUS; y++) {
        for (int i = 0; y < s->height && i < 2; i++) {
            read_row(s, &s->side[i], y);
            filter_along(s, &s->side[i], y);
        }
        if (y >= RADIUS)
            write_row(s, y - RADIUS, errors + (size_t)(y - RADIUS) * width + s->x);
    }
}

static bool write_errors(const struct pen_picture *a, const struct pen_picture *b, float *errors,
                         struct pen_status *st)
{
    struct strip *s = calloc(1, sizeof *s);
    if (!s)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to compare pictures");
    pen_flip_filters(s->filter);
    s->colour_error_max = pen_flip_colour_error_max();
    s->side[0].picture = a;
    s->side[1].picture = b;
    s->height = pen_picture_height(a);
    for (int width = pen_picture_width(a); s->x < width; s->x += s->count) {
        s->count = width - s->x < STRIP ? width - s->x : STRIP;
        write_strip(s, errors);
    }
    free(s);
    return true;
}

bool pen_picture_flip(const struct pen_picture *a, const struct pen_picture *b, float *errors,
                      struct pen_flip *out, struct pen_status *st)
{
    if (!pen_picture_same_size(a, b, st))
        return false;
    const int width = pen_picture_width(a), height = pen_picture_height(a);
    float *own = errors ? NULL : malloc((size_t)width * (size_t)height * sizeof *own);
    if (!errors && !own)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the errors of %d x %d pixels", width,
                        height);
    if (!errors)
        errors = own;
    const bool ok = write_errors(a, b, errors, st) && pen_flip_pool(errors, width, height, out, st);
    free(own);
    return ok;
}
