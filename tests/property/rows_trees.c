/* SPDX-License-Identifier: MIT */
/* Trees over mixed, coincident, unbounded and very few primitives. */
#include <math.h>

#include "property/gen.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "scene/settings.h"
#include "support/isa.h"

static struct world world;
static struct primitives_tree tree, kinds[PEN_ACCEL_COUNT];

static bool same_hit(struct pen_hit a, struct pen_hit b)
{
    return a.prim == b.prim && (a.prim == PEN_NO_PRIM || (a.t == b.t && a.part == b.part));
}

/* By every builder. */
static void plant_all(void)
{
    for (int k = 0; k < PEN_ACCEL_COUNT; k++)
        primitives_build_kind(&kinds[k], &world.prims, (enum pen_accelerator)k);
}

static void build_mixed(double scene)
{
    static double built = -1;
    struct random r = {(uint64_t)scene * 0x9e3779b97f4a7c15u + 95, 0};
    if (built == scene)
        return;
    built = scene;
    world_clear(&world);
    world_random(&world, &r, random_below(&r, 80), random_in(&r, .02, 1));
    if ((uint64_t)scene % 4 == 0) /* things that coincide with others */
        for (uint32_t i = 0; i < 10 && world.prims.kind_count[PEN_PRIM_SPHERE] > 0; i++) {
            uint32_t k = random_below(&r, world.prims.kind_count[PEN_PRIM_SPHERE]);
            world_sphere(&world, world.sphere[k].c, world.sphere[k].r);
        }
    plant_all();
}

/* H095, H096: a path of three rays, each from where the one before it ended. Arguments: scene, o
 * and three directions. */
enum { SCENE_CASES = 1024 };

static void draw_path(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(d->index / SCENE_CASES));
    row_arg3(c, random_vec(r, random_below(r, 2) ? 2 : 1));
    for (int i = 0; i < 3; i++)
        row_arg3(c, random_below(r, 4) ? random_direction(r) : gen_axial(r));
}

static struct pen_hit require_same(struct row_verdict *v, const struct pen_ray *ray,
                                   const struct pen_origin_surface *origin, double tmax)
{
    struct pen_t_interval interval = {pen_after_start, tmax};
    struct pen_hit truth = world_nearest(&world, ray, origin, &interval);
    for (int k = 0; k < PEN_ACCEL_COUNT; k++) {
        bool alike;
        const char *name = pen_accelerator_name((enum pen_accelerator)k);
        struct pen_hit hit = primitives_nearest(&kinds[k], ray, origin, tmax, &alike);
        if (!alike)
            row_fail(v, "%s: instruction sets differ", name);
        if (!same_hit(hit, truth))
            row_fail(v, "%s meets %d, trying all meets %d", name, (int)hit.prim, (int)truth.prim);
        struct pen_shadow query = {.tmax = tmax, .last_occluder = PEN_NO_PRIM};
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)(k % isa_count()));
        if (ops->shadow(kinds[k].accel, ray, origin, &query) !=
            (truth.prim != PEN_NO_PRIM && truth.t < tmax))
            row_fail(v, "%s: shadow differs", name);
    }
    return truth;
}

static void judge_path(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double scene = row_next(c, &at);
    vec3 o = row_next3(c, &at);
    struct pen_origin_surface origin = pen_origin_none;
    build_mixed(scene);
    for (int i = 0; i < 3; i++) {
        vec3 d = row_next3(c, &at), next = pen_vec3(c->arg[at], c->arg[at + 1], c->arg[at + 2]);
        struct pen_ray ray;
        if (!pen_ray_make(&ray, o, d))
            return;
        struct pen_hit hit = require_same(v, &ray, &origin, INFINITY);
        if (hit.prim == PEN_NO_PRIM || v->failed || i == 2)
            return;
        require_same(v, &ray, &origin, hit.t);
        require_same(v, &ray, &origin, nextafter(hit.t, 0));
        o = pen_prim_point(&world.prims, hit, &ray);
        vec3 n = pen_prim_normal(&world.prims, hit, o);
        origin =
            world_origin_surface(&world, hit, o, d, (pen_dot(n, next) > 0) == (pen_dot(n, d) > 0));
        row_tally(v, "went on from a hit");
    }
}

void rows_paths(struct pen_row_run *run)
{
    row_each(run, draw_path, judge_path);
}

/* H097: copies of one triangle. Arguments: how many, the triangle. */
static void draw_copies(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, d->index == 0 ? 100000 : 1 + random_below(&d->random, 3000));
    for (int i = 0; i < 3; i++)
        row_arg3(c, random_vec(&d->random, 1));
}

static void judge_copies(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    uint32_t count = (uint32_t)row_next(c, &at);
    vec3 a = row_next3(c, &at), b = row_next3(c, &at), e = row_next3(c, &at);
    struct primitives_mesh mesh;
    struct pen_ray ray;
    bool alike;
    primitives_mesh_begin(&mesh, count);
    for (uint32_t i = 0; i < count; i++)
        primitives_mesh_add(&mesh, a, b, e);
    vec3 to = pen_scale(pen_add(pen_add(a, b), e), 1. / 3),
         n = pen_cross(pen_sub(b, a), pen_sub(e, a));
    if (mesh.prims.count != count || !pen_ray_make(&ray, pen_add(to, n), pen_neg(n))) {
        primitives_mesh_end(&mesh);
        row_skip(v);
        return;
    }
    primitives_build(&tree, &mesh.prims);
    row_require(v, pen_accel_get_stats(tree.accel)->depth < 64, "the tree is 64 deep or more");
    struct pen_hit hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    row_require(v, alike && hit.prim == 0, "not the first copy");
    int walked = primitives_walk(&tree, &ray, 40);
    row_require(v, walked == (count < 40 ? (int)count : 40), "not every copy is met");
    primitives_mesh_end(&mesh);
}

void rows_copies(struct pen_row_run *run)
{
    row_each(run, draw_copies, judge_copies);
}

/* H098: planes and infinite cylinders beside a tree of 1e5 triangles, against trying all. */
enum { CROWD = 100000 };

static void build_crowd(struct primitives_mesh *mesh)
{
    struct random r = {98, 0};
    if (mesh->prims.count)
        return;
    world_clear(&world);
    for (int i = 0; i < 3; i++) {
        world_plane(&world, pen_vec3(0, 0, -2 - i), random_direction(&r));
        world_infinite_cylinder(&world, random_vec(&r, 1), random_direction(&r), .02);
    }
    primitives_mesh_begin(mesh, CROWD + 6);
    for (uint32_t i = 0; i < CROWD; i++) {
        vec3 p = random_vec(&r, 1);
        primitives_mesh_add(mesh, p, pen_add(p, random_vec(&r, .05)),
                            pen_add(p, random_vec(&r, .05)));
    }
    for (uint32_t i = 0; i < 6; i++)
        mesh->ref[mesh->prims.count + i] = world.ref[i];
    mesh->prims.count += 6;
    mesh->prims.plane = world.plane;
    mesh->prims.infinite_cylinder = world.infinite_cylinder;
    mesh->prims.kind_count[PEN_PRIM_PLANE] = mesh->prims.kind_count[PEN_PRIM_INFINITE_CYLINDER] = 3;
    primitives_build(&tree, &mesh->prims);
}

static void draw_crowd(struct row_draw *d, struct row_case *c)
{
    row_arg3(c, random_vec(&d->random, 2));
    row_arg3(c, random_direction(&d->random));
}

static void judge_crowd(const struct row_case *c, struct row_verdict *v)
{
    static struct primitives_mesh mesh;
    int at = 0;
    vec3 o = row_next3(c, &at);
    struct pen_ray ray;
    struct pen_intersections x;
    struct pen_hit truth = {INFINITY, PEN_NO_PRIM, 0};
    bool alike;
    build_crowd(&mesh);
    if (!pen_ray_make(&ray, o, row_next3(c, &at))) {
        row_skip(v);
        return;
    }
    for (uint32_t prim = 0; prim < mesh.prims.count; prim++) {
        pen_prim_intersect(&mesh.prims, prim, &ray, &pen_origin_none, &x);
        for (int i = 0; i < x.count; i++) {
            struct pen_hit h = {x.t[i], prim, x.part[i]};
            if (h.t > 0 && pen_hit_before(h, truth))
                truth = h;
        }
    }
    struct pen_hit hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    row_require(v, alike && same_hit(hit, truth), "the tree and trying all differ");
    row_tally(v, truth.prim >= mesh.prims.count - 6 ? "met without bounds or nothing"
                                                    : "met a triangle");
}

void rows_crowd(struct pen_row_run *run)
{
    row_each(run, draw_crowd, judge_crowd);
}

/* H099: none, one or two primitives of any kind. Arguments: which kinds (bits), then a ray. */
static void draw_few(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, (double)(d->index % 64));
    row_arg3(c, random_vec(&d->random, 3));
    row_arg3(c, random_below(&d->random, 2) ? random_direction(&d->random) : gen_axial(&d->random));
}

static void judge_few(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    unsigned bits = (unsigned)row_next(c, &at);
    vec3 o = row_next3(c, &at);
    const vec3 square[4] = {{-1, -1, 2}, {1, -1, 2}, {1, 1, 2}, {-1, 1, 2}};
    struct pen_ray ray;
    world_clear(&world);
    if (bits & 1)
        world_sphere(&world, pen_vec3(0, 0, 0), 1);
    if (bits & 2)
        world_triangle(&world, square[0], square[1], square[2]);
    if (bits & 4)
        world_polygon(&world, square, 4);
    if (bits & 8)
        world_plane(&world, pen_vec3(0, 0, 3), pen_vec3(0, 0, 1));
    if (bits & 16)
        world_infinite_cylinder(&world, pen_vec3(1, 1, 0), pen_vec3(0, 1, 0), .5);
    if (bits & 32)
        world_cylinder(&world, pen_vec3(0, -1, 0), pen_vec3(0, 1, 0), .5, 1, bits & 1);
    if (!pen_ray_make(&ray, o, row_next3(c, &at))) {
        row_skip(v);
        return;
    }
    plant_all();
    struct pen_hit hit = require_same(v, &ray, &pen_origin_none, INFINITY);
    row_require(v, bits != 0 || hit.prim == PEN_NO_PRIM, "met something in an empty scene");
}

void rows_few(struct pen_row_run *run)
{
    row_each(run, draw_few, judge_few);
}
