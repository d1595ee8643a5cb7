/* SPDX-License-Identifier: MIT */
/* Closed meshes: rays aimed at vertices, edges and points of edges that are exact in binary. From
 * inside, the mesh is met, and crossed an odd number of times. From outside, up to 2^45 sizes away,
 * it is crossed an even number of times. Only the mesh itself is needed to judge that. */
#include "property/gen.h"
#include "property/primitives.h"
#include "property/rows.h"
#include "support/isa.h"
#include "support/kit.h"

enum { SIDES = 24, INSIDE = 9, CROSSINGS = 256, RAYS = 2048 };

static struct kit kit;
static struct pen_scene *scene;
static struct primitives_tree tree;
static double built = -1; /* the number of the scene */
static float vertex[3 * (INSIDE + SIDES * (SIDES + 1))];
static uint32_t corner[6 * SIDES * SIDES];
static int material = -1;
static struct pen_mesh_desc desc;

static uint32_t add_vertex(vec3 v, vec3 stretch)
{
    float *to = vertex + 3 * (size_t)desc.vertex_count;
    to[0] = (float)(v.x * stretch.x);
    to[1] = (float)(v.y * stretch.y);
    to[2] = (float)(v.z * stretch.z);
    return desc.vertex_count++;
}

static void add_triangle(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *to = corner + 3 * (size_t)desc.triangle_count++;
    to[0] = a;
    to[1] = b;
    to[2] = c;
}

/* A bumpy ball, stretched. The first vertices belong to no triangle: they are its middle, and
 * points inside around it. */
static void make_ball(struct random *r, vec3 stretch)
{
    const uint32_t stacks = 4 + random_below(r, SIDES - 3), slices = 5 + random_below(r, SIDES - 4);
    uint32_t at[SIDES + 1][SIDES];
    desc = (struct pen_mesh_desc){
        .vertex = vertex, .corner = corner, .material = &material, .material_count = 1};
    for (int i = 0; i < INSIDE; i++)
        add_vertex(pen_scale(random_direction(r), i ? .1 : 0), stretch);
    for (uint32_t i = 0; i <= stacks; i++) {
        for (uint32_t k = 0; k < slices; k++) {
            const double theta = 3.14159265358979 * i / stacks, phi = 6.28318530717959 * k / slices;
            const vec3 d = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
            const bool pole = i == 0 || i == stacks;
            at[i][k] =
                pole && k > 0 ? at[i][0] : add_vertex(pen_scale(d, random_in(r, .6, 1)), stretch);
        }
    }
    for (uint32_t i = 0; i < stacks; i++) {
        for (uint32_t k = 0; k < slices; k++) {
            const uint32_t n = (k + 1) % slices;
            if (i < stacks - 1)
                add_triangle(at[i][k], at[i + 1][k], at[i + 1][n]);
            if (i > 0)
                add_triangle(at[i][k], at[i + 1][n], at[i][n]);
        }
    }
}

/* How far things are apart, in sizes of the mesh. Vertices are rounded to the scene's frame: that
 * must leave the thickness of the mesh, 2^-thin. */
static double apart(struct random *r, double least, uint32_t thin)
{
    return exp2(random_in(r, least, fmin(20, 36 - (double)thin)));
}

/* A transform that keeps floats, or one that rounds vertices once. */
static void move(struct random *r, bool keeps, uint32_t thin)
{
    const double scale = keeps ? exp2((int)random_below(r, 41) - 20) : gen_power(r, -6, 6),
                 way = scale * exp2(desc.exponent) * apart(r, -3, thin);
    const struct pen_transform transform = pen_transform_make(
        scale, random_direction(r), keeps ? 0 : random_in(r, -180, 180),
        random_below(r, 2) ? pen_vec3(0, 0, 0) : pen_scale(random_direction(r), way));
    kit_group(&kit, 0, &transform);
}

static void make_once(double number)
{
    if (built == number)
        return;
    struct random r = {(uint64_t)number * 0x9e3779b97f4a7c15u + 53, 0};
    const uint32_t how = random_below(&r, 4), thin = random_below(&r, how > 1 ? 13 : 40);
    vec3 stretch = {1, 1, 1};
    *(random_below(&r, 2) ? &stretch.x : &stretch.z) = exp2(-(double)thin);
    make_ball(&r, stretch);
    desc.exponent = (int)random_below(&r, 61) - 30;
    const double size = exp2(desc.exponent);
    const vec3 shift =
        random_below(&r, 4) ? random_vec(&r, size * apart(&r, -3, thin)) : pen_vec3(0, 0, 0);
    desc.shift[0] = shift.x;
    desc.shift[1] = shift.y;
    desc.shift[2] = shift.z;
    kit_init(&kit);
    struct pen_object_desc *o = kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    o->kind = PEN_OBJECT_MESH;
    o->u.mesh = &desc;
    if (thin < 32 && random_below(&r, 4) == 0) /* the mesh is small in its scene */
        kit_sphere(&kit, pen_along(shift, random_direction(&r), size * apart(&r, 2, thin)),
                   1e-3 * size, -1);
    if (how > 0)
        move(&r, how == 1, thin);
    kit.settings.accelerator = PEN_ACCEL_NONE;
    pen_scene_free(scene);
    scene = kit_freeze(&kit);
    primitives_build_kind(&tree, &scene->prims,
                          random_below(&r, 16) ? PEN_ACCEL_AUTO : PEN_ACCEL_MEDIAN);
    built = number;
}

static vec3 surface_point(struct random *r)
{
    const struct pen_mesh *mesh = &scene->prims.mesh[0];
    vec3 v[3];
    pen_mesh_corners(mesh, random_below(r, mesh->count), v);
    const uint32_t i = random_below(r, 3);
    return gen_on_edge(r, v[i], v[(i + 1) % 3]);
}

/* The radius of the mesh around its middle. */
static double reach(void)
{
    const struct pen_mesh *mesh = &scene->prims.mesh[0];
    const vec3 middle = pen_mesh_vertex(mesh, 0);
    double most = 0;
    for (uint32_t i = 0; i < desc.vertex_count; i++) {
        const double length = pen_length(pen_sub(pen_mesh_vertex(mesh, i), middle));
        most = length > most ? length : most;
    }
    return most;
}

static void draw_mesh(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    row_fixed(c, (double)(d->index / RAYS));
    make_once(c->arg[0]);
    const struct pen_mesh *mesh = &scene->prims.mesh[0];
    const int from = (int)random_below(r, 2 * INSIDE) - INSIDE;
    row_fixed(c, from);
    vec3 o = pen_mesh_vertex(mesh, from < 0 ? 0 : (uint32_t)from);
    if (from < 0) {
        o = pen_along(o, random_direction(r), reach() * exp2(random_in(r, .1, 45)));
        row_arg3(c, o);
    }
    row_arg3(c, gen_toward(r, o, surface_point(r)));
}

/* How often the ray crosses the mesh; the other primitive comes after it. */
static int crossings(const struct pen_ray *ray)
{
    const struct pen_trace_ops *ops = pen_trace_ops_get(pen_cpu_isa());
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    int count = 0;
    while (count < CROSSINGS &&
           ops->nearest(tree.accel, ray, &pen_origin_none, &interval, &interval.after))
        count += interval.after.prim < scene->prims.mesh[0].count;
    return count;
}

static void judge_mesh(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    make_once(row_next(c, &at));
    const struct pen_mesh *mesh = &scene->prims.mesh[0];
    const double from = row_next(c, &at);
    const bool inside = from >= 0;
    const vec3 o = inside ? pen_mesh_vertex(mesh, (uint32_t)from) : row_next3(c, &at),
               d = row_next3(c, &at);
    struct pen_ray ray;
    bool alike;
    if (!pen_ray_make(&ray, o, d) ||
        (!inside && !(pen_length(pen_sub(o, pen_mesh_vertex(mesh, 0))) > 1.01 * reach()))) {
        row_skip(v);
        return;
    }
    const struct pen_hit hit = primitives_nearest(&tree, &ray, &pen_origin_none, INFINITY, &alike);
    row_require(v, alike, "instruction sets differ");
    row_require(v, !inside || hit.prim < mesh->count, "leak");
    for (int isa = 0; isa < isa_count(); isa++) {
        struct pen_shadow query = {.tmax = INFINITY, .last_occluder = PEN_NO_PRIM};
        const bool blocked = pen_trace_ops_get((enum pen_isa)isa)
                                 ->shadow(tree.accel, &ray, &pen_origin_none, &query);
        row_require(v, blocked == (hit.prim != PEN_NO_PRIM), "a shadow ray leaks");
    }
    const int count = crossings(&ray);
    row_tally(v, inside ? "from inside" : count > 0 ? "from outside" : "past the mesh");
    if (count % 2 != inside)
        row_fail(v, "%d crossings: double hit, or a leak", count);
}

void rows_meshes(struct pen_row_run *run)
{
    row_each(run, draw_mesh, judge_mesh);
}
