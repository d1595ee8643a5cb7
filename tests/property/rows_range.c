/* SPDX-License-Identifier: MIT */
/* The ends of the range: far cameras, planets, small things on huge ones. */
#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"

static struct world world;

/* H082: a sphere of size 1 seen from 1e4, 1e6 and 1e8: hit or miss is wrong only where
 * |b / r - 1| <= 4u D / r. Arguments: o, d; the sphere is at the origin. */
static void draw_far(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    static const double away[] = {1e4, 1e6, 1e8};
    vec3 o, direction;
    double far = random_below(r, 2) ? away[random_below(r, 3)] : gen_power(r, 1, 8);
    double off = far * 0x1p-53 * random_in(r, -64, 64);
    gen_grazing(r, pen_vec3(0, 0, 0), 1, far, random_below(r, 2) ? 1 + off : gen_passing(r), &o,
                &direction);
    row_arg3(c, o);
    row_arg3(c, direction);
}

static void judge_far(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    vec3 o = row_next3(c, &at);
    struct oracle_round b = {.r = 1};
    struct oracle_roots truth;
    struct pen_sphere s;
    struct pen_ray ray;
    double t[2];
    if (!pen_ray_make(&ray, o, row_next3(c, &at)) || !pen_sphere_make(&s, pen_vec3(0, 0, 0), 1)) {
        row_skip(v);
        return;
    }
    struct oracle_ray line = {ray.o, ray.d};
    oracle_sphere(&b, line, &truth);
    bool hit = pen_sphere_roots(&s, &ray, t), exact = truth.count == 2;
    double off = fabs(oracle_passing(&b, line) - 1), d = oracle_distance(&b, line);
    row_tally(v, hit == exact ? "decided as exact arithmetic does" : "decided the other way");
    if (hit != exact) {
        row_measure(v, "|b/r-1| where wrong [u D/r]", off / (0x1p-53 * d), -1);
        row_require(v, off <= 4 * 0x1p-53 * d, "wrong beyond 4u D/r");
    }
}

void rows_far_camera(struct pen_row_run *run)
{
    row_each(run, draw_far, judge_far);
}

/* H083: the horizon of a planet from height h: the angle at which rays begin to meet it is within
 * an ulp of d. Arguments: r, h, the ray's down component over its level one. */
static void draw_planet(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    double radius = random_below(r, 2) ? 6.4e6 : gen_power(r, 0, 9);
    double high = random_below(r, 2) ? 2 : radius * gen_power(r, -9, 0);
    /* Level over distance to the centre is the sine of the tangent's angle. */
    double slope = sqrt(high * (2 * radius + high)) / radius;
    row_arg(c, radius);
    row_arg(c, high);
    row_arg(c, slope + 0x1p-52 * random_in(r, -8, 8));
}

static bool meets_planet(double r, double high, double slope)
{
    struct oracle_round b = {.c = pen_vec3(0, -r, 0), .r = r};
    struct oracle_roots roots;
    oracle_sphere(&b, (struct oracle_ray){{0, high, 0}, {1, -slope, 0}}, &roots);
    return roots.count == 2;
}

static void judge_planet(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double r = fabs(row_next(c, &at)), high = fabs(row_next(c, &at)), slope = row_next(c, &at);
    struct pen_sphere s;
    struct pen_ray ray;
    double t[2];
    if (!(r > 1e-3 && r < 1e12) || !(high > 1e-9 * r && high < 4 * r) ||
        !pen_ray_make(&ray, pen_vec3(0, high, 0), pen_vec3(1, -slope, 0)) ||
        !pen_sphere_make(&s, pen_vec3(0, -r, 0), r)) {
        row_skip(v);
        return;
    }
    bool hit = pen_sphere_roots(&s, &ray, t);
    bool less = meets_planet(r, high, slope - 0x1p-52);
    bool more = meets_planet(r, high, slope + 0x1p-52);
    row_tally(v, hit == meets_planet(r, high, slope) ? "decided as exact arithmetic does"
                                                     : "decided the other way");
    if (less == more && hit != less)
        row_fail(v, hit ? "met above the horizon" : "missed below the horizon");
}

void rows_planet(struct pen_row_run *run)
{
    row_each(run, draw_planet, judge_planet);
}

/* H081: a sphere of 1e-6 that rests on one of 1e9, seen from 1e-5 away in a frame at the contact:
 * what is met, and whether the small one shades the large. Arguments: o, d. */
static const struct oracle_round big = {.c = {0, -1e9, 0}, .r = 1e9};
static const struct oracle_round small = {.c = {0, 1e-6, 0}, .r = 1e-6};

static void draw_mixed(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 o = pen_add(pen_vec3(0, 1e-5, 0), random_vec(r, 8e-6));
    vec3 to = random_vec(r, 3e-6);
    to.y = random_below(r, 2) ? 0 : fabs(to.y);
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, to));
}

static void judge_mixed(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    vec3 o = row_next3(c, &at), d = row_next3(c, &at);
    struct pen_hit first;
    if (!(o.y > 1.5e-6 && pen_norm1(o) < 1e-4)) {
        row_skip(v);
        return;
    }
    world_clear(&world);
    world_sphere(&world, big.c, big.r);
    world_sphere(&world, small.c, small.r);
    int count = primitives_intersections(&world, o, d, &first);
    int see = oracle_sphere_class(&small, (struct oracle_ray){o, d}, 16);
    int ground = oracle_sphere_class(&big, (struct oracle_ray){o, d}, 16);
    struct oracle_roots roots;
    oracle_sphere(&small, (struct oracle_ray){o, d}, &roots);
    if (count < 0 || see == 0 || (see > 0 && !(roots.t[0].hi > 0))) {
        row_skip(v);
        return;
    }
    if (see > 0) {
        row_tally(v, "the small sphere is seen");
        row_require(v, first.prim == 1, "the small sphere is not seen");
        return;
    }
    row_require(v, first.prim != 1, "the small sphere is seen where it is not");
    if (first.prim != 0 || ground <= 0)
        return;
    /* From the ground, straight up to a light above: shaded iff under the small sphere. */
    struct pen_ray ray;
    if (!pen_ray_make(&ray, o, d))
        return;
    vec3 p = pen_prim_point(&world.prims, first, &ray), light = {0, 1e-4, 0};
    struct pen_origin_surface on = world_origin_surface(&world, first, p, d, false);
    vec3 up = pen_sub(light, p);
    if (!pen_ray_make(&ray, p, up))
        return;
    int dark = oracle_sphere_class(&small, (struct oracle_ray){p, up}, 16);
    bool shaded = world_intersections(&world, &ray, &on, 1, NULL, 0) > 0;
    if (dark != 0)
        row_require(v, shaded == (dark > 0), shaded ? "shaded in the light" : "lit in the shadow");
    row_tally(v, dark > 0 ? "in its shadow" : "beside its shadow");
}

void rows_mixed(struct pen_row_run *run)
{
    row_each(run, draw_mixed, judge_mixed);
}
