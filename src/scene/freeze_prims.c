/* SPDX-License-Identifier: MIT */
/* The typed arrays of a frozen scene: one per kind, filled in document order, in local
 * coordinates, with what kernels ask about a primitive beside its shape: its material, and whether
 * light passes through it. */
#include "scene/internal/freeze.h"

/* The arrays while they are filled; the scene sees them as constant afterwards. */
struct filler {
    struct pen_prim_ref *ref;
    struct pen_sphere *sphere;
    struct pen_plane *plane;
    struct pen_triangle *triangle;
    struct pen_polygon *polygon;
    struct pen_infinite_cylinder *infinite_cylinder;
    struct pen_cylinder *cylinder;
    struct pen_vec3 *vertices; /* of polygons: the next free one */
    uint32_t *material;
    uint8_t *see_through;
    struct pen_prims prims; /* the counts so far */
};

static bool alloc_arrays(struct pen_freezer *f, struct filler *a)
{
    struct pen_arena *arena = f->scene->arena;
    const uint32_t *n = f->survey.kind_count;
    size_t total = f->survey.total;
    a->ref = pen_arena_alloc(arena, total, sizeof *a->ref);
    a->material = pen_arena_alloc(arena, total, sizeof *a->material);
    a->see_through = pen_arena_alloc(arena, total, sizeof *a->see_through);
    a->sphere = pen_arena_alloc(arena, n[PEN_PRIM_SPHERE], sizeof *a->sphere);
    a->plane = pen_arena_alloc(arena, n[PEN_PRIM_PLANE], sizeof *a->plane);
    a->triangle = pen_arena_alloc(arena, n[PEN_PRIM_TRIANGLE], sizeof *a->triangle);
    a->polygon = pen_arena_alloc(arena, n[PEN_PRIM_POLYGON], sizeof *a->polygon);
    a->infinite_cylinder =
        pen_arena_alloc(arena, n[PEN_PRIM_INFINITE_CYLINDER], sizeof *a->infinite_cylinder);
    a->cylinder = pen_arena_alloc(arena, n[PEN_PRIM_CYLINDER], sizeof *a->cylinder);
    a->vertices = pen_arena_alloc(arena, f->survey.polygon_vertices, sizeof *a->vertices);
    if (a->ref && a->material && a->see_through && a->sphere && a->plane && a->triangle &&
        a->polygon && a->infinite_cylinder && a->cylinder && a->vertices)
        return true;
    return pen_freeze_no_memory(f);
}

/* What is lost is far below what the frame's own extent resolves. */
static struct pen_vec3 local_vertex(const struct pen_freezer *f, const struct pen_placed *body,
                                    uint32_t i)
{
    return pen_without_less(pen_local_point(&f->frame, body->vertices[i]), PEN_LEAST);
}

static bool fill_polygon(struct pen_freezer *f, struct filler *a, const struct pen_placed *body,
                         struct pen_polygon *polygon)
{
    struct pen_vec3 *v = a->vertices;
    a->vertices += body->count;
    for (uint32_t i = 0; i < body->count; i++)
        v[i] = local_vertex(f, body, i);
    return pen_polygon_make(polygon, v, body->count);
}

static bool fill_triangle(struct pen_freezer *f, const struct pen_placed *body,
                          struct pen_triangle *triangle)
{
    return body->count == 3 &&
           pen_triangle_make(triangle, local_vertex(f, body, 0), local_vertex(f, body, 1),
                             local_vertex(f, body, 2));
}

/* Makes primitive number `index` of its kind. False if its numbers are beyond what geometry
 * takes. */
static bool fill_shape(struct pen_freezer *f, struct filler *a, const struct pen_placed *body,
                       uint32_t index)
{
    struct pen_vec3 p = pen_local_point(&f->frame, body->point);
    double r = pen_local_length(&f->frame, body->radius);
    double h = pen_local_length(&f->frame, body->height);
    if (!pen_freeze_in_range(p))
        return false;
    switch (body->kind) {
    case PEN_PRIM_SPHERE:
        return pen_sphere_make(&a->sphere[index], p, r);
    case PEN_PRIM_PLANE:
        return pen_plane_make(&a->plane[index], p, body->direction);
    case PEN_PRIM_TRIANGLE:
        return fill_triangle(f, body, &a->triangle[index]);
    case PEN_PRIM_POLYGON:
        return fill_polygon(f, a, body, &a->polygon[index]);
    case PEN_PRIM_INFINITE_CYLINDER:
        return pen_infinite_cylinder_make(&a->infinite_cylinder[index], p, body->direction, r);
    case PEN_PRIM_CYLINDER:
        return pen_cylinder_make(&a->cylinder[index], p, body->direction, r, h, body->caps);
    case PEN_PRIM_KIND_COUNT:
        break;
    }
    return false;
}

static bool fill_body(struct pen_freezer *f, const struct pen_placed *body, void *user)
{
    struct filler *a = user;
    uint32_t prim = a->prims.count++;
    uint32_t index = a->prims.kind_count[body->kind]++;
    a->ref[prim] = (struct pen_prim_ref){.kind = body->kind & 0xF, .index = index & 0xFFFFFFF};
    a->material[prim] = body->material >= 0 ? (uint32_t)body->material : f->desc->material_count;
    a->see_through[prim] = unit_lit(f->scene->materials[a->material[prim]].kt);
    f->scene->any_see_through = f->scene->any_see_through || a->see_through[prim];
    if (!fill_shape(f, a, body, index))
        return pen_fail(f->st, PEN_INVALID,
                        "is too large, too small or too far away beside the rest of the scene");
    return true;
}

bool pen_freeze_prims(struct pen_freezer *f)
{
    struct filler a = {0};
    if (!alloc_arrays(f, &a) || !pen_freeze_each(f, fill_body, &a))
        return false;
    f->scene->prims = a.prims;
    f->scene->prims.ref = a.ref;
    f->scene->prims.sphere = a.sphere;
    f->scene->prims.plane = a.plane;
    f->scene->prims.triangle = a.triangle;
    f->scene->prims.polygon = a.polygon;
    f->scene->prims.infinite_cylinder = a.infinite_cylinder;
    f->scene->prims.cylinder = a.cylinder;
    f->scene->prim_material = a.material;
    f->scene->see_through = a.see_through;
    return true;
}
