/* SPDX-License-Identifier: MIT */
/* Compares two pictures in one pass over their rows. Each row is summed separately before it is
 * added to the total, which keeps the rounding error of a large picture's sum small. */
#include "film/metrics.h"

#include <math.h>
#include <stdlib.h>

#include "film/encode.h"
#include "film/internal/picture.h"
#include "math/fn.h"

/* Added to the tolerance: 8-bit codes that are 2 apart differ by 2/255 only up to rounding. */
static const double rounding_slack = 1e-12;

/* Added to the square of the reference, so that black pixels do not decide relative_mse. */
static const double relative_epsilon = 1e-2;

static void update_largest(struct pen_difference *d, double error, int x, int y)
{
    if (error > d->max_error) {
        d->max_error = error;
        d->max_x = x;
        d->max_y = y;
    }
}

/* Sums of squared differences: of all pixels, and of those within the tolerance. */
struct squares {
    double all, within;
};

/* A row of a picture, with the number of values of each pixel. */
struct row {
    double *encoded, *linear, *alpha;
};
enum { ROW_VALUES = 7 };

static struct row row_of(double *memory, int width)
{
    return (struct row){memory, memory + 3 * (size_t)width, memory + 6 * (size_t)width};
}

static void read_row(const struct pen_picture *picture, int y, struct row *row)
{
    pen_picture_encoded_row(picture, y, row->encoded);
    pen_picture_linear_row(picture, y, row->linear);
    pen_picture_alpha_row(picture, y, row->alpha);
}

/* The encoded value i of a row, not clamped. */
static double unclamped(const struct row *row, size_t i)
{
    const double linear = row->linear[i];
    return linear < 0 || linear > 1 ? pen_encode_srgb(linear) : row->encoded[i];
}

static struct squares compare_row(const struct row *a, const struct row *b, bool clamped, int width,
                                  int y, struct pen_difference *d)
{
    struct squares sum = {0, 0};
    for (int x = 0; x < width; x++) {
        double square = 0, largest = 0;
        for (size_t i = 3 * (size_t)x; i < 3 * (size_t)x + 3; i++) {
            double error = fabs(a->encoded[i] - b->encoded[i]);
            square += error * error;
            if (!clamped)
                error = fabs(unclamped(a, i) - unclamped(b, i));
            largest = error > largest ? error : largest;
        }
        const bool other_alpha = a->alpha[x] != b->alpha[x];
        update_largest(d, largest, x, y);
        d->differing += largest > 0 || other_alpha;
        d->alpha += other_alpha;
        sum.all += square;
        if (largest > d->tolerance + rounding_slack)
            d->over++;
        else
            sum.within += square;
    }
    return sum;
}

/* The sum of relative square errors of a row of linear values; b is the reference. */
static double relative_row(const double *a, const double *b, int width)
{
    double sum = 0;
    for (size_t i = 0; i < 3 * (size_t)width; i++) {
        const double error = a[i] - b[i];
        sum += error * error / (b[i] * b[i] + relative_epsilon);
    }
    return sum;
}

bool pen_picture_same_size(const struct pen_picture *a, const struct pen_picture *b,
                           struct pen_status *st)
{
    const int width = pen_picture_width(a), height = pen_picture_height(a);
    if (width == pen_picture_width(b) && height == pen_picture_height(b))
        return true;
    return pen_fail(st, PEN_INVALID, "pictures of %d x %d and %d x %d pixels do not compare", width,
                    height, pen_picture_width(b), pen_picture_height(b));
}

bool pen_picture_compare(const struct pen_picture *a, const struct pen_picture *b, double tolerance,
                         struct pen_difference *out, struct pen_status *st)
{
    const int width = pen_picture_width(a), height = pen_picture_height(a);
    if (!pen_picture_same_size(a, b, st))
        return false;
    double *memory = malloc((size_t)width * 2 * ROW_VALUES * sizeof *memory);
    if (!memory)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to compare pictures");
    struct pen_difference d = {.tolerance = tolerance};
    struct squares sum = {0, 0};
    const bool clamped = !pen_picture_is_pfm(a) || !pen_picture_is_pfm(b);
    struct row row_a = row_of(memory, width),
               row_b = row_of(memory + ROW_VALUES * (size_t)width, width);
    double relative = 0;
    for (int y = 0; y < height; y++) {
        read_row(a, y, &row_a);
        read_row(b, y, &row_b);
        const struct squares row = compare_row(&row_a, &row_b, clamped, width, y, &d);
        sum.all += row.all;
        sum.within += row.within;
        relative += relative_row(row_a.linear, row_b.linear, width);
    }
    free(memory);
    const double pixels = (double)width * height, within = pixels - (double)d.over;
    d.rmse = sqrt(sum.all / (3 * pixels));
    d.relative_mse = relative / (3 * pixels);
    d.psnr = d.rmse > 0 ? -20 * pen_ln(d.rmse) / pen_ln(10) : (double)INFINITY;
    d.rmse_within = within > 0 ? sqrt(sum.within / (3 * within)) : 0;
    *out = d;
    return true;
}
