/* SPDX-License-Identifier: MIT */
/* A box filter, along rows and then across them. A pixel of the picture overlaps at most two of the
 * copy in each direction, since the copy is not larger. */
#include "film/shrink.h"

#include <stdlib.h>

/* The pixels of the copy that pixel i overlaps, and the part of each that it covers. */
struct overlap {
    int first;             /* the next one is first + 1 */
    double in_first, rest; /* 0 if there is no next one */
};

/* In units in which a pixel of the picture has the length `to`, and one of the copy `from`. */
static struct overlap overlap_of(int i, int from, int to)
{
    const int64_t begin = (int64_t)i * to, first = begin / from;
    const int64_t left = (first + 1) * from - begin, in_first = left < to ? left : to;
    return (struct overlap){(int)first, (double)in_first / from, (double)(to - in_first) / from};
}

/* Adds `count` values, times a weight. */
static void add(float *sum, const double *values, double weight, int count)
{
    for (int i = 0; weight > 0 && i < count; i++)
        sum[i] = (float)((double)sum[i] + weight * values[i]);
}

static void shrink_row(const double *row, int from, int to, double *out)
{
    for (int i = 0; i < 3 * to; i++)
        out[i] = 0;
    for (int x = 0; x < from; x++) {
        const struct overlap part = overlap_of(x, from, to);
        double *at = out + 3 * part.first;
        for (int c = 0; c < 3; c++) {
            at[c] += part.in_first * row[3 * x + c];
            if (part.rest > 0)
                at[3 + c] += part.rest * row[3 * x + c];
        }
    }
}

static void shrink(const struct pen_picture *picture, struct pen_film *film, double *row,
                   double *narrow)
{
    const int width = pen_picture_width(picture), height = pen_picture_height(picture),
              count = 3 * film->width;
    for (int y = 0; y < height; y++) {
        const struct overlap part = overlap_of(y, height, film->height);
        float *at = film->rgb + (size_t)part.first * (size_t)count;
        pen_picture_linear_row(picture, y, row);
        shrink_row(row, width, film->width, narrow);
        add(at, narrow, part.in_first, count);
        add(at + count, narrow, part.rest, count);
    }
}

/* The shorter edge of the copy. */
static int scaled(int shorter, int longer, int edge)
{
    const int64_t rounded = ((int64_t)shorter * edge + longer / 2) / longer;
    return rounded > 1 ? (int)rounded : 1;
}

struct pen_film *pen_picture_shrink(const struct pen_picture *picture, int edge,
                                    struct pen_status *st)
{
    const int width = pen_picture_width(picture), height = pen_picture_height(picture);
    struct pen_film *film = width >= height ? pen_film_new(edge, scaled(height, width, edge), st)
                                            : pen_film_new(scaled(width, height, edge), edge, st);
    if (!film)
        return NULL;
    double *rows = malloc((size_t)(width + film->width) * 3 * sizeof *rows);
    if (rows) {
        shrink(picture, film, rows, rows + 3 * (size_t)width);
        free(rows);
        return film;
    }
    pen_fail(st, PEN_NO_MEMORY, "no memory for a small picture");
    pen_film_free(film);
    return NULL;
}
