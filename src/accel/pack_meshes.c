/* SPDX-License-Identifier: MIT */
/* What the test of a mesh's blocks needs of the mesh. */
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

/* The longest edge of the mesh's triangles, as the sum of its parts along the axes. */
static float longest_edge(const struct pen_mesh *mesh)
{
    double longest = 0;
    for (uint32_t i = 0; i < mesh->count; i++) {
        const float *a = pen_mesh_float(mesh, i, 0), *b = pen_mesh_float(mesh, i, 1),
                    *c = pen_mesh_float(mesh, i, 2);
        double ab = 0, bc = 0, ca = 0;
        for (int axis = 0; axis < 3; axis++) {
            ab += fabs((double)a[axis] - (double)b[axis]);
            bc += fabs((double)b[axis] - (double)c[axis]);
            ca += fabs((double)c[axis] - (double)a[axis]);
        }
        longest = larger(longest, larger(ab, larger(bc, ca)));
    }
    return pen_float_up(longest * (1 + 0x1p-20));
}

/* Whether the factor changes no bit of the mesh's numbers. */
static bool is_exact(const struct pen_mesh *mesh, float factor)
{
    const float back = 1 / factor;
    for (size_t i = 0; i < 3 * (size_t)mesh->count; i++) {
        const float *f = mesh->vertex + 3 * (size_t)mesh->corner[i];
        for (int axis = 0; axis < 3; axis++)
            if (f[axis] * factor * back != f[axis])
                return false;
    }
    return true;
}

static bool make_frame(const struct pen_mesh *mesh, struct pen_mesh_frame *frame)
{
    const double extent = larger(largest3(mesh->box.lo), largest3(mesh->box.hi));
    const double factor = extent > 0 ? pen_scale2(1, -pen_exponent(extent)) : 1;
    if (!(factor >= 0x1p-100 && factor <= 0x1p100 && mesh->unit >= 0x1p-200 * factor &&
          mesh->unit <= 0x1p200 * factor) ||
        !is_exact(mesh, (float)factor))
        return false;
    *frame = (struct pen_mesh_frame){.unit = mesh->unit / factor,
                                     .inv_unit = factor / mesh->unit,
                                     .factor = (float)factor,
                                     .extent = extent * factor};
    frame->rounding =
        0x1p-52 * (largest3(mesh->shift) * frame->inv_unit + 1) + PEN_LEAST * frame->inv_unit;
    frame->longest = longest_edge(mesh) * frame->factor;
    return true;
}

bool pen_mesh_frames_make(const struct pen_prims *prims, struct pen_mesh_frame *frame)
{
    bool ok = prims->mesh_count > 0;
    for (uint32_t i = 0; ok && i < prims->mesh_count; i++)
        ok = make_frame(&prims->mesh[i], &frame[i]);
    return ok;
}
