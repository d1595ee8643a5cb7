/* SPDX-License-Identifier: MIT */
/* More surfaces that close or tile: the meshes, disk packets, stars and circles of the catalogue.
 * The property is a count. */
#include <stdlib.h>

#include "property/gen.h"
#include "property/oracle.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "support/isa.h"

static struct world world;
static struct primitives_tree tree;
static struct primitives_mesh mesh;

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
    primitives_mesh_begin(&mesh, 4 * EMBREE * EMBREE);
    primitives_mesh_grid(&mesh, EMBREE, on_embree_sphere, NULL);
    primitives_mesh_grid(&mesh, EMBREE, on_embree_square, NULL);
    primitives_build(&tree, &mesh.prims);
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
    if (!primitives_ray(c, 1, &ray)) {
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
        int count = primitives_walk(&tree, &ray, 8); /* the sphere, and perhaps the square */
        struct pen_hit hit;
        bool alike;
        hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
        row_require(v, alike, "instruction sets differ");
        row_require(v, count >= 1 && hit.prim < 2u * EMBREE * EMBREE, "leak");
        row_require(v, count <= 2, "double hit");
        return;
    }
    double t = (-8 - f.z) / ray.d.z, x = f.x + t * ray.d.x, y = f.y + t * ray.d.y;
    if (!(f.z < -2.5 && f.z > -7 && ray.d.z < 0 && fabs(x) < 5.9 && fabs(y) < 5.9))
        row_skip(v);
    else
        primitives_require(v, primitives_walk(&tree, &ray, 8), 1);
}

void rows_embree(struct pen_row_run *run)
{
    row_each(run, draw_embree, judge_embree);
}

/* H044: 1000 triangles of apex angle 1e-7 that meet in a vertex, and three that close the
 * circle. */
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
    primitives_build(&tree, &world.prims);
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
    if (!primitives_ray(c, 0, &ray)) {
        row_skip(v);
        return;
    }
    vec3 f = pen_sub(ray.o, apex);
    double t = -f.z / ray.d.z, x = f.x + t * ray.d.x, y = f.y + t * ray.d.y;
    if (!(f.z > 1 && ray.d.z < 0 && x > -1e-9 && x < .95 && fabs(y) < 4e-5))
        row_skip(v);
    else
        primitives_require(v, primitives_intersections(&world, ray.o, ray.d, &first), 1);
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
    static const vec3 direction[] = {
        {0, 0, 1},  {.5, .25, 1},   {1, -1, 1}, {-.25, .125, -.5}, {1, 2, .5},
        {0, 0, -1}, {.75, .375, 1}, {-1, 1, 2}, {.1, .2, 1},       {-1. / 3, .7, 1}};
    vec3 to = pen_vec3(1 + random_below(r, 4 * (TILES - 2)) / 4.,
                       1 + random_below(r, 4 * (TILES - 2)) / 4., 0);
    vec3 u = direction[random_below(r, 10)];
    vec3 o = pen_along(to, u, -4);
    row_arg3(c, o);
    row_arg3(c, random_below(r, 2) ? u : gen_toward(r, o, to));
}

static void judge_tiling(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray ray;
    if (mesh.prims.count == 0) {
        primitives_mesh_begin(&mesh, 2 * TILES * TILES);
        primitives_mesh_grid(&mesh, TILES, on_tiling, NULL);
        primitives_build(&tree, &mesh.prims);
    }
    if (!primitives_ray(c, 0, &ray)) {
        row_skip(v);
        return;
    }
    double t = -ray.o.z / ray.d.z, x = ray.o.x + t * ray.d.x, y = ray.o.y + t * ray.d.y;
    if (!(t > 0 && x > .5 && y > .5 && x < TILES - .5 && y < TILES - .5))
        row_skip(v);
    else
        primitives_require(v, primitives_walk(&tree, &ray, 8), 1);
}

void rows_tiling(struct pen_row_run *run)
{
    row_each(run, draw_tiling, judge_tiling);
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
    if (!primitives_ray(c, at, &ray)) {
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
        /* Inside, and not by less than rounding of the corners seen from there. */
        const vec3 corner[3] = {a, b, e};
        if (oracle_flat_residual(corner, (struct oracle_ray){ray.o, ray.d}, 0) > 16)
            inside += oracle_above(a, b, e, ray.o);
    }
    if (abs(inside) != 4) {
        row_skip(v);
        return;
    }
    primitives_require(v, count, 2); /* the line, both ways */
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
    if (!primitives_ray(c, at, &ray) || !(hi.x > lo.x && hi.y > lo.y && hi.z > lo.z) ||
        size > 1e50) {
        row_skip(v);
        return;
    }
    vec3 f = pen_sub(ray.o, pen_along(lo, pen_vec3(1, 1, 1), .5 * size));
    if (!(pen_length(f) > size)) { /* outside only */
        row_skip(v);
        return;
    }
    make_cube(lo, hi);
    primitives_build(&tree, &world.prims);
    for (int isa = 0; isa < isa_count(); isa++) {
        struct pen_shadow query = {
            .tmax = INFINITY, .see_through = clear, .last_occluder = PEN_NO_PRIM};
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)isa);
        row_require(v, !ops->shadow(tree.accel, &ray, &pen_origin_none, &query), "blocked");
        if (query.count != 0 && query.count != 2)
            row_fail(v, "%d surfaces, not 0 or 2", query.count);
        row_tally(v, query.count ? "through the cube" : "past the cube");
    }
}

void rows_glass_cube(struct pen_row_run *run)
{
    row_each(run, draw_cube, judge_cube);
}
