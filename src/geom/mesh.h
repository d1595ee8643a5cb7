/* SPDX-License-Identifier: MIT */
/* Meshes: triangles that share vertices, as a file has them. Their numbers are a range, and none of
 * them is stored as a primitive. A triangle of a mesh is made when it is needed, and is then a
 * struct pen_triangle like any other, with the same edge rule, facet and self-intersection rule. */
#ifndef PEN_GEOM_MESH_H
#define PEN_GEOM_MESH_H

#include <stddef.h>

#include "geom/triangle.h"

/* In corner_normal: the corner has no normal. */
#define PEN_NO_NORMAL UINT32_MAX

/* Triangles with the numbers first to first + count - 1.
 * Owns: nothing; it borrows the arrays. */
struct pen_mesh {
    const float *vertex;    /* three for each vertex; not NaN, not infinite */
    const uint32_t *corner; /* three for each triangle: the numbers of its vertices */
    /* Normals for shading, three floats each, finite, of any length; NULL: it has none. */
    const float *normal;
    /* Three for each triangle: the numbers of its corners' normals. NULL: a corner's normal has the
     * number of its vertex. */
    const uint32_t *corner_normal;
    /* By triangle: which of the mesh's materials it has. NULL: all have the first. */
    const uint16_t *material_of;
    /* A vertex f is at shift + unit f in the local frame, rounded once. unit is a power of two, at
     * least 2^-900, so the product is exact. */
    struct pen_vec3 shift;
    double unit;
    struct pen_box box; /* of the vertices that triangles use, as numbers of the mesh */
    float least;        /* of these numbers: the smallest size that is not 0; INFINITY: none */
    uint32_t first, count;
    uint32_t slot, slots; /* one for each of its materials: see pen_prim_slot */
    uint32_t index;       /* of its first triangle: see struct pen_prim_ref */
};

/* A corner of a triangle, in the mesh's own coordinates. */
static inline const float *pen_mesh_float(const struct pen_mesh *mesh, uint32_t triangle, int i)
{
    return mesh->vertex + 3 * (size_t)mesh->corner[3 * (size_t)triangle + (size_t)i];
}

/* The place of a vertex f in the local frame. */
static inline struct pen_vec3 pen_mesh_place(const struct pen_mesh *mesh, struct pen_vec3 f)
{
    return pen_without_less(pen_vec3(mesh->unit * f.x + mesh->shift.x,
                                     mesh->unit * f.y + mesh->shift.y,
                                     mesh->unit * f.z + mesh->shift.z),
                            PEN_LEAST);
}

/* Places keep the order of numbers along an axis, so boxes of numbers are boxes of places. */
static inline struct pen_box pen_mesh_box(const struct pen_mesh *mesh)
{
    return (struct pen_box){pen_mesh_place(mesh, mesh->box.lo), pen_mesh_place(mesh, mesh->box.hi)};
}

/* A vertex in the local frame. */
static inline struct pen_vec3 pen_mesh_vertex(const struct pen_mesh *mesh, uint32_t vertex)
{
    const float *f = mesh->vertex + 3 * (size_t)vertex;
    return pen_mesh_place(mesh, pen_vec3((double)f[0], (double)f[1], (double)f[2]));
}

/* The corners of a triangle of the mesh, in the order of the file. */
static inline void pen_mesh_corners(const struct pen_mesh *mesh, uint32_t triangle,
                                    struct pen_vec3 v[3])
{
    const uint32_t *corner = mesh->corner + 3 * (size_t)triangle;
    for (int i = 0; i < 3; i++)
        v[i] = pen_mesh_vertex(mesh, corner[i]);
}

/* The slot of a triangle of the mesh: that of its material. */
static inline uint32_t pen_mesh_slot(const struct pen_mesh *mesh, uint32_t triangle)
{
    return mesh->slot + (mesh->material_of ? mesh->material_of[triangle] : 0);
}

/* Makes a triangle of the mesh. */
void pen_mesh_triangle(const struct pen_mesh *mesh, uint32_t triangle, struct pen_triangle *out);

/* The same with the corners alone; out->facet is not set. */
void pen_mesh_outline(const struct pen_mesh *mesh, uint32_t triangle, struct pen_triangle *out);

/* pen_prim_bounds of a triangle of the mesh. */
struct pen_box pen_mesh_bounds(const struct pen_mesh *mesh, uint32_t triangle);

/* Fills in mesh->box and mesh->least. */
void pen_mesh_measure(struct pen_mesh *mesh);

#endif
