/* SPDX-License-Identifier: MIT */
/* Coordinates so small that products of them vanish, beside coordinates of unit size. A tree still
 * gives the result of trying all primitives. */
#include <math.h>

#include "property/gen.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "scene/settings.h"

static struct world world;
static struct primitives_tree kinds[PEN_ACCEL_COUNT];

/* A number near no other: 0, some steps of the least subnormal, any power of two below 1, or a
 * multiple of a sixteenth, as it is or beside one. */
static double draw_number(struct random *r)
{
    double sign = random_below(r, 2) ? -1 : 1;
    switch (random_below(r, 6)) {
    case 0:
        return sign * 0;
    case 1:
        return sign * random_below(r, 4) * 0x1p-1074;
    case 2:
        return sign * exp2(-(double)random_below(r, 1075));
    case 3:
        return sign * random_in(r, 1, 2) * exp2(-(double)random_below(r, 1060));
    default:
        return gen_dyadic(r, 1);
    }
}

static vec3 draw_point(struct random *r)
{
    double x = draw_number(r), y = draw_number(r);
    return pen_vec3(x, y, draw_number(r));
}

static void add_flat(struct random *r)
{
    vec3 v[4] = {draw_point(r), draw_point(r), draw_point(r)}, corner[4];
    struct pen_triangle tri;
    struct pen_polygon pg;
    uint32_t flat = random_below(r, 3);
    for (int i = 0; i < 3 && random_below(r, 2); i++) /* along an axis */
        (&v[i].x)[flat] = v[0].x;
    v[3] = pen_add(v[0], pen_sub(v[2], v[1]));
    for (int i = 0; i < 4; i++) /* as scenes are frozen */
        corner[i] = pen_without_less(v[i], PEN_LEAST);
    if (random_below(r, 2)) {
        if (pen_triangle_make(&tri, corner[0], corner[1], corner[2]))
            world_triangle(&world, v[0], v[1], v[2]);
    } else if (pen_polygon_make(&pg, corner, 4)) {
        world_polygon(&world, v, 4);
    }
}

static void add_primitive(struct random *r)
{
    vec3 c = draw_point(r), a = random_below(r, 2) ? gen_axial(r) : random_direction(r);
    switch (random_below(r, 10)) {
    case 0:
        world_sphere(&world, c, random_in(r, .1, 1));
        break;
    case 1:
        world_cylinder(&world, c, a, random_in(r, .1, .5), random_in(r, .1, 1), random_below(r, 2));
        break;
    case 2:
        world_plane(&world, c, a);
        break;
    case 3:
        world_infinite_cylinder(&world, c, a, random_in(r, .01, .1));
        break;
    default:
        add_flat(r);
    }
}

static void build(double scene)
{
    static double built = -1;
    struct random r = {(uint64_t)scene * 0x9e3779b97f4a7c15u + 17, 0};
    if (built == scene)
        return;
    built = scene;
    world_clear(&world);
    for (uint32_t i = 3 + random_below(&r, 20); i > 0; i--)
        add_primitive(&r);
    for (int k = 0; k < PEN_ACCEL_COUNT; k++)
        primitives_build_kind(&kinds[k], &world.prims, (enum pen_accelerator)k);
}

/* Arguments: scene, o, d. */
static void draw_vanishing(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(d->index / 256));
    vec3 o = draw_point(r), to = draw_point(r);
    if (random_below(r, 3) == 0) {
        build(c->arg[0]);
        const struct pen_prims *p = &world.prims;
        if (p->kind_count[PEN_PRIM_TRIANGLE])
            to = p->triangle[random_below(r, p->kind_count[PEN_PRIM_TRIANGLE])]
                     .v[random_below(r, 3)];
        o = random_below(r, 2) ? pen_add(to, gen_axial(r)) : o;
    }
    row_arg3(c, o);
    row_arg3(c, random_below(r, 4) ? pen_sub(to, o) : random_below(r, 2) ? gen_axial(r) : to);
}

static void judge_vanishing(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double scene = row_next(c, &at);
    vec3 o = row_next3(c, &at);
    struct pen_ray ray;
    if (!pen_ray_make(&ray, o, row_next3(c, &at))) {
        row_skip(v);
        return;
    }
    build(scene);
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit truth = world_nearest(&world, &ray, &pen_origin_none, &interval);
    for (int k = 0; k < PEN_ACCEL_COUNT; k++) {
        bool alike;
        const char *name = pen_accelerator_name((enum pen_accelerator)k);
        struct pen_hit hit =
            primitives_nearest(&kinds[k], &ray, &pen_origin_none, INFINITY, &alike);
        if (!alike)
            row_fail(v, "%s: instruction sets differ", name);
        if (hit.prim != truth.prim ||
            (hit.prim != PEN_NO_PRIM && (hit.t != truth.t || hit.part != truth.part)))
            row_fail(v, "%s meets %d at %a, trying all meets %d at %a", name, (int)hit.prim, hit.t,
                     (int)truth.prim, truth.t);
    }
    row_tally(v, truth.prim == PEN_NO_PRIM ? "past everything" : "hit");
}

void rows_vanishing(struct pen_row_run *run)
{
    row_each(run, draw_vanishing, judge_vanishing);
}
