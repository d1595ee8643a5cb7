/* SPDX-License-Identifier: MIT */
/* Shadow rays that start and end exactly on a surface: an intersection counts if 0 < t < tmax,
 * strictly at both ends. */
#include <math.h>

#include "property/gen.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "support/isa.h"

static struct world world;
static struct primitives_tree tree;

/* Arguments: a sphere's centre, the power of two that scales it, a point (3, 4, 0) or (5, 0, 0) of
 * its surface with axes and signs in any order, a direction, all dyadic. */
static void draw_span(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    double x[3] = {random_below(r, 2) ? 3 : 5, 0, 0};
    x[1] = x[0] == 3 ? 4 : 0;
    for (int i = 2; i > 0; i--) {
        int k = (int)random_below(r, (uint32_t)i + 1);
        double kept = x[i];
        x[i] = random_below(r, 2) ? x[k] : -x[k];
        x[k] = kept;
    }
    vec3 f = pen_vec3(x[0], x[1], x[2]);
    row_fixed(c, (double)random_below(r, 12) - 6);
    row_arg3(c, gen_dyadic3(r, 4));
    row_arg3(c, f);
    row_arg3(c, random_below(r, 4) ? gen_dyadic3(r, 2) : pen_scale(f, random_below(r, 2) ? 1 : -1));
}

static bool dark(const struct pen_ray *ray, double tmax, struct row_verdict *v)
{
    bool answer = false;
    for (int isa = 0; isa < isa_count(); isa++) {
        struct pen_shadow query = {.tmax = tmax, .last_occluder = PEN_NO_PRIM};
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)isa);
        const bool blocked = ops->shadow(tree.accel, ray, &pen_origin_none, &query);
        row_require(v, isa == 0 || blocked == answer, "instruction sets differ");
        answer = blocked;
    }
    return answer;
}

static void judge_span(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double size = exp2(row_next(c, &at));
    vec3 centre = row_next3(c, &at), f = row_next3(c, &at), d = row_next3(c, &at);
    vec3 o = pen_along(centre, f, size);
    struct pen_ray ray;
    struct pen_hit hit;
    bool alike;
    if (pen_dot(f, f) != 25 || !(pen_norm1(centre) < 64) || !(size > 1e-3 && size < 1e3) ||
        !(pen_norm1(d) < 64) || !pen_ray_make(&ray, o, d)) {
        row_skip(v);
        return;
    }
    world_clear(&world);
    world_sphere(&world, centre, 5 * size);
    for (int i = 0; i < 6; i++)
        world_sphere(&world, pen_vec3(1e6, 1e6 + 3 * i, 1e6), 1);
    primitives_build(&tree, &world.prims);
    bool in = pen_dot(f, d) < 0; /* exactly */
    row_tally(v, in ? "inward" : "outward or along");
    if (!in) {
        row_require(v, !dark(&ray, 1e4, v), "the surface at the start shades");
        return;
    }
    hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    if (!row_require(v, alike && hit.prim == 0 && hit.t > 0, "the far side is not met"))
        return;
    row_require(v, !dark(&ray, hit.t, v), "the surface at the end shades");
    row_require(v, dark(&ray, nextafter(hit.t, INFINITY), v), "what is before the end is passed");
}

void rows_span(struct pen_row_run *run)
{
    row_each(run, draw_span, judge_span);
}
