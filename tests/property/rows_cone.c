/* SPDX-License-Identifier: MIT */
/* Cones: t and hit or miss against 113 bits, rays that leave them, their boxes, and trees of them.
 */
#include <math.h>

#include "geom/prims.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "property/shape.h"
#include "support/isa.h"

static struct pen_vec3 cone_normal(const struct pen_cone *c, uint8_t part, struct pen_vec3 p)
{
    return pen_kinds[PEN_PRIM_CONE].fn->normal(c, part, p);
}

static struct pen_box cone_bounds(const struct pen_cone *c)
{
    return pen_kinds[PEN_PRIM_CONE].fn->bounds(c);
}

static struct world world;
static struct primitives_tree trees[PEN_ACCEL_COUNT];

/* A case: base, axis, both radii, height; then what a row adds. */
static void put_cone(struct row_case *c, const struct oracle_cone *b)
{
    row_arg3(c, b->q);
    row_arg3(c, b->a);
    row_arg(c, b->r[0]);
    row_arg(c, b->r[1]);
    row_arg(c, b->h);
}

static bool get_cone(const struct row_case *c, int *at, struct oracle_cone *b,
                     struct pen_cone *cone)
{
    b->q = row_next3(c, at);
    b->a = row_next3(c, at);
    b->r[0] = fabs(row_next(c, at));
    b->r[1] = fabs(row_next(c, at));
    b->h = fabs(row_next(c, at));
    return b->r[0] != b->r[1] && pen_norm1(b->a) > 0 &&
           pen_cone_make(cone, b->q, b->a, b->r[0], b->r[1], b->h, true);
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double size_of(const struct oracle_cone *b)
{
    return larger(b->r[0], b->r[1]) + b->h;
}

/* Pointed, truncated, nearly a cylinder, flat or needles, of any size, either way up. */
static struct oracle_cone draw_shape(struct random *r)
{
    double size = random_below(r, 2) ? random_in(r, .1, 1) : gen_power(r, -6, 6);
    double most = size * (random_below(r, 4) ? 1 : gen_power(r, -6, 0));
    double least = random_below(r, 2) ? 0 : most * random_in(r, .01, .99);
    double h = size * (random_below(r, 4) ? random_in(r, .2, 3) : gen_power(r, -6, 0));
    if (random_below(r, 8) == 0)
        least = most * (1 - gen_power(r, -12, -1));
    bool turn = least > 0 && random_below(r, 2);
    return (struct oracle_cone){.q = random_below(r, 2) ? random_vec(r, 1)
                                                        : gen_offset3(gen_offset(r)),
                                .a = random_below(r, 4) ? random_direction(r) : gen_axial(r),
                                .r = {turn ? least : most, turn ? most : least},
                                .h = h};
}

/* A point of the surface, often of a rim or near the top, where the apex may be. */
static vec3 surface_point(struct random *r, const struct oracle_cone *b)
{
    vec3 n = pen_normalize(b->a), x, y;
    uint32_t what = random_below(r, 6);
    double s = what == 0   ? random_below(r, 2)
               : what == 1 ? 1 - gen_power(r, -16, 0)
               : what == 2 ? random_below(r, 2)
                           : random_unit(r);
    double radius = b->r[0] + s * (b->r[1] - b->r[0]);
    gen_frame(r, n, &x, &y);
    if (what == 2)
        radius *= random_unit(r);
    vec3 side = pen_normalize(pen_along(pen_scale(x, random_in(r, -1, 1)), y, random_in(r, -1, 1)));
    return pen_along(pen_along(b->q, n, s * b->h), side, radius);
}

/* From outside or inside, aimed at the surface, along the axis or a line of the side, or nearly. */
static void draw_line(struct random *r, const struct oracle_cone *b, vec3 *o, vec3 *d)
{
    vec3 to = gen_nudged(r, surface_point(r, b)), n = pen_normalize(b->a), x, y;
    double far = random_below(r, 4) ? random_in(r, 0, 3) : gen_power(r, 0, 6);
    *o = pen_along(to, random_direction(r), far * size_of(b));
    *d = gen_toward(r, *o, to);
    if (random_below(r, 4) == 0) {
        double slope = random_below(r, 2) ? (b->r[1] - b->r[0]) / b->h : 0;
        gen_frame(r, n, &x, &y);
        *d = gen_near_parallel(r, pen_normalize(pen_along(n, x, slope)), 16);
        *o = pen_along(to, *d, -far * size_of(b));
    }
}

static void draw_cone(struct row_draw *draw, struct row_case *c)
{
    struct oracle_cone b = draw_shape(&draw->random);
    vec3 o, d;
    draw_line(&draw->random, &b, &o, &d);
    put_cone(c, &b);
    row_arg3(c, o);
    row_arg3(c, d);
}

/* By how much t misses the truth, in the units of the rows: ulps, or u(|f| + size)/4 along the
 * normal n there. */
static double cone_error(const struct oracle_cone *b, struct oracle_ray line, double t,
                         struct truth truth, vec3 n)
{
    double size = pen_length(pen_sub(line.o, b->q)) + size_of(b);
    double share = 4 * truth_error(t, truth) * fabs(pen_dot(n, line.d)) / (PEN_U * size);
    double ulps = truth_ulps(t, truth);
    return share < ulps ? share : ulps;
}

/* 16 ulp of t, or 4u (|f| + size) towards the part: a quarter of that counts as an ulp. The inside
 * begins where the last of the parts' insides begins, so an end that comes too early is an error of
 * the part where it truly is, and one that comes too late of the part that is said; where the
 * inside ends it is the other way round. */
static void judge_cone(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    struct oracle_cone b;
    struct pen_cone cone;
    struct pen_ray ray;
    struct pen_interval in;
    struct oracle_roots truth;
    bool made = get_cone(c, &at, &b, &cone);
    struct oracle_ray line = {.o = row_next3(c, &at)};
    line.d = row_next3(c, &at);
    if (!made || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool hit = pen_cone_interval(&cone, &ray, &in);
    int class = oracle_cone_class(&b, line, 8);
    oracle_cone(&b, line, &truth);
    if (class != 0 && hit != (class > 0))
        row_fail(v, hit ? "false hit" : "false miss");
    if (!hit || truth.count != 2)
        return;
    for (int i = 0; i < 2; i++) {
        double t = i ? in.hi : in.lo;
        uint8_t said = i ? in.hi_part : in.lo_part, part = (uint8_t)truth.part[i];
        bool nearer = i ? t < truth.t[i].hi : t > truth.t[i].hi;
        vec3 n = cone_normal(&cone, nearer ? said : part, pen_along(line.o, line.d, t));
        row_measure(v, "cone, t [ulp, or u(|f|+size)/4]", cone_error(&b, line, t, truth.t[i], n),
                    16);
    }
}

void rows_cone_roots(struct pen_row_run *run)
{
    row_each(run, draw_cone, judge_cone);
}

/* As above, after a mirror (bits), a cyclic permutation of the axes, and a power of two. */
static void draw_mapped(struct row_draw *draw, struct row_case *c)
{
    struct random *r = &draw->random;
    row_fixed(c, random_below(r, 8));
    row_fixed(c, random_below(r, 3));
    row_fixed(c, (double)random_below(r, 41) - 20);
    draw_cone(draw, c);
}

/* The images of a cone and of a ray; the ray's d keeps its length. */
static struct oracle_ray map_cone(const struct shape_map *m, struct oracle_cone *b,
                                  struct oracle_ray line)
{
    b->q = shape_map_point(m, b->q);
    b->a = shape_map_way(m, b->a);
    for (int i = 0; i < 2; i++)
        b->r[i] *= m->factor;
    b->h *= m->factor;
    return (struct oracle_ray){shape_map_point(m, line.o), shape_map_way(m, line.d)};
}

/* With the axes in their order t has the same bits. With others the sums of the precise method run
 * in another order: two values that judge_cone allows are up to twice its bound apart. */
static void judge_mapped(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, bits = (int)row_next(c, &at) & 7;
    struct shape_map m = shape_map_identity;
    m.turn = (int)row_next(c, &at) % 3;
    m.factor = ldexp(1, (int)row_next(c, &at));
    m.sign = pen_vec3(bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1);
    struct oracle_cone b;
    struct pen_cone cone, image;
    struct pen_ray ray, image_ray;
    struct pen_interval in, out;
    bool made = get_cone(c, &at, &b, &cone);
    struct oracle_ray line = {.o = row_next3(c, &at)};
    line.d = row_next3(c, &at);
    if (!made || !pen_ray_make(&ray, line.o, line.d) ||
        (m.turn != 0 && oracle_cone_class(&b, line, 8) == 0)) {
        row_skip(v);
        return;
    }
    bool hit = pen_cone_interval(&cone, &ray, &in);
    line = map_cone(&m, &b, line);
    if (!row_require(v,
                     pen_cone_make(&image, b.q, b.a, b.r[0], b.r[1], b.h, true) &&
                         pen_ray_make(&image_ray, line.o, line.d),
                     "the image is not made"))
        return;
    if (!row_require(v, pen_cone_interval(&image, &image_ray, &out) == hit, "hit or miss changed"))
        return;
    for (int i = 0; hit && i < 2; i++) {
        double t = (i ? in.hi : in.lo) * m.factor, u = i ? out.hi : out.lo;
        uint8_t part = i ? out.hi_part : out.lo_part;
        if (m.turn == 0)
            row_require(v, t == u, "t changed");
        else
            row_measure(v, "cone with axes permuted, t [ulp, or u(|f|+size)/4]",
                        cone_error(&b, line, u, (struct truth){t, 0},
                                   cone_normal(&image, part, pen_along(line.o, line.d, u))),
                        32);
    }
}

void rows_cone_mapped(struct pen_row_run *run)
{
    row_each(run, draw_mapped, judge_mapped);
}

/* As above, and the direction in which a ray goes on from the first hit. */
static void draw_left(struct row_draw *draw, struct row_case *c)
{
    draw_cone(draw, c);
    row_arg3(c, random_direction(&draw->random));
}

/* Whether a ray from p, a point of the part, surely goes into the cone (1), surely does not (0), or
 * rounding decides (-1): it goes along the surface, or p is near the apex, or p's own bound is not
 * small beside the cone. At the apex the cone of directions decides, elsewhere the normal. */
static int goes_into(const struct pen_cone *c, uint8_t part, vec3 p, vec3 d)
{
    vec3 axis = pen_normalize(c->hull.round.a);
    vec3 apex = pen_along(c->hull.round.q, axis, c->hull.h);
    double size = c->hull.round.r + c->hull.h, bound = 16 * PEN_U * (pen_norm1(p) + size);
    double away = c->top_radius == 0 ? pen_length(pen_sub(p, apex)) : size;
    double least = c->hull.round.r < c->hull.h ? c->hull.round.r : c->hull.h;
    double into = -pen_dot(cone_normal(c, part, p), d);
    return fabs(into) < 1e-4 || !(bound < 1e-6 * least && bound < 1e-6 * away) ? -1 : into > 0;
}

static void judge_left(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    struct oracle_cone b;
    struct pen_cone cone;
    struct pen_ray ray, next;
    struct pen_hit hit;
    bool made = get_cone(c, &at, &b, &cone);
    vec3 o = row_next3(c, &at);
    vec3 d = row_next3(c, &at);
    vec3 on = row_next3(c, &at);
    world_clear(&world);
    if (!made || !pen_ray_make(&ray, o, d)) {
        row_skip(v);
        return;
    }
    world_cone(&world, b.q, b.a, b.r, b.h, true);
    if (world_intersections(&world, &ray, &pen_origin_none, INFINITY, &hit, 1) == 0)
        return;
    vec3 p = pen_prim_point(&world.prims, hit, &ray);
    vec3 n = pen_prim_normal(&world.prims, hit, p);
    int into = pen_ray_make(&next, p, on) ? goes_into(&cone, hit.part, p, pen_normalize(on)) : -1;
    if (into < 0)
        return;
    bool through = (pen_dot(n, on) > 0) == (pen_dot(n, d) > 0);
    struct pen_origin_surface origin = world_origin_surface(&world, hit, p, d, through);
    int count = world_intersections(&world, &next, &origin, INFINITY, NULL, 0);
    row_tally(v, into ? "inward" : "outward");
    if (count != into)
        row_fail(v, "leaves the cone %s and meets it %d times", into ? "inward" : "outward", count);
}

void rows_cone_left(struct pen_row_run *run)
{
    row_each(run, draw_left, judge_left);
}

static void draw_box(struct row_draw *draw, struct row_case *c)
{
    struct oracle_cone b = draw_shape(&draw->random);
    put_cone(c, &b);
}

/* The box holds the cone, and is no larger than rounding makes it. */
static void judge_box(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    struct oracle_cone b;
    struct pen_cone cone;
    if (!get_cone(c, &at, &b, &cone)) {
        row_skip(v);
        return;
    }
    struct pen_box box = cone_bounds(&cone);
    double unit = PEN_U * (pen_norm1(b.q) + size_of(&b));
    for (int i = 0; i < 6; i++) {
        vec3 n = pen_vec3(i % 3 == 0, i % 3 == 1, i % 3 == 2);
        double end = i < 3 ? pen_component(box.hi, i) : -pen_component(box.lo, i - 3);
        double over = end - oracle_cone_reach(&b, i < 3 ? n : pen_neg(n));
        row_require(v, over >= 0, "the cone reaches out of its box");
        row_measure(v, "the box reaches beyond the cone [u(|q|+size)]", over / unit, 128);
    }
}

void rows_cone_boxes(struct pen_row_run *run)
{
    row_each(run, draw_box, judge_box);
}

enum { SCENE_CASES = 1024 };

/* Cones among other primitives; in every fourth scene some coincide with others. */
static void build_scene(double scene)
{
    static double built = -1;
    struct random r = {(uint64_t)scene * 0x9e3779b97f4a7c15u + 129, 0};
    if (built == scene && world.prims.count > 0)
        return;
    built = scene;
    world_clear(&world);
    world_random(&world, &r, random_below(&r, 20), random_in(&r, .02, 1));
    for (uint32_t i = 0, count = 1 + random_below(&r, 40); i < count; i++) {
        struct oracle_cone b = draw_shape(&r);
        double size = random_in(&r, .02, 1) / size_of(&b);
        for (int k = 0; k < 2; k++)
            b.r[k] *= size;
        b.q = random_vec(&r, 1);
        for (int copies = (uint64_t)scene % 4 == 0 && i < 5; copies >= 0; copies--)
            world_cone(&world, b.q, b.a, b.r, b.h * size, random_below(&r, 2));
    }
    for (int k = 0; k < PEN_ACCEL_COUNT; k++)
        primitives_build_kind(&trees[k], &world.prims, (enum pen_accelerator)k);
}

static void draw_path(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(d->index / SCENE_CASES));
    row_arg3(c, random_vec(r, random_below(r, 2) ? 2 : 1));
    for (int i = 0; i < 3; i++)
        row_arg3(c, random_below(r, 4) ? random_direction(r) : gen_axial(r));
}

static struct pen_hit require_same(struct row_verdict *v, const struct pen_ray *ray,
                                   const struct pen_origin_surface *origin)
{
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit truth = world_nearest(&world, ray, origin, &interval);
    for (int k = 0; k < PEN_ACCEL_COUNT; k++) {
        bool alike;
        struct pen_hit hit = primitives_nearest(&trees[k], ray, origin, INFINITY, &alike);
        bool same = hit.prim == truth.prim &&
                    (hit.prim == PEN_NO_PRIM || (hit.t == truth.t && hit.part == truth.part));
        struct pen_shadow query = {.tmax = INFINITY, .last_occluder = PEN_NO_PRIM};
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)(k % isa_count()));
        bool occluded = ops->shadow(trees[k].accel, ray, origin, &query);
        row_require(v, alike, "instruction sets differ");
        row_require(v, same, "a tree meets something else than trying all");
        row_require(v, occluded == (truth.prim != PEN_NO_PRIM), "shadow differs");
    }
    return truth;
}

/* A path of three rays, each from where the one before it ended. */
static void judge_path(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double scene = row_next(c, &at);
    vec3 o = row_next3(c, &at);
    struct pen_origin_surface origin = pen_origin_none;
    build_scene(scene);
    for (int i = 0; i < 3; i++) {
        vec3 d = row_next3(c, &at), next = pen_vec3(c->arg[at], c->arg[at + 1], c->arg[at + 2]);
        struct pen_ray ray;
        if (!pen_ray_make(&ray, o, d))
            return;
        struct pen_hit hit = require_same(v, &ray, &origin);
        if (hit.prim == PEN_NO_PRIM || v->failed || i == 2)
            return;
        if (world.ref[hit.prim].kind == PEN_PRIM_CONE)
            row_tally(v, "went on from a cone");
        o = pen_prim_point(&world.prims, hit, &ray);
        vec3 n = pen_prim_normal(&world.prims, hit, o);
        origin =
            world_origin_surface(&world, hit, o, d, (pen_dot(n, next) > 0) == (pen_dot(n, d) > 0));
    }
}

void rows_cone_trees(struct pen_row_run *run)
{
    row_each(run, draw_path, judge_path);
}
