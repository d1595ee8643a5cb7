/* SPDX-License-Identifier: MIT */
/* A ray in the coordinates of a mesh, in binary32, and the bounds of what rounding does to the test
 * of a block of triangles. src/accel/MESHES.md derives them. */
#ifndef PEN_ACCEL_INTERNAL_MESH_RAY_H
#define PEN_ACCEL_INTERNAL_MESH_RAY_H

#include "accel/internal/mesh_box.h"

/* The point at depth x is o + x d; its depth for boxes is (x + moved) unit. */
struct mesh_ray {
    float4 o, d;
    double moved;
    float unit, moved_near; /* moved, rounded */
    float limit;            /* of a shadow ray: the depth of the light */
    /* Of a triangle of size L, the sum of its edges along the axes plus `size`: */
    float size;           /* three times what a vertex may be off by */
    float beside, across; /* L (beside + L across): what edge functions are off by */
    float depth;          /* L L (depth + 10 v L): what depth times d.n is off by */
};

/* 10 v x. */
#define MESH_NORMAL(x) (10 * 0x1p-24f * (x))

/* Moves an origin that is far from the mesh. *at is then NaN if the ray does not come near it: no
 * lane may be met. Returns false if nothing of the test can be sure. */
static __attribute__((noinline)) bool mesh_ray_move(struct mesh_ray *to, float4 *at, double4 *o,
                                                    const struct mesh_box *box, double extent,
                                                    double rest)
{
    /* The ball that the ray must come near has room for what is outside its box (mesh_outside). */
    const bool sure = 0x1p12 * rest < extent,
               near = !sure || mesh_move_near(box, o, &to->moved, extent, rest);
    *at = near ? (float4){mesh_coordinate((*o)[0]), mesh_coordinate((*o)[1]),
                          mesh_coordinate((*o)[2]), 0}
               : (float4){NAN, NAN, NAN, 0};
    return sure;
}

_Static_assert(offsetof(struct pen_mesh, unit) ==
                   offsetof(struct pen_mesh, shift) + 3 * sizeof(double),
               "shift is read with one number more");

/* `box`: the ray for boxes. `off`: how far rounding, in the local frame, and the self-intersection
 * rule reach. */
static inline void mesh_ray_make(struct mesh_ray *to, const struct pen_mesh *mesh,
                                 const struct pen_mesh_frame *frame, const struct mesh_box *box,
                                 float off)
{
    const float by = (float)frame->inv_unit, extent = frame->extent;
    double4 o = (box->o - *(const double4 *)&mesh->shift.x) * frame->inv_unit;
    float4 at = mesh_at(&o);
    float far = float4_largest(at);
    float rest = (0x1p-48f * (box->distance * by + far + extent) + off * by) * (1 + 0x1p-20f);
    to->moved = 0;
    if (far > 4 * extent) {
        if (!mesh_ray_move(to, &at, &o, box, (double)extent, (double)rest))
            rest = INFINITY;
        far = float4_largest(at);
    }
    const float size = (far + extent) * (1 + 0x1p-20f);
    const float steepest = float4_largest(box->direction);
    to->o = at;
    to->d = box->direction;
    to->unit = (float)frame->unit;
    to->moved_near = (float)to->moved;
    to->size = mesh_bound(3 * rest);
    to->beside = mesh_bound(steepest * (56 * 0x1p-24f * size + 16 * rest));
    to->across = MESH_NORMAL(steepest);
    to->depth = mesh_bound(48 * 0x1p-24f * size + 20 * rest);
}

/* What the test of blocks tells. Lanes are bits. Depths are those for boxes. */
struct mesh_lanes {
    unsigned may;  /* not certainly missed */
    unsigned sure; /* of these: certainly entered, ahead of the origin, between lo and hi; or, for a
                      shadow ray, before the light and off the point there */
    float lo[MESH_LANES], hi[MESH_LANES];
};

static inline struct floats3 mesh_corners(const struct pen_mesh4 *a, const struct pen_mesh4 *b,
                                          int i)
{
    return (struct floats3){floats_load(a->v[i][0], b->v[i][0]),
                            floats_load(a->v[i][1], b->v[i][1]),
                            floats_load(a->v[i][2], b->v[i][2])};
}

/* Tests MESH_BLOCKS blocks, of one mesh. `limit`: a depth for boxes, beyond which nothing matters.
 * Shadow rays (`any`) take that of the ray. */
static inline __attribute__((always_inline)) void
mesh_ray_test(const struct mesh_ray *ray, const struct pen_mesh4 *one, const struct pen_mesh4 *two,
              float limit, bool any, struct mesh_lanes *out)
{
    const struct floats3 o = {floats_splat(ray->o[0]), floats_splat(ray->o[1]),
                              floats_splat(ray->o[2])},
                         d = {floats_splat(ray->d[0]), floats_splat(ray->d[1]),
                              floats_splat(ray->d[2])};
    const struct floats3 a = mesh_corners(one, two, 0), t = floats3_sub(a, o);
    const struct floats3 e = floats3_sub(mesh_corners(one, two, 1), a),
                         f = floats3_sub(mesh_corners(one, two, 2), a);
    const struct floats3 n = floats3_cross(e, f), r = floats3_cross(t, d);
    const floats across = floats3_dot(n, d);
    const masks sign = (masks)across & INT32_MIN;
    const floats steep = floats_abs(across), u = floats_turned(floats3_dot(f, r), sign),
                 v = floats_turned(-floats3_dot(e, r), sign), w = steep - (u + v);
    const floats size = floats_max(floats3_norm1(e), floats3_norm1(f)) + ray->size;
    const floats beside =
        size * floats_fma(size, floats_splat(ray->across), floats_splat(ray->beside));
    const floats least = floats_min(floats_min(u, v), w);
    const masks may = floats_at_least(least, -beside);
    out->may = masks_bits(may);
    out->sure = 0;
    if (!out->may)
        return;
    const floats height = floats_turned(floats3_dot(n, t), sign);
    const floats off = size * size * (MESH_NORMAL(size) + ray->depth);
    const floats inv = 1.0f / steep;
    const masks ahead = floats_more(height, 2.0f * off), behind = floats_more(-2.0f * off, height);
    floats low = (height - 1.5f * off) * inv;
    if (!any) {
        const floats high = ((height + 1.5f * off) * inv + ray->moved_near) * ray->unit;
        low = (low + ray->moved_near) * ray->unit;
        low -= floats_abs(low) * 0x1p-22f;
        *(floats *)out->lo = low;
        *(floats *)out->hi = high + floats_abs(high) * 0x1p-22f;
    }
    const masks beyond = floats_more(low, floats_splat(any ? ray->limit : limit));
    const masks missed = behind | (ahead & beyond);
    masks sure = floats_more(least, beside) & ahead;
    if (any)
        sure &= floats_more(ray->limit * steep - height, 3.0f * off);
    out->may = masks_bits(may & ~missed);
    out->sure = out->may & masks_bits(sure);
}

#endif
