/* SPDX-License-Identifier: MIT */
/* What the test of a mesh's blocks and their packing need of the mesh. */
#include <stdlib.h>

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

/* What a part of a mesh's triangles needs to know of the frame. */
struct part {
    float longest; /* a bound of the edges, as sums of their parts along the axes */
    bool exact;    /* the factor changes no bit of the numbers */
};

struct measuring {
    const struct pen_mesh *mesh;
    float factor;
    struct part *part;
};

enum { TRIANGLES_IN_PART = 1 << 13 };

/* An edge is not longer than the box around its triangle. Three sums of floats round by less than
 * 2^-20. */
static void measure_part(void *user, uint32_t number)
{
    const struct measuring *m = user;
    const float factor = m->factor, back = 1 / factor;
    const uint32_t begin = number * TRIANGLES_IN_PART;
    struct part part = {0, true};
    for (uint32_t i = begin; i < m->mesh->count && i - begin < TRIANGLES_IN_PART; i++) {
        const float *a = pen_mesh_float(m->mesh, i, 0), *b = pen_mesh_float(m->mesh, i, 1),
                    *c = pen_mesh_float(m->mesh, i, 2);
        float sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            const float x = a[axis] * factor, y = b[axis] * factor, z = c[axis] * factor;
            const float xy_lo = x < y ? x : y, xy_hi = x < y ? y : x;
            part.exact &= (x * back == a[axis]) & (y * back == b[axis]) & (z * back == c[axis]);
            sum += (xy_hi > z ? xy_hi : z) - (xy_lo < z ? xy_lo : z);
        }
        part.longest = sum > part.longest ? sum : part.longest;
    }
    m->part[number] = part;
}

/* Measures the triangles; returns false when out of memory. */
static bool measure(struct pen_thread_pool *pool, const struct pen_mesh *mesh, float factor,
                    struct part *all)
{
    const uint32_t parts = pen_parts_of(mesh->count, TRIANGLES_IN_PART);
    struct measuring m = {mesh, factor, malloc(parts * sizeof *m.part)};
    *all = (struct part){0, true};
    if (!m.part)
        return false;
    pen_parts_do(pool, parts, measure_part, &m);
    for (uint32_t i = 0; i < parts; i++) {
        all->longest = m.part[i].longest > all->longest ? m.part[i].longest : all->longest;
        all->exact = all->exact && m.part[i].exact;
    }
    free(m.part);
    return true;
}

static bool make_frame(struct pen_thread_pool *pool, const struct pen_mesh *mesh,
                       struct pen_mesh_frame *frame)
{
    struct part all;
    const double extent = larger(largest3(mesh->box.lo), largest3(mesh->box.hi));
    const double factor = extent > 0 ? pen_scale2(1, -pen_exponent(extent)) : 1;
    if (!(factor >= 0x1p-100 && factor <= 0x1p100 && mesh->unit >= 0x1p-200 * factor &&
          mesh->unit <= 0x1p200 * factor) ||
        !measure(pool, mesh, (float)factor, &all) || !all.exact)
        return false;
    *frame = (struct pen_mesh_frame){.unit = mesh->unit / factor,
                                     .inv_unit = factor / mesh->unit,
                                     .factor = (float)factor,
                                     .extent = extent * factor};
    frame->rounding =
        0x1p-52 * (largest3(mesh->shift) * frame->inv_unit + 1) + PEN_LEAST * frame->inv_unit;
    frame->longest = pen_float_up((double)all.longest * (1 + 0x1p-20));
    return true;
}

bool pen_mesh_frames_make(struct pen_thread_pool *pool, const struct pen_prims *prims,
                          struct pen_mesh_frame *frame)
{
    bool ok = prims->mesh_count > 0;
    for (uint32_t i = 0; ok && i < prims->mesh_count; i++)
        ok = make_frame(pool, &prims->mesh[i], &frame[i]);
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
