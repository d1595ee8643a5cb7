/* SPDX-License-Identifier: MIT */
/* What the test of a mesh's blocks and their packing need of the mesh. */
#include <float.h>

#include "accel/internal/rounding.h"
#include "accel/internal/tree_layout.h"
#include "math/scale.h"

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double largest3(struct pen_vec3 v)
{
    return larger(larger(fabs(v.x), fabs(v.y)), fabs(v.z));
}

/* Whether sums with this shift are 0 or not below PEN_LEAST: they are multiples of 2^-293. */
static bool is_coarse(struct pen_vec3 shift)
{
    return (shift.x == 0 || fabs(shift.x) >= 0x1p-240) &&
           (shift.y == 0 || fabs(shift.y) >= 0x1p-240) &&
           (shift.z == 0 || fabs(shift.z) >= 0x1p-240);
}

/* Makes what the test of blocks needs. The unit's range keeps depths, in the block's numbers and in
 * the local frame, in that of floats. */
static bool make_frame(const struct pen_mesh *mesh, struct pen_mesh_frame *frame)
{
    const double extent = larger(largest3(mesh->box.lo), largest3(mesh->box.hi));
    const double factor = extent > 0 ? pen_scale2(1, -pen_exponent(extent)) : 1;
    if (!(factor >= 0x1p-100 && factor <= 0x1p100 && mesh->unit >= 0x1p-60 * factor &&
          mesh->unit <= 0x1p60 * factor) ||
        !is_coarse(mesh->shift) || (factor < 1 && (double)mesh->least * factor < (double)FLT_MIN))
        return false;
    *frame = (struct pen_mesh_frame){.unit = mesh->unit / factor,
                                     .inv_unit = factor / mesh->unit,
                                     .factor = (float)factor,
                                     .extent = pen_float_up(extent * factor)};
    return true;
}

bool pen_mesh_frames_make(const struct pen_prims *prims, struct pen_mesh_frame *frame)
{
    bool ok = prims->mesh_count > 0;
    for (uint32_t i = 0; ok && i < prims->mesh_count; i++)
        ok = make_frame(&prims->mesh[i], &frame[i]);
    return ok;
}

void pen_pack_fetch(const struct pen_tree_layout *layout, struct pen_leaf leaf, bool vertices)
{
    const struct pen_mesh *mesh = NULL;
    for (uint32_t i = leaf.begin; layout->frames && i < leaf.begin + leaf.count; i++) {
        const uint32_t prim = layout->ref[i].prim;
        if (!mesh || prim - mesh->first >= mesh->count)
            mesh = pen_prim_mesh(layout->prims, prim);
        if (mesh && !vertices)
            __builtin_prefetch(&mesh->corner[3 * (size_t)(prim - mesh->first)]);
        for (int k = 0; mesh && vertices && k < 3; k++)
            __builtin_prefetch(pen_mesh_float(mesh, prim - mesh->first, k));
    }
}
