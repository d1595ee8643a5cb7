/* SPDX-License-Identifier: MIT */
/* More surfaces that close or tile: the meshes, fans, stars and circles of the catalogue. What must
 * hold is a count. */
#include <stdlib.h>

#include "property/bodies.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"

static struct world world;
static struct bodies_tree tree;
static struct bodies_mesh mesh;

/* The ray of a case from argument `at` on; false for none. */
static bool ray_of(const struct row_case *c, int at, struct pen_ray *ray)
{
    vec3 o = row_next3(c, &at);
    return pen_ray_make(ray, o, row_next3(c, &at));
}

static void require_count(struct row_verdict *v, int count, int wanted)
{
    if (count != wanted)
        row_fail(v, "%d crossings, not %d: %s", count, wanted,
                 count < wanted ? "leak" : "double hit");
}

/* H040: Embree's own set-up: a sphere of radius 2 and a square of side 12, each of 200 x 200
 * squares, at (148376, 1234, -223423). */
enum { EMBREE = 200 };
static const vec3 embree_at = {148376, 1234, -223423};

static vec3 on_embree_sphere(double i, double j, const void *user)
{
    (void)user;
    double theta = 3.14159265358979 * i / EMBREE, phi = 6.28318530717959 * fmod(j, EMBREE) / EMBREE;
    double ring = i == 0 || i == EMBREE ? 0 : 2 * sin(theta);
    return pen_add(embree_at, pen_vec3(ring * cos(phi), ring * sin(phi), 2 * cos(theta)));
}

static vec3 on_embree_square(double i, double j, const void *user)
{
    (void)user;
    return pen_add(embree_at, pen_vec3(12 * i / EMBREE - 6, 12 * j / EMBREE - 6, -8));
}

static void build_embree(void)
{
    if (mesh.prims.count)
        return;
    bodies_mesh_begin(&mesh, 4 * EMBREE * EMBREE);
    bodies_mesh_grid(&mesh, EMBREE, on_embree_sphere, NULL);
    bodies_mesh_grid(&mesh, EMBREE, on_embree_square, NULL);
    bodies_plant(&tree, &mesh.prims);
}

/* At random, as Embree does, and at the corners and edges of its grids. */
static void draw_embree(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    bool sphere = random_below(r, 2);
    double i = random_below(r, EMBREE), j = random_below(r, EMBREE);
    uint32_t what = random_below(r, 4);
    double s = what == 0 ? random_unit(r) : 0, t = what < 2 ? random_unit(r) : 0;
    vec3 o = pen_add(embree_at, random_vec(r, 1));
    vec3 to = sphere ? on_embree_sphere(i, j, NULL) : on_embree_square(i, j, NULL);
    vec3 next = sphere ? on_embree_sphere(i + 1, j, NULL) : on_embree_square(i + 1, j, NULL);
    vec3 side = sphere ? on_embree_sphere(i, j + 1, NULL) : on_embree_square(i, j + 1, NULL);
    if (!sphere && (i == 0 || j == 0))
        return; /* the border of the square belongs to one side only */
    row_fixed(c, sphere);
    if (!sphere)
        o = pen_sub(o, pen_vec3(0, 0, 4)); /* between the two */
    row_arg3(c, o);
    to = pen_along(pen_along(to, pen_sub(next, to), s), pen_sub(side, to), t);
    row_arg3(c, what == 0
                    ? gen_toward(
                          r, o, random_below(r, 2) && sphere ? pen_add(o, random_direction(r)) : to)
                    : gen_toward(r, o, to));
}

static void judge_embree(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray ray;
    if (!ray_of(c, 1, &ray)) {
        row_skip(v);
        return;
    }
    build_embree();
    vec3 f = pen_sub(ray.o, embree_at);
    if (c->arg[0] != 0) {
        if (pen_length(f) > 1.9) {
            row_skip(v);
            return;
        }
        int count = bodies_walk(&tree, &ray, 8); /* the sphere, and perhaps the square */
        struct pen_hit hit;
        bool alike;
        hit = bodies_nearest(&tree, &ray, &pen_leave_nothing, INFINITY, &alike);
        row_require(v, alike, "base and avx2 differ");
        row_require(v, count >= 1 && hit.prim < 2u * EMBREE * EMBREE, "leak");
        row_require(v, count <= 2, "double hit");
        return;
    }
    double t = (-8 - f.z) / ray.d.z, x = f.x + t * ray.d.x, y = f.y + t * ray.d.y;
    if (!(f.z < -2.5 && f.z > -7 && ray.d.z < 0 && fabs(x) < 5.9 && fabs(y) < 5.9))
        row_skip(v);
    else
        require_count(v, bodies_walk(&tree, &ray, 8), 1);
}

void rows_embree(struct pen_row_run *run)
{
    row_each(run, draw_embree, judge_embree);
}

/* H044: 1000 triangles of apex angle 1e-7 that meet in a vertex, and three that close the circle.
 */
enum { FAN = 1000 };
static vec3 apex, rim[FAN + 1];

static void build_fan(void)
{
    if (world.prims.count)
        return;
    apex = pen_vec3(.1, .2, .3);
    for (int i = 0; i <= FAN; i++) {
        double s = (i - FAN / 2) * .5e-7; /* half of the angle's tangent */
        rim[i] = pen_add(apex, pen_vec3((1 - s * s) / (1 + s * s), 2 * s / (1 + s * s), .01 * s));
    }
    world_clear(&world);
    for (int i = 0; i < FAN; i++)
        world_triangle(&world, apex, rim[i], rim[i + 1]);
    vec3 left = pen_add(apex, pen_vec3(-1, 3, 0)), right = pen_add(apex, pen_vec3(-1, -3, 0));
    world_triangle(&world, apex, rim[FAN], left);
    world_triangle(&world, apex, left, right);
    world_triangle(&world, apex, right, rim[0]);
    bodies_plant(&tree, &world.prims);
}

static void draw_fan(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    build_fan();
    vec3 o = pen_add(apex, pen_vec3(random_in(r, -1, 1), random_in(r, -1, 1), 2));
    vec3 to = apex, end = rim[random_below(r, FAN + 1)];
    if (random_below(r, 2))
        to = pen_along(apex, pen_sub(end, apex), random_below(r, 15) / 16.);
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, to));
}

static void judge_fan(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray ray;
    struct pen_hit first;
    build_fan();
    if (!ray_of(c, 0, &ray)) {
        row_skip(v);
        return;
    }
    vec3 f = pen_sub(ray.o, apex);
    double t = -f.z / ray.d.z, x = f.x + t * ray.d.x, y = f.y + t * ray.d.y;
    if (!(f.z > 1 && ray.d.z < 0 && x > -1e-9 && x < .95 && fabs(y) < 4e-5))
        row_skip(v);
    else
        require_count(v, bodies_crossings(&world, ray.o, ray.d, &first), 1);
}

void rows_fan(struct pen_row_run *run)
{
    row_each(run, draw_fan, judge_fan);
}

/* H049: 64 x 64 squares split along either diagonal: each lattice point belongs to one triangle. */
enum { TILES = 64 };

static vec3 on_tiling(double i, double j, const void *user)
{
    (void)user;
    return pen_vec3(i, j, 0);
}

static void draw_tiling(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    static const vec3 way[] = {{0, 0, 1},   {.5, .25, 1},    {1, -1, 1},     {-.25, .125, -.5},
                               {1, 2, .5},  {0, 0, -1},      {.75, .375, 1}, {-1, 1, 2},
                               {.1, .2, 1}, {-1. / 3, .7, 1}};
    vec3 to = pen_vec3(1 + random_below(r, 4 * (TILES - 2)) / 4.,
                       1 + random_below(r, 4 * (TILES - 2)) / 4., 0);
    vec3 u = way[random_below(r, 10)];
    vec3 o = pen_along(to, u, -4);
    row_arg3(c, o);
    row_arg3(c, random_below(r, 2) ? u : gen_toward(r, o, to));
}

static void judge_tiling(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray ray;
    if (mesh.prims.count == 0) {
        bodies_mesh_begin(&mesh, 2 * TILES * TILES);
        bodies_mesh_grid(&mesh, TILES, on_tiling, NULL);
        bodies_plant(&tree, &mesh.prims);
    }
    if (!ray_of(c, 0, &ray)) {
        row_skip(v);
        return;
    }
    double t = -ray.o.z / ray.d.z, x = ray.o.x + t * ray.d.x, y = ray.o.y + t * ray.d.y;
    if (!(t > 0 && x > .5 && y > .5 && x < TILES - .5 && y < TILES - .5))
        row_skip(v);
    else
        require_count(v, bodies_walk(&tree, &ray, 8), 1);
}

void rows_tiling(struct pen_row_run *run)
{
    row_each(run, draw_tiling, judge_tiling);
}

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
    if (!ray_of(c, at, &ray) || !(deep >= 1 && deep <= 7) ||
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
    require_count(v, bodies_crossings(&world, ray.o, ray.d, &first), inside);
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
    if (!ray_of(c, 1, &ray) || !(ray.d.z < 0 && ray.o.z > 15)) {
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
    require_count(v, bodies_crossings(&world, ray.o, ray.d, &first), 1);
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
    if (!ray_of(c, 0, &ray) || !(fabs(ray.d.z) > 1e-3 * pen_length(ray.d))) {
        row_skip(v);
        return;
    }
    double s = -ray.o.z / ray.d.z, x = ray.o.x + s * ray.d.x, y = ray.o.y + s * ray.d.y;
    if (!(fabs(x) < 1.9 && fabs(y) < 1.9))
        row_skip(v);
    else
        require_count(v, pen_polygon_root(&disc, &ray, &t) + pen_polygon_root(&rest, &ray, &t), 1);
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

/* H056: a triangle of edge 1e6 that shares an edge with one of 1e-6: a tetrahedron. */
static void draw_huge(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    double small = gen_power(r, -7, -5), big = gen_power(r, 5, 7);
    vec3 p[4] = {random_vec(r, 1)};
    for (int i = 1; i < 3; i++)
        p[i] = pen_add(p[0], random_vec(r, small));
    p[3] = pen_add(p[0], pen_scale(random_direction(r), big));
    vec3 middle = pen_scale(pen_add(pen_add(p[0], p[1]), p[2]), 1. / 3);
    vec3 o = pen_along(middle, pen_sub(p[3], middle), gen_power(r, -9, -1));
    vec3 a = p[random_below(r, 4)], b = p[random_below(r, 4)];
    vec3 to = pen_along(a, pen_sub(b, a), random_below(r, 2) ? 0 : random_below(r, 17) / 16.);
    for (int i = 0; i < 4; i++)
        row_arg3(c, p[i]);
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, to));
}

static void judge_huge(const struct row_case *c, struct row_verdict *v)
{
    static const int face[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    int at = 0, inside = 0;
    vec3 p[4];
    struct pen_ray ray;
    struct pen_triangle t;
    for (int i = 0; i < 4; i++)
        p[i] = row_next3(c, &at);
    if (!ray_of(c, at, &ray)) {
        row_skip(v);
        return;
    }
    int count = 0;
    for (int i = 0; i < 4; i++) {
        vec3 a = p[face[i][0]], b = p[face[i][1]], e = p[face[i][2]];
        double depth;
        if (!pen_triangle_make(&t, a, b, e)) {
            row_skip(v);
            return;
        }
        count += pen_triangle_root(&t, &ray, &depth);
        inside += oracle_above(a, b, e, ray.o);
    }
    if (abs(inside) != 4) {
        row_skip(v);
        return;
    }
    require_count(v, count, 2); /* the line, both ways */
}

void rows_huge_small(struct pen_row_run *run)
{
    row_each(run, draw_huge, judge_huge);
}

/* H058: a closed glass cube of 12 triangles: a shadow ray through it, aimed at edges and corners,
 * meets two faces or none. */
static void draw_cube(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 lo = random_below(r, 2) ? gen_dyadic3(r, 2) : gen_offset3(gen_offset(r));
    double size = random_below(r, 2) ? 1 : gen_power(r, -3, 3), x[3];
    uint32_t edge = random_below(r, 3);
    for (uint32_t i = 0; i < 3; i++)
        x[i] = i == edge ? random_below(r, 9) / 8. : random_below(r, 2);
    vec3 to = pen_along(lo, pen_vec3(x[0], x[1], x[2]), size);
    vec3 o = pen_along(to, random_below(r, 2) ? random_direction(r) : gen_axial(r), 3 * size);
    row_arg3(c, lo);
    row_arg(c, size);
    row_arg3(c, o);
    row_arg3(c, gen_toward(r, o, gen_nudged(r, to)));
}

static void make_cube(vec3 lo, vec3 hi)
{
    static const int face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    world_clear(&world);
    for (int f = 0; f < 6; f++) {
        vec3 v[4];
        for (int i = 0; i < 4; i++) {
            int k = face[f][i];
            v[i] = pen_vec3(k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z);
        }
        world_triangle(&world, v[0], v[1], v[2]);
        world_triangle(&world, v[0], v[2], v[3]);
    }
}

static void judge_cube(const struct row_case *c, struct row_verdict *v)
{
    static uint8_t clear[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    int at = 0;
    vec3 lo = row_next3(c, &at);
    double size = fabs(row_next(c, &at));
    vec3 hi = pen_add(lo, pen_vec3(size, size, size));
    struct pen_ray ray;
    if (!ray_of(c, at, &ray) || !(hi.x > lo.x && hi.y > lo.y && hi.z > lo.z) || size > 1e50) {
        row_skip(v);
        return;
    }
    vec3 f = pen_sub(ray.o, pen_along(lo, pen_vec3(1, 1, 1), .5 * size));
    if (!(pen_length(f) > size)) { /* outside only */
        row_skip(v);
        return;
    }
    make_cube(lo, hi);
    bodies_plant(&tree, &world.prims);
    for (int i = 0; i < 2; i++) {
        struct pen_shadow query = {
            .tmax = INFINITY, .see_through = clear, .last_occluder = PEN_NO_PRIM};
        const struct pen_trace_ops *ops = pen_trace_ops_get(i ? pen_cpu_isa() : PEN_ISA_BASE);
        row_require(v, !ops->shadow(tree.accel, &ray, &pen_leave_nothing, &query), "blocked");
        if (query.count != 0 && query.count != 2)
            row_fail(v, "%d surfaces, not 0 or 2", query.count);
        row_tally(v, query.count ? "through the cube" : "past the cube");
    }
}

void rows_glass_cube(struct pen_row_run *run)
{
    row_each(run, draw_cube, judge_cube);
}
