/* SPDX-License-Identifier: MIT */
/* SSIM with separable windows. A picture is processed in strips of columns. Within a strip its rows
 * are read from the top, and the moments of each row are kept until windows no longer need them. So
 * the memory does not depend on the size of the pictures. */
#include "film/ssim.h"

#include <stdlib.h>

#include "film/internal/picture.h"
#include "film/internal/row_filter.h"
#include "film/metrics.h"
#include "math/fn.h"

enum {
    WINDOW = 11,
    STRIP = 256, /* windows beside each other */
    PADDED = STRIP + WINDOW - 1
};

/* The quantities that are averaged in a window, for the lumas a and b. */
enum moment { A, B, AA, BB, AB, MOMENTS };

/* Weights of a window along one axis. */
struct window {
    int size;
    double weight[WINDOW];
};

struct strip {
    const struct pen_picture *a, *b;
    struct window across, down;
    int x, count;                       /* the windows: column of the first, and their number */
    double encoded[3 * PADDED];         /* a row as read */
    double product[MOMENTS][PADDED];    /* of each pixel of a row */
    double row[MOMENTS][WINDOW][STRIP]; /* moments of row y at y % WINDOW, within windows */
    double moment[MOMENTS][STRIP];      /* of whole windows */
};

static struct window window_of(int side)
{
    struct window w = {.size = side < WINDOW ? side : WINDOW};
    double sum = 0;
    for (int i = 0; i < w.size; i++) {
        const double from_centre = i - (w.size - 1) / 2.0;
        w.weight[i] = pen_exp(-from_centre * from_centre / (2 * 1.5 * 1.5));
        sum += w.weight[i];
    }
    for (int i = 0; i < w.size; i++)
        w.weight[i] /= sum;
    return w;
}

static void read_luma(struct strip *s, const struct pen_picture *picture, int y, double *luma)
{
    const int pixels = s->count + s->across.size - 1;
    pen_picture_encoded_part(picture, (struct pen_picture_part){s->x, y, pixels}, s->encoded);
    for (int i = 0; i < pixels; i++) {
        const double *rgb = s->encoded + 3 * i;
        luma[i] = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    }
}

/* Reads row y of both pictures and sums its moments along the windows. */
static void read_row(struct strip *s, int y)
{
    const struct window *w = &s->across;
    double *a = s->product[A], *b = s->product[B];
    read_luma(s, s->a, y, a);
    read_luma(s, s->b, y, b);
    for (int i = 0; i < s->count + w->size - 1; i++) {
        s->product[AA][i] = a[i] * a[i];
        s->product[BB][i] = b[i] * b[i];
        s->product[AB][i] = a[i] * b[i];
    }
    for (int m = 0; m < MOMENTS; m++) {
        double *out = s->row[m][y % WINDOW];
        row_scale(out, s->product[m], w->weight[0], s->count);
        for (int i = 1; i < w->size; i++)
            row_add(out, s->product[m] + i, w->weight[i], s->count);
    }
}

/* Sums the rows of the windows whose top row is y. */
static void sum_rows(struct strip *s, int y)
{
    const struct window *w = &s->down;
    for (int m = 0; m < MOMENTS; m++) {
        row_scale(s->moment[m], s->row[m][y % WINDOW], w->weight[0], s->count);
        for (int i = 1; i < w->size; i++)
            row_add(s->moment[m], s->row[m][(y + i) % WINDOW], w->weight[i], s->count);
    }
}

/* The index of one window: equation 13. It is at most 1, as 2 ab <= a2 + b2, also for deviations.
 * Moments of values that hardly vary cancel, so rounding could move it beyond 1. */
static double similarity(const struct strip *s, int i)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const double a = s->moment[A][i], b = s->moment[B][i], a2 = a * a, b2 = b * b, ab = a * b;
    const double variance_a = s->moment[AA][i] - a2, variance_b = s->moment[BB][i] - b2,
                 covariance = s->moment[AB][i] - ab;
    const double index =
        (2 * ab + c1) * (2 * covariance + c2) / ((a2 + b2 + c1) * (variance_a + variance_b + c2));
    return index < 1 ? index : 1;
}

/* The sum over the windows of the strip. */
static double sum_strip(struct strip *s)
{
    const int height = pen_picture_height(s->a);
    double sum = 0;
    for (int y = 0; y < height; y++) {
        double row = 0;
        read_row(s, y);
        const int top = y - (s->down.size - 1);
        if (top < 0)
            continue;
        sum_rows(s, top);
        for (int i = 0; i < s->count; i++)
            row += similarity(s, i);
        sum += row;
    }
    return sum;
}

bool pen_picture_ssim(const struct pen_picture *a, const struct pen_picture *b, double *out,
                      struct pen_status *st)
{
    if (!pen_picture_same_size(a, b, st))
        return false;
    struct strip *s = calloc(1, sizeof *s);
    if (!s)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to compare pictures");
    const int width = pen_picture_width(a), height = pen_picture_height(a);
    s->a = a;
    s->b = b;
    s->across = window_of(width);
    s->down = window_of(height);
    const int columns = width - s->across.size + 1, rows = height - s->down.size + 1;
    double sum = 0;
    for (; s->x < columns; s->x += s->count) {
        s->count = columns - s->x < STRIP ? columns - s->x : STRIP;
        sum += sum_strip(s);
    }
    free(s);
    *out = sum / ((double)columns * rows);
    return true;
}
