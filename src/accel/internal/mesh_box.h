/* SPDX-License-Identifier: MIT */
/* A ray for the boxes of a tree with blocks of meshes, in binary32. Each plane of a box costs one
 * fma. src/accel/MESHES.md derives the margins. */
#ifndef PEN_ACCEL_INTERNAL_MESH_BOX_H
#define PEN_ACCEL_INTERNAL_MESH_BOX_H

#include "accel/internal/mesh_lanes.h"
#include "accel/internal/prim_test.h"

/* The point at depth x is o + x d, where d is the ray's direction over a power of two, `scale`, so
 * that its largest component is in [1, 2). A far origin has moved along the ray. Depth x is
 * t = (x + moved) / scale. A plane is at depth plane * inv + near, at least, and plane * inv + far
 * at most. */
struct mesh_box {
    _Alignas(32) float8 inv[3]; /* no load crosses a cache line */
    float8 near[3], far[3];
    const size_t *row; /* in a node: the first numbers of the near planes, and of the far ones */
    double4 o, d;
    float4 direction; /* d */
    double inv_dd;    /* 1 / d.d */
    double scale, moved;
    float distance; /* the largest size of a coordinate of the origin, before it moved */
    float start;    /* of the query */
    bool blind;     /* the origin is too far away: all boxes are entered, and depths do not count */
};

/* struct mesh_box.row by the signs of the direction. */
#define MESH_ROWS(x, y, z)                                                                         \
    {                                                                                              \
        x * 3 * PEN_WIDE, (1 + y * 3) * PEN_WIDE, (2 + z * 3) * PEN_WIDE, (3 - x * 3) * PEN_WIDE,  \
            (4 - y * 3) * PEN_WIDE, (5 - z * 3) * PEN_WIDE                                         \
    }
static const size_t mesh_rows[8][6] = {MESH_ROWS(0, 0, 0), MESH_ROWS(1, 0, 0), MESH_ROWS(0, 1, 0),
                                       MESH_ROWS(1, 1, 0), MESH_ROWS(0, 0, 1), MESH_ROWS(1, 0, 1),
                                       MESH_ROWS(0, 1, 1), MESH_ROWS(1, 1, 1)};

/* An origin that is still farther away than MESH_FAR after it has moved has MESH_OFF_MAX as bound
 * of its errors, which is greater than everything that is compared with it. */
#define MESH_FAR 0x1p40
#define MESH_OFF_MAX 0x1p60f

/* Numbers that floats can hold: a bound of errors, and a coordinate of an origin. */
static inline float mesh_bound(float x)
{
    return x < MESH_OFF_MAX ? x : MESH_OFF_MAX;
}

static inline float mesh_coordinate(double x)
{
    const double low = x > -MESH_FAR ? x : -MESH_FAR;
    return (float)(low < MESH_FAR ? low : MESH_FAR);
}

/* Moves a far origin along the ray, to a place before the ball of radius 2 extent around 0, which
 * contains the box of this half side. *moved is the depth by which it has moved. Returns false if
 * the ray does not come near the box. `off` bounds what the sums are off by. */
static inline bool mesh_move_near(const struct mesh_box *box, double4 *o, double *moved,
                                  double extent, double off)
{
    const double4 d = box->d, od = *o * d;
    const double reach = 2 * extent + off, middle = -(od[0] + od[1] + od[2]) * box->inv_dd;
    if (!(middle > -reach))
        return false;
    *moved = middle > reach ? middle - reach : 0;
    *o += *moved * d;
    /* Of a ray that enters the box grown by off < extent, less than 5.4 extent + 3.4 off. */
    return double4_largest(o) <= 10 * extent;
}

/* The origin in floats. */
static inline float4 mesh_at(const double4 *o)
{
    return THREE(__builtin_convertvector(*o, float4));
}

/* How far an intersection may be outside the box of a triangle, or of any primitive if there are
 * others (pen_prim_bounds). */
static inline float mesh_outside(float distance, bool others)
{
    return others ? 0x1p-23f * distance : 0x1p-38f * distance;
}

/* Moves the origin, which is far from a tree of this extent. Returns false if the ray misses it. */
static __attribute__((noinline)) bool mesh_box_move(struct mesh_box *box, float4 *at, double extent,
                                                    double grow, bool others)
{
    const double far = double4_largest(&box->o);
    box->distance = far < (double)MESH_OFF_MAX ? (float)far : MESH_OFF_MAX;
    const double rest = (double)mesh_outside(box->distance + (float)extent, others) + grow;
    box->blind = rest >= extent && far > MESH_FAR;
    if (rest < extent && !mesh_move_near(box, &box->o, &box->moved, extent, rest))
        return false;
    *at = (float4){mesh_coordinate(box->o[0]), mesh_coordinate(box->o[1]),
                   mesh_coordinate(box->o[2]), 0};
    return true;
}

/* Sets the planes for an origin. `off`: how far boxes have to be grown. */
static inline void mesh_box_planes(struct mesh_box *box, float4 at, float off)
{
    const float4 least = {0x1p-60f, 0x1p-60f, 0x1p-60f, 1};
    const mask4 sign = (mask4)box->direction & INT32_MIN;
    const float4 size = 1.0f / float4_max((float4)((mask4)box->direction ^ sign), least);
    const float4 inv = (float4)((mask4)size ^ sign), back = -(at * inv), margin = off * size,
                 near = back - margin, far = back + margin;
    box->row = mesh_rows[float4_signs(box->direction) & 7];
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) {
        box->inv[axis] = SPLAT8(inv[axis]);
        box->near[axis] = SPLAT8(near[axis]);
        box->far[axis] = SPLAT8(far[axis]);
    }
}

_Static_assert(offsetof(struct pen_ray, d) == 3 * sizeof(double) &&
                   sizeof(struct pen_ray) >= 7 * sizeof(double),
               "o and d are read with one number more");

/* Makes a ray for boxes of a tree of this extent, for a query from t = `start` on; false if it does
 * not come near the tree. `others`: the tree has primitives that are not in meshes. */
static inline bool mesh_box_make(struct mesh_box *box, const struct pen_ray *ray, double extent,
                                 double grow, bool others, double start)
{
    uint64_t bits;
    double inv;
    memcpy(&bits, &ray->permuted_d.z, sizeof bits);
    bits &= 0x7ff0000000000000u;
    memcpy(&box->scale, &bits, sizeof bits);
    bits = (UINT64_C(2046) << 52) - bits;
    memcpy(&inv, &bits, sizeof inv);
    box->o = *(const double4 *)&ray->o.x;
    box->d = *(const double4 *)&ray->d.x * inv;
    box->direction = THREE(__builtin_convertvector(box->d, float4));
    box->inv_dd = ray->inv_dd * box->scale * box->scale;
    box->moved = 0;
    box->blind = false;
    float4 at = mesh_at(&box->o);
    float far = float4_largest(at);
    box->distance = far;
    if (far > 4 * (float)extent) {
        if (!mesh_box_move(box, &at, extent, grow, others))
            return false;
        far = float4_largest(at);
    }
    const float off = 0x1p-20f * (far + (float)extent) +
                      (mesh_outside(box->distance, others) + (float)grow) * (1 + 0x1p-20f);
    mesh_box_planes(box, at, box->blind ? MESH_OFF_MAX : off);
    box->start = box->blind ? -FLT_MAX : pen_float_down(start * box->scale - box->moved);
    return true;
}

/* The depth of t, or above it by less than an ulp. */
static inline float mesh_box_depth(const struct mesh_box *box, double t)
{
    return box->blind ? FLT_MAX : pen_float_up(t * box->scale - box->moved);
}

/* Which boxes of a node the ray enters before `limit`, as bits, and at which depth at least. */
static inline unsigned mesh_enter_node(const struct pen_node *node, const struct mesh_box *box,
                                       float limit, float near[PEN_WIDE])
{
    float8 t0 = SPLAT8(box->start), t1 = SPLAT8(limit);
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) {
        raise8f(&t0, (const float *)node->plane + box->row[axis], &box->inv[axis],
                &box->near[axis]);
        lower8f(&t1, (const float *)node->plane + box->row[3 + axis], &box->inv[axis],
                &box->far[axis]);
    }
    *(float8 *)near = t0;
    const mask8 in = t0 <= t1;
    return mask8_bits(&in);
}

#endif
