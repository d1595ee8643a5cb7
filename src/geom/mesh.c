/* SPDX-License-Identifier: MIT */
/* Meshes: their triangles, and the primitives that numbers stand for in scenes with meshes. */
#include "geom/mesh.h"

#include "geom/internal/facet.h"
#include "geom/prims.h"

void pen_mesh_triangle(const struct pen_mesh *mesh, uint32_t triangle, struct pen_triangle *out)
{
    struct pen_vec3 v[3];
    pen_mesh_corners(mesh, triangle, v);
    if (!pen_triangle_make(out, v[0], v[1], v[2]))
        pen_triangle_make_thin(out, v);
}

void pen_mesh_outline(const struct pen_mesh *mesh, uint32_t triangle, struct pen_triangle *out)
{
    struct pen_vec3 v[3];
    pen_mesh_corners(mesh, triangle, v);
    const int first = pen_triangle_first_corner(v);
    for (int i = 0; i < 3; i++)
        out->v[i] = v[(first + i) % 3];
}

/* Vertices are mapped to the local frame without a change of their order along an axis. */
struct pen_box pen_mesh_bounds(const struct pen_mesh *mesh, uint32_t triangle)
{
    const float *a = pen_mesh_float(mesh, triangle, 0), *b = pen_mesh_float(mesh, triangle, 1),
                *c = pen_mesh_float(mesh, triangle, 2);
    float end[6];
    for (int axis = 0; axis < 3; axis++) {
        const float low = a[axis] < b[axis] ? a[axis] : b[axis];
        const float high = a[axis] < b[axis] ? b[axis] : a[axis];
        end[axis] = low < c[axis] ? low : c[axis];
        end[3 + axis] = high > c[axis] ? high : c[axis];
    }
    struct pen_mesh ends = {.vertex = end, .shift = mesh->shift, .unit = mesh->unit};
    const struct pen_vec3 v[2] = {pen_mesh_vertex(&ends, 0), pen_mesh_vertex(&ends, 1)};
    return pen_outline_bounds(v, 2, 0);
}

void pen_mesh_measure(struct pen_mesh *mesh)
{
    float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * (size_t)mesh->count; i++) {
        const float *f = mesh->vertex + 3 * (size_t)mesh->corner[i];
        for (int axis = 0; axis < 3; axis++) {
            lo[axis] = f[axis] < lo[axis] ? f[axis] : lo[axis];
            hi[axis] = f[axis] > hi[axis] ? f[axis] : hi[axis];
        }
    }
    mesh->box = (struct pen_box){pen_vec3((double)lo[0], (double)lo[1], (double)lo[2]),
                                 pen_vec3((double)hi[0], (double)hi[1], (double)hi[2])};
}

const struct pen_mesh *pen_mesh_before(const struct pen_prims *prims, uint32_t prim)
{
    uint32_t low = 0, high = prims->mesh_count;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (prims->mesh[middle].first <= prim)
            low = middle + 1;
        else
            high = middle;
    }
    return low > 0 ? &prims->mesh[low - 1] : NULL;
}

uint32_t pen_mesh_slot_of_prim(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_mesh *mesh = pen_mesh_before(prims, prim);
    if (!mesh)
        return prim;
    if (prim - mesh->first < mesh->count)
        return pen_mesh_slot(mesh, prim - mesh->first);
    return prim - mesh->first - mesh->count + mesh->slot + mesh->slots;
}

struct pen_prim_ref pen_mesh_ref_of_prim(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_mesh *mesh = pen_prim_mesh(prims, prim);
    if (!mesh)
        return prims->ref[pen_mesh_slot_of_prim(prims, prim)];
    return (struct pen_prim_ref){.kind = PEN_PRIM_TRIANGLE,
                                 .index = (mesh->index + (prim - mesh->first)) & 0x0fffffffu};
}

/* The mesh that holds the triangle of this index. */
static const struct pen_mesh *mesh_of_index(const struct pen_prims *prims, uint32_t index)
{
    uint32_t low = 0, high = prims->mesh_count - 1;
    while (low < high) {
        const uint32_t middle = low + (high - low + 1) / 2;
        if (prims->mesh[middle].index <= index)
            low = middle;
        else
            high = middle - 1;
    }
    return &prims->mesh[low];
}

const struct pen_triangle *pen_mesh_triangle_of_index(const struct pen_prims *prims, uint32_t index,
                                                      struct pen_triangle *room)
{
    const struct pen_mesh *mesh = mesh_of_index(prims, index);
    pen_mesh_triangle(mesh, index - mesh->index, room);
    return room;
}
