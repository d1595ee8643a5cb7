/* SPDX-License-Identifier: MIT */
/* The mean over the points of `grid`, against its exact expectation. This is the share of the disk
 * behind a straight edge, which has a closed form, plus the bias of a mean over a random number of
 * points. The bias follows from the areas of the cells: one cell after the other is added to the
 * distribution of (points right of the edge, points). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "shade/internal/light_points.h"
#include "support/random.h"
#include "support/suite.h"

enum { MOST = 8, CELLS = MOST * MOST, SLICES = 2000 };

/* The share of the unit disk with x > h. */
static double behind(double h)
{
    return (acos(h) - h * sqrt(1 - h * h)) / M_PI;
}

/* The shares of cell (i, j) of edge x edge that are in the disk, right of x = h and left of it. */
static void shares(int edge, int i, int j, double h, double *right, double *left)
{
    double size = 2. / edge, slice = size / SLICES, low = -1 + j * size, high = low + size;
    *right = *left = 0;
    for (int k = 0; k < SLICES; k++) {
        double x = -1 + i * size + (k + 0.5) * slice, half = sqrt(1 - x * x);
        double length = fmax(0, fmin(high, half) - fmax(low, -half)) / size / SLICES;
        double share = fmin(1, fmax(0, 0.5 + (x - h) / slice));
        *right += share * length;
        *left += (1 - share) * length;
    }
}

/* The expectation of (points right of h) / (points), given that there are points; *deviation: its
 * standard deviation. */
static double expectation(int edge, double h, double *deviation)
{
    static double chance[CELLS + 1][CELLS + 1];
    int most = edge * edge;
    for (int r = 0; r <= most; r++)
        for (int n = 0; n <= most; n++)
            chance[r][n] = r + n == 0;
    for (int cell = 0; cell < most; cell++) {
        double right, left;
        shares(edge, cell % edge, cell / edge, h, &right, &left);
        for (int r = cell + 1; r >= 0; r--)
            for (int n = cell + 1; n >= 0; n--)
                chance[r][n] = chance[r][n] * (1 - right - left) +
                               (n > 0 ? chance[r][n - 1] * left : 0) +
                               (n > 0 && r > 0 ? chance[r - 1][n - 1] * right : 0);
    }
    double mean = 0, square = 0, any = 1 - chance[0][0];
    for (int n = 1; n <= most; n++)
        for (int r = 0; r <= n; r++) {
            mean += chance[r][n] * r / n / any;
            square += chance[r][n] * ((double)r * r) / ((double)n * n) / any;
        }
    *deviation = sqrt(fmax(0, square - mean * mean));
    return mean;
}

static const double edges[] = {-0.9, -0.3, 0, 0.3, 0.6, 0.9};
enum { EDGES = 6 };

/* The means over `drawings` sets of points with x > edges[i]. */
static void measure(int samples, long drawings, double mean[EDGES])
{
    struct pen_settings settings = {.light_pattern = PEN_PATTERN_GRID, .light_samples = samples};
    struct random random = random_begin((uint64_t)samples);
    for (int e = 0; e < EDGES; e++)
        mean[e] = 0;
    for (long i = 0; i < drawings; i++) {
        struct points points = points_begin(&settings, random_bits(&random));
        struct point_list list;
        uint32_t count = points_count(&points), all = 0, right[EDGES] = {0};
        for (int n; (n = points_fill(&points, &list)) > 0; all += (uint32_t)n)
            for (int k = 0; k < n; k++)
                for (int e = 0; e < EDGES; e++)
                    right[e] += list.a[k] > edges[e];
        ck_assert(all == count && all > 0);
        for (int e = 0; e < EDGES; e++)
            mean[e] += (double)right[e] / all;
    }
    for (int e = 0; e < EDGES; e++)
        mean[e] /= (double)drawings;
}

/* One point is uniform in the disk, so its mean has no bias; that of more has the bias that is
 * computed, and no other. The largest at any edge is what api/scene-format.md states. */
START_TEST(test_light_points__h121_means_of_the_grid)
{
    static const struct {
        int samples, drawings;
        double bias; /* the largest at any edge, rounded up */
    } rows[] = {{1, 1000000, 1e-4},
                {4, 1000000, 1e-4},
                {9, 300000, 0.0043},
                {16, 100000, 0.0020},
                {64, 20000, 0.0003}};
    for (int i = 0; i < 5; i++) {
        int edge = (int)ceil(sqrt(rows[i].samples));
        double mean[EDGES], deviation, most = 0;
        measure(rows[i].samples, rows[i].drawings, mean);
        for (int e = 0; e < EDGES; e++) {
            double exact = expectation(edge, edges[e], &deviation);
            double sigma = deviation / sqrt(rows[i].drawings), off = (mean[e] - exact) / sigma;
            printf("%d points, edge at %g: bias %+.5f, measured %+.5f (%+.1f sigma beside it)\n",
                   rows[i].samples, edges[e], exact - behind(edges[e]), mean[e] - behind(edges[e]),
                   off);
            ck_assert_msg(fabs(off) < 4, "off by %g sigma", off);
        }
        for (double h = -0.98; h < 0.99; h += 0.02)
            most = fmax(most, fabs(expectation(edge, h, &deviation) - behind(h)));
        printf("%d points: bias %.5f at most\n", rows[i].samples, most);
        ck_assert(most <= rows[i].bias);
    }
}
END_TEST

PEN_SUITE("light_points", test_light_points__h121_means_of_the_grid)
