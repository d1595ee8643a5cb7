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

struct pen_box pen_mesh_bounds(const struct pen_mesh *mesh, uint32_t triangle)
{
    const float *a = pen_mesh_float(mesh, triangle, 0), *b = pen_mesh_float(mesh, triangle, 1),
                *c = pen_mesh_float(mesh, triangle, 2);
    double lo[3], hi[3];
    for (int axis = 0; axis < 3; axis++) {
        const float low = a[axis] < b[axis] ? a[axis] : b[axis];
        const float high = a[axis] < b[axis] ? b[axis] : a[axis];
        lo[axis] = (double)(low < c[axis] ? low : c[axis]);
        hi[axis] = (double)(high > c[axis] ? high : c[axis]);
    }
    const struct pen_vec3 v[2] = {pen_mesh_place(mesh, pen_vec3(lo[0], lo[1], lo[2])),
                                  pen_mesh_place(mesh, pen_vec3(hi[0], hi[1], hi[2]))};
    return pen_outline_bounds(v, 2, 0);
}

/* The unit normal of a corner; 0 if it has none. */
static struct pen_vec3 corner_normal(const struct pen_mesh *mesh, uint32_t triangle, int i)
{
    const uint32_t *of = mesh->corner_normal ? mesh->corner_normal : mesh->corner;
    const uint32_t number = of[3 * (size_t)triangle + (size_t)i];
    const struct pen_vec3 none = {0, 0, 0};
    if (number == PEN_NO_NORMAL)
        return none;
    const float *f = mesh->normal + 3 * (size_t)number;
    const struct pen_vec3 n = pen_vec3((double)f[0], (double)f[1], (double)f[2]);
    const double length = pen_length(n); /* of floats: a double holds its square */
    return length > 0 ? pen_scale(n, 1 / length) : none;
}

/* The areas of the triangles of p and two of the corners v, opposite to each corner, projected
 * along an axis. Where rounding puts p outside, they are 0. */
static void opposite_areas(const struct pen_vec3 v[3], struct pen_vec3 p, int axis, double area[3])
{
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    double x[3], y[3];
    for (int i = 0; i < 3; i++) {
        const struct pen_vec3 q = pen_sub(v[i], p);
        x[i] = pen_component(q, a);
        y[i] = pen_component(q, b);
    }
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        area[i] = pen_dop(x[j], y[k], x[k], y[j]);
    }
    const double sign = area[0] + area[1] + area[2] < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++)
        area[i] = sign * area[i] > 0 ? sign * area[i] : 0;
}

static struct pen_vec3 shading_normal(const struct pen_mesh *mesh, uint32_t triangle,
                                      struct pen_vec3 p, struct pen_vec3 n)
{
    const double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    struct pen_vec3 v[3], mix = {0, 0, 0};
    double area[3];
    pen_mesh_corners(mesh, triangle, v);
    opposite_areas(v, p, x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2), area);
    const double all = area[0] + area[1] + area[2];
    for (int i = 0; i < 3; i++) {
        const struct pen_vec3 corner = corner_normal(mesh, triangle, i);
        if (!(pen_norm1(corner) > 0))
            return n;
        mix = pen_along(mix, corner, area[i] / all);
    }
    const double side = pen_dot(mix, n);
    if (!(side * side > 0)) /* or NaN */
        return n;
    return pen_scale(mix, (side < 0 ? -1 : 1) / pen_length(mix));
}

void pen_mesh_measure(struct pen_mesh *mesh)
{
    float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    float least = INFINITY;
    for (size_t i = 0; i < 3 * (size_t)mesh->count; i++) {
        const float *f = mesh->vertex + 3 * (size_t)mesh->corner[i];
        for (int axis = 0; axis < 3; axis++) {
            lo[axis] = f[axis] < lo[axis] ? f[axis] : lo[axis];
            hi[axis] = f[axis] > hi[axis] ? f[axis] : hi[axis];
            const float size = f[axis] != 0 ? fabsf(f[axis]) : INFINITY;
            least = size < least ? size : least;
        }
    }
    mesh->least = least;
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

bool pen_prim_shading_normal(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p,
                             struct pen_vec3 *n)
{
    const struct pen_mesh *mesh = pen_prim_mesh(prims, prim);
    if (!mesh || !mesh->normal)
        return false;
    *n = shading_normal(mesh, prim - mesh->first, p, *n);
    return true;
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
