/* SPDX-License-Identifier: MIT */
/* Surfaces that coincide or touch. */
#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"

static struct world world;
static struct primitives_tree tree;

/* H070: squares in one plane that overlap, one turned by some angle: which one is met may be
 * rounding's choice, but it is one that is there, and the same whatever looks for it. */
static void draw_overlap(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 n = random_direction(r), x, y;
    gen_frame(r, n, &x, &y);
    vec3 at = random_vec(r, 1), o = pen_along(at, random_direction(r), random_in(r, 1, 6));
    row_arg3(c, at);
    row_arg3(c, x);
    row_arg3(c, y);
    row_arg(c, random_in(r, 0, 6.28));
    row_arg3(c, o);
    vec3 to = pen_along(pen_along(at, x, random_in(r, -1.5, 1.5)), y, random_in(r, -1.5, 1.5));
    row_arg3(c, gen_toward(r, o, to));
}

static void square_of(vec3 at, vec3 x, vec3 y, double turn, vec3 v[4])
{
    vec3 e = pen_along(pen_scale(x, cos(turn)), y, sin(turn));
    vec3 f = pen_along(pen_scale(x, -sin(turn)), y, cos(turn));
    for (int i = 0; i < 4; i++)
        v[i] = pen_along(pen_along(at, e, i == 1 || i == 2 ? 1 : -1), f, i >= 2 ? 1 : -1);
}

static void judge_overlap(const struct row_case *c, struct row_verdict *v)
{
    int i = 0;
    vec3 at = row_next3(c, &i), x = row_next3(c, &i), y = row_next3(c, &i), p[2][4];
    double turn = row_next(c, &i);
    vec3 o = row_next3(c, &i), d = row_next3(c, &i);
    struct pen_ray ray;
    struct pen_hit first;
    struct pen_polygon probe;
    bool alike, unsure[2], in[2];
    square_of(at, x, y, 0, p[0]);
    square_of(pen_add(at, x), x, y, turn, p[1]);
    if (!pen_ray_make(&ray, o, d) || !pen_polygon_make(&probe, p[0], 4) ||
        !pen_polygon_make(&probe, p[1], 4)) {
        row_skip(v);
        return;
    }
    world_clear(&world);
    for (int k = 0; k < 2; k++) {
        world_polygon(&world, p[k], 4);
        in[k] = oracle_winding(p[k], 4, (struct oracle_ray){o, d}, 8, &unsure[k]) != 0;
    }
    primitives_build(&tree, &world.prims);
    primitives_intersections(&world, o, d, &first);
    struct pen_hit hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    row_require(v, alike, "instruction sets differ");
    row_require(v, hit.prim == first.prim && (hit.prim == PEN_NO_PRIM || hit.t == first.t),
                "the tree and trying all differ");
    row_require(v, hit.prim == PEN_NO_PRIM || unsure[hit.prim] || in[hit.prim],
                "met a square that is not there");
    if (in[0] && in[1])
        row_tally(v, first.prim == 0 ? "both there: the first" : "both there: the second");
}

void rows_overlap(struct pen_row_run *run)
{
    row_each(run, draw_overlap, judge_overlap);
}

/* H071: spheres of radius r that touch at a point: in any axis, scaled by powers of two. */
static void draw_touching(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, (double)(d->index % 3));
    row_fixed(c, (double)random_below(&d->random, 401) - 200);
    row_fixed(c, random_below(&d->random, 2));
}

static vec3 turned(int axis, double x, double y, double z)
{
    return axis == 0 ? pen_vec3(x, y, z) : axis == 1 ? pen_vec3(z, x, y) : pen_vec3(y, z, x);
}

static void judge_touching(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, axis = (int)row_next(c, &at), power = (int)row_next(c, &at);
    bool swap = row_next(c, &at) != 0;
    double s = ldexp(1, power);
    struct pen_ray ray;
    struct pen_hit hit[5];
    world_clear(&world);
    for (int k = 0; k < 2; k++)
        world_sphere(&world, turned(axis, (k ^ swap ? 1 : -1) * s, 0, 0), s);
    ray = world_ray(turned(axis, -3 * s, 0, 0), turned(axis, s, 0, 0));
    int count = world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 5);
    row_require(v, count == 4, "not four intersections along the axis");
    row_require(v, hit[0].t == 1 && hit[1].t == 3 && hit[2].t == 3 && hit[3].t == 5,
                "not at 1, 3, 3 and 5");
    row_require(v, hit[1].prim == 0 && hit[2].prim == 1, "not in document order");
    ray = world_ray(turned(axis, 0, -s, 0), turned(axis, 0, s, 0));
    row_require(v, world_intersections(&world, &ray, &pen_origin_none, INFINITY, hit, 5) == 0,
                "the common tangent meets something");
}

void rows_touching(struct pen_row_run *run)
{
    row_each(run, draw_touching, judge_touching);
}
