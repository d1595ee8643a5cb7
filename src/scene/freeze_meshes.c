/* SPDX-License-Identifier: MIT */
/* Meshes of the frozen scene. They borrow the description's arrays. A transform that is more than a
 * power of two and a shift gives a mesh vertices of its own, rounded once to floats. */
#include <stdlib.h>

#include "math/scale.h"
#include "scene/internal/freeze.h"

void pen_mesh_desc_triangle(const struct pen_mesh_desc *mesh, uint32_t triangle,
                            struct pen_vec3 v[3])
{
    const double unit = pen_scale2(1, mesh->exponent);
    for (int i = 0; i < 3; i++) {
        const float *f = mesh->vertex + 3 * (size_t)mesh->corner[3 * (size_t)triangle + (size_t)i];
        v[i] = pen_vec3(fma(unit, (double)f[0], mesh->shift[0]),
                        fma(unit, (double)f[1], mesh->shift[1]),
                        fma(unit, (double)f[2], mesh->shift[2]));
    }
}

/* Whether the transform is a shift after a scale by a power of two, which floats keep exactly. */
static bool is_exact(const struct pen_transform *f, int *exponent)
{
    const double s = f->m[0][0];
    *exponent = 0;
    if (!(s > 0) || f->m[1][1] != s || f->m[2][2] != s || f->m[0][1] != 0 || f->m[0][2] != 0 ||
        f->m[1][0] != 0 || f->m[1][2] != 0 || f->m[2][0] != 0 || f->m[2][1] != 0)
        return false;
    *exponent = pen_exponent(s);
    while (pen_scale2(1, *exponent) > s)
        --*exponent;
    return pen_scale2(1, *exponent) == s;
}

/* The mesh's vertex in the document's units, moved. */
static struct pen_vec3 moved_vertex(const struct pen_scene_prim *prim, uint32_t vertex)
{
    const struct pen_mesh_desc *d = prim->mesh;
    const double unit = pen_scale2(1, d->exponent);
    const float *f = d->vertex + 3 * (size_t)vertex;
    return pen_transform_point(prim->moved_by, pen_vec3(fma(unit, (double)f[0], d->shift[0]),
                                                        fma(unit, (double)f[1], d->shift[1]),
                                                        fma(unit, (double)f[2], d->shift[2])));
}

/* A number with few digits near x: a multiple of 2^exponent. */
static double coarse(double x, int exponent)
{
    const double steps = pen_scale2(x, -exponent);
    return fabs(steps) < 0x1p52 ? pen_scale2(floor(steps + 0.5), exponent) : x;
}

/* Gives the mesh normals of its own: unit vectors along those of the description, moved by the
 * inverse transpose. That is the matrix of cofactors, but for a factor, whose sign does not matter.
 * A normal that becomes 0 or leaves the range of numbers is 0: its triangles are flat. */
static bool move_normals(struct pen_freezer *f, const struct pen_scene_prim *prim,
                         struct pen_mesh *mesh)
{
    const struct pen_mesh_desc *d = prim->mesh;
    struct pen_vec3 row[3];
    double largest = 0;
    for (int i = 0; i < 3; i++) {
        const double *m = prim->moved_by->m[i];
        row[i] = pen_vec3(m[0], m[1], m[2]);
        largest = pen_larger(largest, vec_max_abs(row[i]));
    }
    for (int i = 0; i < 3; i++)
        row[i] = vec_scale2_down(row[i], pen_exponent(largest));
    const struct pen_vec3 cofactors[3] = {pen_cross(row[1], row[2]), pen_cross(row[2], row[0]),
                                          pen_cross(row[0], row[1])};
    float *normal = pen_arena_alloc(f->scene->arena, 3 * (size_t)d->normal_count, sizeof *normal);
    if (!normal)
        return pen_freeze_no_memory(f);
    for (size_t i = 0; i < 3 * (size_t)d->normal_count; i += 3) {
        const struct pen_vec3 from =
            pen_vec3((double)d->normal[i], (double)d->normal[i + 1], (double)d->normal[i + 2]);
        const struct pen_vec3 n = vec_normalize(pen_vec3(
            pen_dot(cofactors[0], from), pen_dot(cofactors[1], from), pen_dot(cofactors[2], from)));
        const bool finite = isfinite(pen_norm1(n));
        normal[i] = finite ? (float)n.x : 0;
        normal[i + 1] = finite ? (float)n.y : 0;
        normal[i + 2] = finite ? (float)n.z : 0;
    }
    mesh->normal = normal;
    return true;
}

/* Numbers by corner of a mirrored mesh: in reverse, so that the outside stays outside. */
static const uint32_t *mirror(struct pen_freezer *f, const struct pen_mesh_desc *d,
                              const uint32_t *of)
{
    const size_t corners = 3 * (size_t)d->triangle_count;
    uint32_t *to = pen_arena_alloc(f->scene->arena, corners, sizeof *to);
    for (size_t i = 0; to && i < corners; i += 3) {
        to[i] = of[i + 2];
        to[i + 1] = of[i + 1];
        to[i + 2] = of[i];
    }
    return to;
}

/* Gives the mesh vertices of its own: those of the description, moved and rounded to floats around
 * the middle of their box. */
static bool move(struct pen_freezer *f, const struct pen_scene_prim *prim, struct pen_mesh *mesh)
{
    const struct pen_mesh_desc *d = prim->mesh;
    struct pen_box box = pen_box_empty();
    for (uint32_t i = 0; i < d->vertex_count; i++)
        box = pen_box_add_point(box, moved_vertex(prim, i));
    const double extent = vec_max_abs(pen_sub(box.hi, box.lo));
    if (!isfinite(extent) || !isfinite(vec_max_abs(box.lo)))
        return pen_fail(f->st, PEN_INVALID, "the transforms around it leave the range of numbers");
    const int exponent = extent > 0 ? pen_exponent(extent) : 0;
    const struct pen_vec3 middle = pen_box_center(box);
    mesh->shift = pen_vec3(coarse(middle.x, exponent), coarse(middle.y, exponent),
                           coarse(middle.z, exponent));
    mesh->unit = pen_scale2(1, exponent);
    float *vertex = pen_arena_alloc(f->scene->arena, 3 * (size_t)d->vertex_count, sizeof *vertex);
    if (!vertex)
        return pen_freeze_no_memory(f);
    for (uint32_t i = 0; i < d->vertex_count; i++) {
        const struct pen_vec3 p =
            vec_scale2_down(pen_sub(moved_vertex(prim, i), mesh->shift), exponent);
        vertex[3 * (size_t)i] = (float)p.x;
        vertex[3 * (size_t)i + 1] = (float)p.y;
        vertex[3 * (size_t)i + 2] = (float)p.z;
    }
    mesh->vertex = vertex;
    if (d->normal && !move_normals(f, prim, mesh))
        return false;
    if (pen_transform_orientation(prim->moved_by) > 0)
        return true;
    mesh->corner = mirror(f, d, d->corner);
    if (d->corner_normal)
        mesh->corner_normal = mirror(f, d, d->corner_normal);
    return (mesh->corner && (mesh->corner_normal || !d->corner_normal)) || pen_freeze_no_memory(f);
}

/* Makes a mesh in the document's units. */
static bool make(struct pen_freezer *f, const struct pen_scene_prim *prim, struct pen_mesh *mesh)
{
    const struct pen_mesh_desc *d = prim->mesh;
    int exponent = 0;
    *mesh = (struct pen_mesh){.vertex = d->vertex,
                              .corner = d->corner,
                              .normal = d->normal,
                              .corner_normal = d->corner_normal,
                              .material_of = d->material_of,
                              .shift = pen_vec3(d->shift[0], d->shift[1], d->shift[2]),
                              .unit = pen_scale2(1, d->exponent),
                              .count = d->triangle_count,
                              .slots = d->material_count};
    if (prim->moved_by && is_exact(prim->moved_by, &exponent)) {
        mesh->shift = pen_transform_point(prim->moved_by, mesh->shift);
        mesh->unit = pen_scale2(mesh->unit, exponent);
    } else if (prim->moved_by && !move(f, prim, mesh)) {
        return false;
    }
    pen_mesh_measure(mesh);
    return true;
}

bool pen_freeze_mesh_begin(struct pen_freezer *f, const struct pen_scene_prim *prim)
{
    struct pen_mesh *more = realloc(f->mesh, (f->mesh_count + (size_t)1) * sizeof *more);
    if (!more)
        return pen_freeze_no_memory(f);
    f->mesh = more;
    struct pen_mesh *mesh = &f->mesh[f->mesh_count];
    if (!make(f, prim, mesh))
        return false;
    f->mesh_count++;
    const struct pen_box box = pen_mesh_box(mesh);
    if (!isfinite(vec_max_abs(box.lo)) || !isfinite(vec_max_abs(box.hi)))
        return pen_fail(f->st, PEN_INVALID, "is larger than a double can hold");
    f->summary.finite = pen_box_union(f->summary.finite, box);
    f->summary.total += mesh->count;
    f->summary.slots += mesh->slots;
    return true;
}

bool pen_freeze_mesh_end(const struct pen_freezer *f, struct pen_mesh *mesh)
{
    mesh->shift = pen_local_point(&f->frame, mesh->shift);
    mesh->unit = pen_local_length(&f->frame, mesh->unit);
    const struct pen_box box = pen_mesh_box(mesh);
    return mesh->unit >= 0x1p-900 && pen_freeze_in_range(box.lo) && pen_freeze_in_range(box.hi);
}
