/* SPDX-License-Identifier: MIT */
/* Outlines with many corners, with notches, or with corners off their plane, and surfaces that fill
 * the rest. A ray meets exactly one of the two. */
#include <stdlib.h>

#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"

static struct world world;

/* H052: a star of ten tips, and the triangles in its notches that make it a convex whole. */
static const double tips[10][2] = {{16, 0},  {13, 9},   {5, 15},   {-5, 15}, {-13, 9},
                                   {-16, 0}, {-13, -9}, {-5, -15}, {5, -15}, {13, -9}};

static vec3 star_point(const vec3 *f, double x, double y)
{
    return pen_along(pen_along(f[0], f[1], x / 16), f[2], y / 16);
}

static void draw_star_ray(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 f[3] = {gen_dyadic3(r, 4), gen_dyadic3(r, 2), gen_dyadic3(r, 2)};
    if (pen_norm1(pen_cross(f[1], f[2])) < .25)
        return;
    row_fixed(c, 1 + random_below(r, 7)); /* how deep the notches are, of 8 */
    for (int i = 0; i < 3; i++)
        row_arg3(c, f[i]);
    uint32_t i = random_below(r, 10);
    double deep = (8 - c->arg[0]) / 8 * random_unit(r);
    double x = tips[i][0], y = tips[i][1], s = random_below(r, 2) ? (8 - c->arg[0]) / 16 : deep;
    double mx = (tips[i][0] + tips[(i + 1) % 10][0]) * s, my = (y + tips[(i + 1) % 10][1]) * s;
    double t = random_below(r, 3) ? random_below(r, 16) / 16. : random_unit(r);
    if (random_below(r, 3) == 0) /* the reflex vertex itself */
        t = 0;
    vec3 to = star_point(f, mx + t * (x - mx) * .9, my + t * (y - my) * .9);
    vec3 o = pen_add(to, random_below(r, 2) ? gen_dyadic3(r, 8) : random_vec(r, 30));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, to));
}

static void judge_star(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double deep = row_next(c, &at), part = (8 - deep) / 16;
    vec3 f[3], p[20], hull[10];
    for (int i = 0; i < 3; i++)
        f[i] = row_next3(c, &at);
    struct pen_ray ray;
    struct pen_hit first;
    if (!primitives_ray(c, at, &ray) || !(deep >= 1 && deep <= 7) ||
        !(pen_norm1(pen_cross(f[1], f[2])) > .1)) {
        row_skip(v);
        return;
    }
    world_clear(&world);
    for (int i = 0; i < 10; i++) {
        int k = (i + 1) % 10;
        hull[i] = p[2 * i] = star_point(f, tips[i][0], tips[i][1]);
        p[2 * i + 1] =
            star_point(f, (tips[i][0] + tips[k][0]) * part, (tips[i][1] + tips[k][1]) * part);
    }
    world_polygon(&world, p, 20);
    for (int i = 0; i < 10; i++)
        world_triangle(&world, p[2 * i], p[(2 * i + 2) % 20], p[2 * i + 1]);
    bool unsure, near;
    struct oracle_ray line = {ray.o, ray.d};
    bool inside = oracle_winding(hull, 10, line, 64, &unsure) != 0;
    bool in_star = oracle_winding(p, 20, line, 8, &near) != 0;
    struct truth t;
    if (unsure || !oracle_plane(hull, line, &t) || !(t.hi > 0)) {
        row_skip(v);
        return;
    }
    primitives_require(v, primitives_intersections(&world, ray.o, ray.d, &first), inside);
    if (inside && !near)
        row_require(v, (first.prim == 0) == in_star, "star or notch: wrong");
}

void rows_star(struct pen_row_run *run)
{
    row_each(run, draw_star_ray, judge_star);
}

/* H054: squares with a vertex off their plane by up to 1e-6 of their size, as the reader accepts
 * them: a sheet of such has no cracks. */
enum { BENT = 24 };

static vec3 bent_point(uint64_t scene, int i, int j)
{
    struct random r = {scene * 977 + (uint64_t)(64 * i + j), 0};
    return pen_vec3(i, j, (i + 2 * j) / 8. + 1e-7 * random_in(&r, -1, 1));
}

static void build_bent(double scene)
{
    static double built = -1;
    if (built == scene)
        return;
    built = scene;
    world_clear(&world);
    for (int i = 0; i < BENT; i++)
        for (int j = 0; j < BENT; j++) {
            uint64_t s = (uint64_t)scene;
            const vec3 v[4] = {bent_point(s, i, j), bent_point(s, i + 1, j),
                               bent_point(s, i + 1, j + 1), bent_point(s, i, j + 1)};
            world_polygon(&world, v, 4);
        }
}

static void draw_bent(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    uint64_t scene = d->index / 512;
    row_fixed(c, (double)scene);
    int i = 1 + (int)random_below(r, BENT - 2), j = 1 + (int)random_below(r, BENT - 2);
    vec3 a = bent_point(scene, i, j), b = bent_point(scene, i + 1, j);
    vec3 to = random_below(r, 2) ? a : pen_along(a, pen_sub(b, a), random_below(r, 9) / 8.);
    vec3 o = pen_add(to, pen_vec3(random_in(r, -3, 3), random_in(r, -3, 3), 20));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, gen_nudged(r, to)));
}

static void judge_bent(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray ray;
    struct pen_hit first;
    if (!primitives_ray(c, 1, &ray) || !(ray.d.z < 0 && ray.o.z > 15)) {
        row_skip(v);
        return;
    }
    for (int high = 0; high <= 10; high += 10) { /* the sheet lies between these heights */
        double t = (high - ray.o.z) / ray.d.z;
        double x = ray.o.x + t * ray.d.x, y = ray.o.y + t * ray.d.y;
        if (!(x > 0 && y > 0 && x < BENT && y < BENT)) {
            row_skip(v);
            return;
        }
    }
    build_bent(c->arg[0]);
    primitives_require(v, primitives_intersections(&world, ray.o, ray.d, &first), 1);
}

void rows_bent(struct pen_row_run *run)
{
    row_each(run, draw_bent, judge_bent);
}

/* H055: a circle of 10 000 corners, and the square around it with the circle cut out. */
enum { CIRCLE = 10000 };
static vec3 circle[CIRCLE], ring[CIRCLE + 7];
static struct pen_polygon disc, rest;

static void build_circle(void)
{
    if (disc.count)
        return;
    const vec3 corner[4] = {{2, 2, 0}, {-2, 2, 0}, {-2, -2, 0}, {2, -2, 0}};
    for (int i = 0; i < CIRCLE; i++) {
        double a = 6.283185307179586 * i / CIRCLE;
        circle[i] = pen_vec3(cos(a), sin(a), 0);
    }
    /* Round the square, in along a slit, round the circle the other way, and out again. */
    int n = 0;
    for (int i = 0; i < 4; i++)
        ring[n++] = corner[i];
    ring[n++] = corner[0];
    for (int i = 0; i <= CIRCLE; i++)
        ring[n++] = circle[(CIRCLE - i) % CIRCLE];
    if (!pen_polygon_make(&disc, circle, CIRCLE) || !pen_polygon_make(&rest, ring, (uint32_t)n))
        abort();
}

static void draw_circle(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    build_circle();
    uint32_t i = random_below(r, CIRCLE);
    vec3 a = circle[i], b = circle[(i + 1) % CIRCLE];
    vec3 to = pen_along(a, pen_sub(b, a), random_below(r, 3) / 2.);
    vec3 o = random_below(r, 2) ? pen_add(to, pen_vec3(0, 0, 4)) : pen_add(to, random_direction(r));
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, gen_nudged(r, to)));
}

static void judge_circle(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray ray;
    double t;
    build_circle();
    if (!primitives_ray(c, 0, &ray) || !(fabs(ray.d.z) > 1e-3 * pen_length(ray.d))) {
        row_skip(v);
        return;
    }
    double s = -ray.o.z / ray.d.z, x = ray.o.x + s * ray.d.x, y = ray.o.y + s * ray.d.y;
    if (!(fabs(x) < 1.9 && fabs(y) < 1.9))
        row_skip(v);
    else
        primitives_require(v, pen_polygon_root(&disc, &ray, &t) + pen_polygon_root(&rest, &ray, &t),
                           1);
}

void rows_circle(struct pen_row_run *run)
{
    row_each(run, draw_circle, judge_circle);
}

/* The share of random rays that meet the circle is its area: within 5 standard deviations. */
enum { DARTS = 2000 };

static void draw_darts(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, (double)(random_bits(&d->random) >> 11));
}

static void judge_darts(const struct row_case *c, struct row_verdict *v)
{
    struct random r = {(uint64_t)c->arg[0], 0};
    struct pen_ray ray;
    double t, hits = 0;
    build_circle();
    for (int i = 0; i < DARTS; i++) {
        vec3 to = pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 0);
        vec3 o = pen_add(to, pen_vec3(random_in(&r, -1, 1), random_in(&r, -1, 1), 2));
        if (pen_ray_make(&ray, o, pen_sub(to, o)))
            hits += pen_polygon_root(&disc, &ray, &t);
    }
    double a = 6.283185307179586 / CIRCLE, area = CIRCLE * sin(a) / 2, p = area / 4;
    double sigma = sqrt(DARTS * p * (1 - p));
    row_measure(v, "hits of random rays from the area [sigma]", fabs(hits - DARTS * p) / sigma, 5);
}

void rows_circle_area(struct pen_row_run *run)
{
    row_each(run, draw_darts, judge_darts);
}
