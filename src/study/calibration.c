/* SPDX-License-Identifier: MIT */
#include "study/internal/calibration.h"

#include <math.h>
#include <stdint.h>

#include "base/clock.h"
#include "study/internal/random_order.h"

enum { SPHERES = 512, RAYS = 2048 };

/* Uniform in [0, 1). */
static double next(uint64_t *state)
{
    return (double)(pen_random_next(state) >> 11) * 0x1p-53;
}

struct sphere {
    double x, y, z, square; /* centre; the radius, squared */
};

/* The distance at which the ray from the origin along (x, y, 1) enters the nearest sphere; 1000 if
 * it misses all. */
static double nearest(const struct sphere *spheres, double x, double y)
{
    const double length = sqrt(x * x + y * y + 1);
    double least = 1000;
    for (int i = 0; i < SPHERES; i++) {
        const struct sphere *s = &spheres[i];
        const double along = (s->x * x + s->y * y + s->z) / length;
        const double inside = along * along - (s->x * s->x + s->y * s->y + s->z * s->z) + s->square;
        if (inside > 0 && along - sqrt(inside) < least)
            least = along - sqrt(inside);
    }
    return least;
}

double pen_calibration_run(void)
{
    struct sphere spheres[SPHERES];
    uint64_t state = 1;
    double sum = 0;
    for (int i = 0; i < SPHERES; i++)
        spheres[i] = (struct sphere){.x = 8 * next(&state) - 4,
                                     .y = 8 * next(&state) - 4,
                                     .z = 6 + 8 * next(&state),
                                     .square = 0.04 * next(&state)};
    const int64_t begun_ns = pen_clock_ns();
    for (int i = 0; i < RAYS; i++) {
        const double x = next(&state) - 0.5;
        sum += nearest(spheres, x, next(&state) - 0.5);
    }
    volatile double used = sum; /* so that the compiler removes nothing */
    (void)used;
    return (double)(pen_clock_ns() - begun_ns) * 1e-6;
}
