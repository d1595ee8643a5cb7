/* SPDX-License-Identifier: MIT */
/* Flat primitives much larger than the primitives near them: their extent must not become
 * rounding. */
#include <math.h>

#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"
#include "support/world.h"

static struct world world;

/* A floor in y = 0: one quad, two triangles or four around an inner point. Arguments: which, its
 * size, its turn, the inner point; the eye over it, and where it looks. */
static void draw_over_floor(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, random_below(r, 3));
    row_fixed(c, gen_power(r, 0, 12));
    row_arg(c, random_in(r, 0, 6.28));
    row_arg3(c, pen_vec3(random_in(r, -.3, .3), 0, random_in(r, -.3, .3)));
    row_arg3(c, pen_vec3(random_in(r, -.3, .3), gen_power(r, -30, 0), random_in(r, -.3, .3)));
    row_arg3(c, pen_vec3(random_in(r, -1, 1), -gen_power(r, -3, 0), random_in(r, -1, 1)));
}

/* The floor is met, where y = 0: at t = o.y / -d.y. */
static void judge_over_floor(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, kind = (int)row_next(c, &at);
    double size = row_next(c, &at), turn = row_next(c, &at);
    vec3 inner = row_next3(c, &at), o = row_next3(c, &at), d = row_next3(c, &at), corner[4];
    struct pen_ray ray;
    if (!(size >= 1 && o.y > 0 && d.y < 0 && fabs(inner.x) + fabs(inner.z) < .7 &&
          fabs(o.x) + fabs(o.z) < .7 && o.y * (fabs(d.x) + fabs(d.z)) < -.02 * d.y) ||
        inner.y != 0 || !pen_ray_make(&ray, o, d)) {
        row_skip(v);
        return;
    }
    for (int i = 0; i < 4; i++) {
        double angle = turn + i * 1.57079632679489662;
        corner[i] = pen_vec3(size * cos(angle), 0, -size * sin(angle));
    }
    world_clear(&world);
    if (kind == 0)
        world_polygon(&world, corner, 4);
    for (int i = 0; kind == 1 && i < 4; i += 2)
        world_triangle(&world, corner[i], corner[i + 1], corner[(i + 2) % 4]);
    for (int i = 0; kind == 2 && i < 4; i++)
        world_triangle(&world, corner[i], corner[(i + 1) % 4], inner);
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit = world_nearest(&world, &ray, &pen_origin_none, &interval);
    double truth = ray.o.y / -ray.d.y;
    if (row_require(v, hit.prim != PEN_NO_PRIM, "the floor is looked through"))
        row_measure(v, "t of a floor of any extent [u]", fabs(hit.t / truth - 1) / 0x1p-53, 6);
}

void rows_over_floor(struct pen_row_run *run)
{
    row_each(run, draw_over_floor, judge_over_floor);
}
