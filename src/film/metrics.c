/* SPDX-License-Identifier: MIT */
/* Compares two pictures in one pass over their rows. Each row is summed by itself before it is
 * added to the total, which keeps the rounding error of a large picture's sum small. */
#include "film/metrics.h"

#include <math.h>
#include <stdlib.h>

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

static struct squares compare_row(const double *a, const double *b, int width, int y,
                                  struct pen_difference *d)
{
    struct squares sum = {0, 0};
    for (int x = 0; x < width; x++) {
        double square = 0, largest = 0;
        for (int c = 0; c < 3; c++) {
            double error = fabs(a[3 * x + c] - b[3 * x + c]);
            square += error * error;
            largest = error > largest ? error : largest;
        }
        update_largest(d, largest, x, y);
        d->differing += largest > 0;
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
    double *row_a = malloc((size_t)width * 6 * sizeof *row_a);
    if (!row_a)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to compare pictures");
    struct pen_difference d = {.tolerance = tolerance};
    struct squares sum = {0, 0};
    double *row_b = row_a + 3 * (size_t)width, relative = 0;
    for (int y = 0; y < height; y++) {
        pen_picture_encoded_row(a, y, row_a);
        pen_picture_encoded_row(b, y, row_b);
        const struct squares row = compare_row(row_a, row_b, width, y, &d);
        sum.all += row.all;
        sum.within += row.within;
        pen_picture_linear_row(a, y, row_a);
        pen_picture_linear_row(b, y, row_b);
        relative += relative_row(row_a, row_b, width);
    }
    free(row_a);
    const double pixels = (double)width * height, within = pixels - (double)d.over;
    d.rmse = sqrt(sum.all / (3 * pixels));
    d.relative_mse = relative / (3 * pixels);
    d.psnr = d.rmse > 0 ? -20 * pen_ln(d.rmse) / pen_ln(10) : (double)INFINITY;
    d.rmse_within = within > 0 ? sqrt(sum.within / (3 * within)) : 0;
    *out = d;
    return true;
}
