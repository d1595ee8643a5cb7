/* SPDX-License-Identifier: MIT */
/* Data of single primitives for ray packets: their boxes, and which outlines are convex. */
#include <string.h>

#include "accel/internal/tree_layout.h"

static struct pen_vec3 cross(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

/* Whether all corners are to the left of each edge e and in its plane. For each corner at f from
 * the beginning of e, e x f is along the normal, up to 2^-40 of |e|_1 and the extent. */
static bool is_convex(const struct pen_polygon *p)
{
    for (uint32_t i = 0; i < p->count; i++) {
        const struct pen_vec3 from = p->v[i], e = pen_sub(p->v[(i + 1) % p->count], from);
        const double tolerance = 0x1p-40 * p->extent * pen_norm1(e);
        for (uint32_t k = 0; k < p->count; k++) {
            const struct pen_vec3 w = cross(e, pen_sub(p->v[k], from));
            const double left = pen_dot(w, p->facet.n);
            const struct pen_vec3 off = pen_along(w, p->facet.n, -left);
            if (!(left >= -tolerance && pen_norm1(off) <= tolerance))
                return false;
        }
    }
    return true;
}

static bool outline_is_convex(const struct pen_prims *prims, uint32_t prim)
{
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    if (ref.kind == PEN_PRIM_TRIANGLE)
        return true;
    if (ref.kind != PEN_PRIM_POLYGON)
        return false;
    const struct pen_polygon *p = &prims->polygon[ref.index];
    return !p->piece && p->count <= PEN_CONVEX_CORNERS && is_convex(p);
}

/* The largest size of a coordinate of the boxes of the first node. */
static double extent_of(const struct pen_tree_layout *layout)
{
    struct pen_child_box in;
    double extent = 0;
    for (int lane = 0; lane < PEN_WIDE && layout->nodes.count > 0; lane++) {
        if (!pen_tree_layout_child(layout, 0, lane, &in))
            continue;
        for (int axis = 0; axis < 3; axis++) {
            const double lo = fabs((double)in.lo[axis]), hi = fabs((double)in.hi[axis]);
            extent = lo > extent ? lo : extent;
            extent = hi > extent ? hi : extent;
        }
    }
    return extent;
}

bool pen_accel_pack_boxes(const struct pen_tree_layout *layout, struct pen_arena *arena,
                          struct pen_accel *accel)
{
    const size_t count = pen_prim_slots(layout->prims);
    struct pen_float_box *box = pen_arena_alloc(arena, count, sizeof *box);
    bool *convex = pen_arena_alloc(arena, count, sizeof *convex);
    if (!box || !convex)
        return false;
    const bool meshes_alone = pen_tree_layout_meshes_alone(layout);
    for (uint32_t i = 0; i < layout->count && !meshes_alone; i++) {
        const struct pen_ref *ref = &layout->ref[i];
        if (ref->kind == PEN_BLOCK_MESH || pen_prim_mesh(layout->prims, ref->prim))
            continue;
        const uint32_t slot = pen_prim_slot(layout->prims, ref->prim);
        memcpy(box[slot].lo, ref->lo, sizeof ref->lo);
        memcpy(box[slot].hi, ref->hi, sizeof ref->hi);
        convex[slot] = outline_is_convex(layout->prims, ref->prim);
    }
    accel->extent = extent_of(layout);
    accel->prim_box = box;
    accel->convex = convex;
    return true;
}
