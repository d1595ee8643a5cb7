/* SPDX-License-Identifier: MIT */
/* A ray in the coordinates of a mesh, in binary32, and the bounds of what rounding does to the test
 * of a block of triangles. src/accel/README.md derives them. */
#ifndef PEN_ACCEL_INTERNAL_MESH_RAY_H
#define PEN_ACCEL_INTERNAL_MESH_RAY_H

#include "accel/internal/mesh_lanes.h"
#include "accel/internal/prim_test.h"

/* The point at depth x is o + x d. Depth x is t = (x + moved) / scale. */
struct mesh_ray {
    float o[3], d[3];
    double moved, scale, inv_scale;
    bool misses; /* the ray does not come near the mesh */
    /* Of a triangle of size L, the sum of its edges along the axes plus `size`: */
    float size;                /* three times what a vertex may be off by, beside the line */
    float beside;              /* L * beside: what edge functions are off by */
    float depth;               /* L * L * depth: what the product of depth and d.n is off by */
    float across, across_size; /* L * (across * L + across_size): what d.n is off by */
};

/* Sets d to the ray's direction over a power of two, so that its largest component is in [1, 2).
 * Returns that power. */
static inline double mesh_direction(const struct pen_ray *ray, double d[3])
{
    const double power = box_scale(ray);
    uint64_t bits;
    double inv;
    memcpy(&bits, &power, sizeof bits);
    bits = (UINT64_C(2046) << 52) - bits;
    memcpy(&inv, &bits, sizeof inv);
    d[0] = ray->d.x * inv;
    d[1] = ray->d.y * inv;
    d[2] = ray->d.z * inv;
    return power;
}

static inline double mesh_largest(const double v[3])
{
    const double x = fabs(v[0]), y = fabs(v[1]), z = fabs(v[2]), m = x > y ? x : y;
    return m > z ? m : z;
}

/* Moves a far origin along the ray to the ball of radius 2 extent around 0, which contains the box
 * of this half side. Returns the depth by which it has moved. *misses: the line does not come near
 * the box. `off` bounds what the sums are off by. */
static inline double move_near(double o[3], const double d[3], double extent, double off,
                               bool *misses)
{
    const double dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    const double middle = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / dd;
    const double by = middle - (2 * extent + off) / sqrt(dd);
    *misses = !(by > 0);
    if (*misses)
        return 0;
    for (int i = 0; i < 3; i++)
        o[i] = fma(by, d[i], o[i]);
    *misses = mesh_largest(o) > 8 * extent;
    return by;
}

/* Numbers that floats can hold: a bound of errors, and a coordinate of an origin. An origin that is
 * still farther away than MESH_FAR after it has been moved has the largest bound, which is greater
 * than everything that is compared with it. */
#define MESH_FAR 0x1p40
#define MESH_OFF_MAX 0x1p60

static inline float mesh_bound(double x)
{
    return (float)(x < MESH_OFF_MAX ? x : MESH_OFF_MAX);
}

static inline float mesh_coordinate(double x)
{
    const double low = x > -MESH_FAR ? x : -MESH_FAR;
    return (float)(low < MESH_FAR ? low : MESH_FAR);
}

/* `off`: how far rounding, in the local frame, and the self-intersection rule reach. */
static inline void mesh_ray_make(struct mesh_ray *to, const struct pen_mesh *mesh,
                                 const struct pen_mesh_frame *frame, const struct pen_ray *ray,
                                 double off)
{
    double o[3], d[3];
    const double extent = frame->extent, longest = (double)frame->longest;
    const double power = mesh_direction(ray, d);
    o[0] = (ray->o.x - mesh->shift.x) * frame->inv_unit;
    o[1] = (ray->o.y - mesh->shift.y) * frame->inv_unit;
    o[2] = (ray->o.z - mesh->shift.z) * frame->inv_unit;
    double far = mesh_largest(o);
    const double round = 0x1p-48 * (far + extent);
    double rest = round + frame->rounding + off * frame->inv_unit;
    to->scale = power * frame->inv_unit;
    to->inv_scale = frame->unit / power;
    to->moved = 0;
    to->misses = false;
    if (far > 4 * extent && rest < extent) {
        to->moved = move_near(o, d, extent, round, &to->misses);
        far = mesh_largest(o);
    }
    if (far > MESH_FAR)
        rest = MESH_OFF_MAX;
    const double size = (far + extent) * (1 + 0x1p-20), vertex = 0x1p-23 * size + rest;
    const double steepest = fabs(pen_component(ray->d, ray->kz)) / power;
    for (int i = 0; i < 3; i++) {
        to->o[i] = mesh_coordinate(o[i]);
        to->d[i] = (float)d[i];
    }
    to->size = mesh_bound(3 * vertex);
    to->beside = mesh_bound(steepest * (0x1p-24 * (56 * size + 10 * longest) + 16 * rest));
    to->depth = mesh_bound(0x1p-24 * (48 * size + 10 * longest) + 20 * rest);
    to->across = (float)(steepest * 0x1p-21);
    to->across_size = mesh_bound(8 * steepest * vertex);
}

/* What the test of blocks tells. Lanes are bits. */
struct mesh_lanes {
    unsigned may;    /* not certainly missed */
    unsigned sure;   /* of these: certainly entered, ahead of the origin, between lo and hi */
    unsigned before; /* of these: certainly before `limit`, and off the point there */
    float lo[MESH_LANES], hi[MESH_LANES];
};

static inline struct floats3 mesh_corners(const struct pen_mesh4 *a, const struct pen_mesh4 *b,
                                          int i)
{
    return (struct floats3){floats_load(a->v[i][0], b->v[i][0]),
                            floats_load(a->v[i][1], b->v[i][1]),
                            floats_load(a->v[i][2], b->v[i][2])};
}

/* Tests MESH_BLOCKS blocks, of one mesh. `limit`: depths beyond it do not matter. */
static inline __attribute__((always_inline)) void mesh_ray_test(const struct mesh_ray *ray,
                                                                const struct pen_mesh4 *one,
                                                                const struct pen_mesh4 *two,
                                                                float limit, struct mesh_lanes *out)
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
    const floats beside = size * ray->beside, least = floats_min(floats_min(u, v), w);
    const masks may = least >= -beside;
    out->may = masks_bits(may);
    out->sure = out->before = 0;
    if (!out->may)
        return;
    const floats height = floats_turned(floats3_dot(n, t), sign), off = size * size * ray->depth;
    const floats dull =
        size * floats_fma(size, floats_splat(ray->across), floats_splat(ray->across_size));
    const masks tells = steep > 8.0f * dull;
    const floats inv = 1.0f / steep, lo = (height - 1.25f * off) * inv,
                 hi = (height + 1.25f * off) * inv;
    const floats low = lo - floats_abs(lo) * 0x1p-21f;
    const masks ahead = height > 2.0f * off, behind = height < -2.0f * off;
    const masks missed = tells & (behind | (ahead & (low > limit)));
    out->may = masks_bits(may & ~missed);
    out->sure = out->may & masks_bits((least > beside) & tells & ahead);
    out->before = out->sure & masks_bits((limit * (1 - 0x1p-21f)) * steep - height > 3.0f * off);
    *(floats *)out->lo = (floats)(((masks)low & tells) | ((masks)floats_splat(-INFINITY) & ~tells));
    *(floats *)out->hi = hi + floats_abs(hi) * 0x1p-21f;
}

#endif
