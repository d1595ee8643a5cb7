/* SPDX-License-Identifier: MIT */
#include "property/primitives.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

#include "support/isa.h"

typedef struct pen_vec3 vec3;

/* Creases along x = 0, 2, 4 ...; between them flat, and exactly so: coefficients are dyadic. */
vec3 primitives_sheet_point(double x, double y, vec3 at)
{
    double fold = fabs(fmod(x, 4) - 2);
    return pen_add(at, pen_vec3(x + .125 * y, y, .75 * fold + .25 * y));
}

/* One square of the sheet, cut up in one of four ways. */
static void add_cell(struct world *w, struct random *r, double x, double y, vec3 at)
{
    vec3 p[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            p[i][j] = primitives_sheet_point(x + .5 * i, y + .5 * j, at);
    const vec3 ell[8] = {p[0][0], p[1][0], p[2][0], p[2][1], p[1][1], p[1][2], p[0][2], p[0][1]};
    const vec3 square[4] = {p[1][1], p[2][1], p[2][2], p[1][2]};
    const vec3 house[7] = {p[0][0], p[1][0], p[2][0], p[2][1], p[2][2], p[1][1], p[0][1]};
    const vec3 roof[4] = {p[1][1], p[2][2], p[1][2], p[0][2]};
    const vec3 whole[8] = {p[0][0], p[1][0], p[2][0], p[2][1], p[2][2], p[1][2], p[0][2], p[0][1]};
    switch (random_below(r, 4)) {
    case 0:
        world_polygon(w, ell, 8);
        world_polygon(w, square, 4);
        break;
    case 1:
        world_polygon(w, house, 7);
        world_polygon(w, roof, 4);
        world_triangle(w, p[1][1], p[0][2], p[0][1]);
        break;
    case 2:
        for (int i = 0; i < 8; i++)
            world_triangle(w, p[1][1], whole[i], whole[(i + 1) % 8]);
        break;
    default:
        world_polygon(w, whole, 8);
    }
}

void primitives_sheet(struct world *w, struct random *r, vec3 at)
{
    world_clear(w);
    for (int i = 0; i < 12; i++)
        for (int j = 0; j < 8; j++)
            add_cell(w, r, i, j, at);
}

int primitives_intersections(const struct world *w, vec3 o, vec3 d, struct pen_hit *first)
{
    struct pen_ray ray;
    struct pen_intersections c;
    int count = 0;
    *first = (struct pen_hit){INFINITY, PEN_NO_PRIM, 0};
    if (!pen_ray_make(&ray, o, d))
        return -1;
    for (uint32_t prim = 0; prim < w->prims.count; prim++) {
        pen_prim_intersect(&w->prims, prim, &ray, &pen_origin_none, &c);
        for (int i = 0; i < c.count; i++) {
            struct pen_hit h = {c.t[i], prim, c.part[i]};
            if (!(h.t > 0))
                continue;
            count++;
            if (pen_hit_before(h, *first))
                *first = h;
        }
    }
    return count;
}

void primitives_build_kind(struct primitives_tree *tree, const struct pen_prims *prims,
                           enum pen_accelerator kind)
{
    struct pen_status st;
    if (tree->arena)
        pen_arena_free(tree->arena);
    tree->arena = pen_arena_new(0);
    tree->accel = pen_accel_build(prims, kind, tree->arena, &st);
    ck_assert(tree->accel != NULL);
}

void primitives_build(struct primitives_tree *tree, const struct pen_prims *prims)
{
    primitives_build_kind(tree, prims, PEN_ACCEL_AUTO);
}

struct pen_hit primitives_nearest(const struct primitives_tree *tree, const struct pen_ray *ray,
                                  const struct pen_origin_surface *origin, double tmax, bool *alike)
{
    struct pen_t_interval interval = {pen_after_start, tmax};
    struct pen_hit first = {0};
    *alike = true;
    for (int isa = 0; isa < isa_count(); isa++) {
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)isa);
        struct pen_hit hit = {0, PEN_NO_PRIM, 0};
        if (!ops->nearest(tree->accel, ray, origin, &interval, &hit))
            hit = (struct pen_hit){0, PEN_NO_PRIM, 0};
        if (isa == 0)
            first = hit;
        *alike &= hit.prim == first.prim && hit.t == first.t && hit.part == first.part;
    }
    return first;
}

int primitives_walk(const struct primitives_tree *tree, const struct pen_ray *ray, int most)
{
    const struct pen_trace_ops *ops = pen_trace_ops_get(pen_cpu_isa());
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    int count = 0;
    while (count < most &&
           ops->nearest(tree->accel, ray, &pen_origin_none, &interval, &interval.after))
        count++;
    return count;
}

void primitives_mesh_begin(struct primitives_mesh *mesh, uint32_t capacity)
{
    mesh->triangle = calloc(capacity, sizeof *mesh->triangle);
    mesh->ref = calloc(capacity, sizeof *mesh->ref);
    ck_assert(mesh->triangle && mesh->ref);
    mesh->prims = (struct pen_prims){.ref = mesh->ref, .triangle = mesh->triangle};
}

void primitives_mesh_end(struct primitives_mesh *mesh)
{
    free(mesh->triangle);
    free(mesh->ref);
}

void primitives_mesh_add(struct primitives_mesh *mesh, vec3 a, vec3 b, vec3 c)
{
    uint32_t i = mesh->prims.count;
    if (!pen_triangle_make(&mesh->triangle[i], a, b, c))
        return;
    mesh->ref[i].kind = PEN_PRIM_TRIANGLE;
    mesh->ref[i].index = i & 0x0fffffffu;
    mesh->prims.count = mesh->prims.kind_count[PEN_PRIM_TRIANGLE] = i + 1;
}

void primitives_mesh_grid(struct primitives_mesh *mesh, int n, primitives_grid_fn *at,
                          const void *user)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            vec3 v[4] = {at(i, j, user), at(i + 1, j, user), at(i + 1, j + 1, user),
                         at(i, j + 1, user)};
            int s = (i ^ j) & 1;
            primitives_mesh_add(mesh, v[s], v[s + 1], v[s + 2]);
            primitives_mesh_add(mesh, v[s], v[s + 2], v[(s + 3) % 4]);
        }
    }
}

bool primitives_ray(const struct row_case *c, int at, struct pen_ray *ray)
{
    vec3 o = row_next3(c, &at);
    return pen_ray_make(ray, o, row_next3(c, &at));
}

void primitives_require(struct row_verdict *v, int count, int wanted)
{
    if (count != wanted)
        row_fail(v, "%d intersections, not %d: %s", count, wanted,
                 count < wanted ? "leak" : "double hit");
}
