/* SPDX-License-Identifier: MIT */
/* The points of a light that `grid` samples, from the definition of the cells' points. */
#include "property/rows.h"
#include "shade/internal/light_points.h"

enum { MOST = 1024 };

/* Arguments: two halves of a hash, the number of samples. */
static void draw_grid(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(random_bits(r) >> 32));
    row_fixed(c, (double)(random_bits(r) >> 32));
    row_fixed(c, random_below(r, 2) ? 1 + random_below(r, 4) : 1 + random_below(r, MOST));
}

/* SplitMix64: Steele, Lea, Flood, OOPSLA 2014. */
static uint64_t splitmix(uint64_t seed, uint64_t n)
{
    uint64_t z = seed + (n + 1) * UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

/* The points of the first drawing that has any, from the definition. */
static int expected(uint64_t hash, uint32_t edge, double *x, double *y)
{
    int count = 0;
    for (uint32_t first = 0; count == 0; first += edge * edge)
        for (uint32_t cell = 0; cell < edge * edge; cell++) {
            uint64_t bits = splitmix(hash, first + cell);
            double a = ((double)(uint32_t)bits + 0.5) * 0x1p-32;
            double b = ((double)(bits >> 32) + 0.5) * 0x1p-32;
            x[count] = 2 * ((cell % edge + a) / edge) - 1;
            y[count] = 2 * ((cell / edge + b) / edge) - 1;
            count += x[count] * x[count] + y[count] * y[count] <= 1;
        }
    return count;
}

static void judge_grid(const struct row_case *c, struct row_verdict *v)
{
    static double x[MOST + 64], y[MOST + 64];
    int at = 0, done = 0, samples;
    double high = row_next(c, &at), low = row_next(c, &at);
    samples = (int)row_next(c, &at);
    if (!(high >= 0 && high < 0x1p32 && low >= 0 && low < 0x1p32 && samples >= 1 &&
          samples <= MOST)) {
        row_skip(v);
        return;
    }
    uint64_t hash = (uint64_t)high << 32 | (uint64_t)low;
    struct pen_settings settings = {.light_pattern = PEN_PATTERN_GRID, .light_samples = samples};
    struct points points = points_begin(&settings, hash);
    struct point_list list;
    int count = expected(hash, (uint32_t)ceil(sqrt(samples)), x, y);
    row_require(v, points_count(&points) == (uint32_t)count, "the count of points");
    for (int n; (n = points_fill(&points, &list)) > 0; done += n)
        for (int i = 0; i < n && done + i < count; i++)
            row_require(v, list.a[i] == x[done + i] && list.b[i] == y[done + i], "a point");
    row_require(v, done == count, "the number of points");
    row_tally(v, points.first ? "drawn again" : "drawn once");
}

void rows_grid_points(struct pen_row_run *run)
{
    row_each(run, draw_grid, judge_grid);
}
