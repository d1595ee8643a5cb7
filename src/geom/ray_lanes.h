/* SPDX-License-Identifier: MIT */
/* Rays made LANES at a time. pen_ray_make is the same code with one lane (ray.c). */
#ifndef PEN_GEOM_RAY_LANES_H
#define PEN_GEOM_RAY_LANES_H

#include <stddef.h>

#include "geom/ray_array.h"
#include "math/lanes.h"

static inline lanes lanes_without_less(lanes x, lanes least)
{
    const lanes zero = lanes_of_words(lanes_words(x) & UINT64_C(1) << 63);
    return lanes_select(lanes_less(lanes_abs(x), least), zero, x);
}

/* pen_without_less, for numbers that are not NaN. */
static inline struct lanes3 lanes3_without_less(struct lanes3 v, lanes least)
{
    const lanes x = lanes_abs(v.x), y = lanes_abs(v.y), z = lanes_abs(v.z);
    if (!lane_mask_bits(lanes_less(lanes_min(lanes_min(x, y), z), least)))
        return v;
    return (struct lanes3){lanes_without_less(v.x, least), lanes_without_less(v.y, least),
                           lanes_without_less(v.z, least)};
}

/* The lanes whose kz is 0, and those whose kz is 1. */
struct lanes_axes {
    lane_mask x, y;
};

/* pen_permuted, for lanes whose axes may differ. */
static inline struct lanes3 lanes3_permuted(struct lanes_axes kz, struct lanes3 v)
{
    return (struct lanes3){lanes_select(kz.x, v.y, lanes_select(kz.y, v.z, v.x)),
                           lanes_select(kz.x, v.z, lanes_select(kz.y, v.x, v.y)),
                           lanes_select(kz.x, v.x, lanes_select(kz.y, v.y, v.z))};
}

/* Permutes the axes of *o and *d. In the usual case all lanes have the same axes. */
static inline void lanes_ray_permute(struct lanes_axes kz, struct lanes3 *o, struct lanes3 *d)
{
    const unsigned x = lane_mask_bits(kz.x), y = lane_mask_bits(kz.y);
    if (x == LANES_ALL) {
        *o = (struct lanes3){o->y, o->z, o->x};
        *d = (struct lanes3){d->y, d->z, d->x};
    } else if (y == LANES_ALL) {
        *o = (struct lanes3){o->z, o->x, o->y};
        *d = (struct lanes3){d->z, d->x, d->y};
    } else if (x | y) {
        *o = lanes3_permuted(kz, *o);
        *d = lanes3_permuted(kz, *d);
    }
}

/* Whether pen_ray_make succeeds for o and d; `largest` is the size of d's largest component. */
static inline lane_mask lanes_ray_can_be(struct lanes3 o, struct lanes3 d, lanes largest)
{
    /* 0, or NaN where something is not finite. */
    const lanes nothing = ((o.x + d.x) * 0 + (o.y + d.y) * 0) + (o.z + d.z) * 0;
    return lanes_equal(nothing, lanes_splat(0)) & lanes_at_most(largest, lanes_splat(0x1p400)) &
           lanes_at_most(lanes_splat(0x1p-400), largest);
}

/* Writes rows of four numbers of struct pen_ray, from number `first` on. */
static inline void lanes_ray_write(struct pen_ray *const *ray, int first, lanes a, lanes b, lanes c,
                                   lanes d)
{
    double *to[LANES];
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++)
        to[i] = (double *)ray[i] + first;
    lanes_store_rows(to, a, b, c, d);
}

/* Rays in lanes: the numbers of struct pen_ray. */
struct lanes_ray {
    struct lanes3 o, d, permuted_o, permuted_d;
    lanes inv_dd, sx, sy, sz, near;
    struct lanes_axes kz;
};

/* pen_ray_make. Returns the lanes in which it succeeds; the rays of the others are undefined. It is
 * always inlined, because callers use some of the numbers, and a call would store all of them. */
static inline __attribute__((always_inline)) lane_mask
lanes_ray_of(struct lanes_ray *ray, struct lanes3 o, struct lanes3 d)
{
    const lanes ax = lanes_abs(d.x), ay = lanes_abs(d.y), az = lanes_abs(d.z);
    /* Of two equal components, the first in the order z, x, y. */
    const lane_mask x_before_y = lanes_at_most(ay, ax);
    const struct lanes_axes kz = {x_before_y & lanes_less(az, ax),
                                  lane_mask_not(x_before_y) & lanes_at_most(az, ay)};
    const lanes largest = lanes_select(kz.x, ax, lanes_select(kz.y, ay, az));
    const lane_mask made = lanes_ray_can_be(o, d, largest);
    d = lanes3_without_less(d, PEN_LEAST_DIRECTION * largest);
    o = lanes3_without_less(o, lanes_splat(PEN_LEAST));
    struct lanes3 po = o, pd = d;
    lanes_ray_permute(kz, &po, &pd);
    const lanes sx = pd.x / pd.z, sy = pd.y / pd.z;
    /* Quotients of unequal doubles do not round to 1, so a ray with one below 1 is not tied. */
    const lane_mask untied = lanes_less(lanes_abs(sx * sy), lanes_splat(1));
    *ray = (struct lanes_ray){
        .o = o,
        .d = d,
        .permuted_o = po,
        .permuted_d = pd,
        .inv_dd = 1.0 / lanes3_dot(pd, pd),
        .sx = sx,
        .sy = sy,
        .sz = 1.0 / pd.z,
        .near = lanes_select(untied, lanes_splat(PEN_NEAR), lanes_splat(INFINITY)),
        .kz = kz,
    };
    return made;
}

_Static_assert(offsetof(struct pen_ray, d) == 3 * sizeof(double) &&
                   offsetof(struct pen_ray, inv_dd) == 6 * sizeof(double) &&
                   offsetof(struct pen_ray, sz) == 9 * sizeof(double) &&
                   offsetof(struct pen_ray, permuted_o) == 10 * sizeof(double) &&
                   offsetof(struct pen_ray, permuted_d) == 13 * sizeof(double),
               "lanes_ray_put writes the numbers of a ray in this order");

/* Writes rays to *to[lane]. Every to[lane] must be writable. */
static inline void lanes_ray_put(const struct lanes_ray *rays, struct pen_ray *const *to)
{
    const struct lanes_ray r = *rays;
    const unsigned x = lane_mask_bits(r.kz.x), y = lane_mask_bits(r.kz.y);
    double near[LANES];
    lanes_ray_write(to, 0, r.o.x, r.o.y, r.o.z, r.d.x);
    lanes_ray_write(to, 4, r.d.y, r.d.z, r.inv_dd, r.sx);
    lanes_ray_write(to, 8, r.sy, r.sz, r.permuted_o.x, r.permuted_o.y);
    lanes_ray_write(to, 12, r.permuted_o.z, r.permuted_d.x, r.permuted_d.y, r.permuted_d.z);
    lanes_store(near, r.near);
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++) {
        int axis[3];
        pen_ray_axes(x >> i & 1 ? 0 : y >> i & 1 ? 1 : 2, axis);
        to[i]->near = near[i];
        to[i]->kx = axis[0];
        to[i]->ky = axis[1];
        to[i]->kz = axis[2];
    }
}

/* As lanes_ray_of, with results in *to[lane]. */
static inline lane_mask lanes_ray_make(struct pen_ray *const *to, struct lanes3 o, struct lanes3 d)
{
    struct lanes_ray r;
    const lane_mask made = lanes_ray_of(&r, o, d);
    lanes_ray_put(&r, to);
    return made;
}

/* Sets LANES rays of the array, from i on, as pen_ray_array_set. */
static inline void lanes_ray_array_put(const struct lanes_ray *rays, struct pen_ray_array *to,
                                       int i)
{
    const struct lanes_ray r = *rays;
    lanes_store(to->o[0] + i, r.permuted_o.x);
    lanes_store(to->o[1] + i, r.permuted_o.y);
    lanes_store(to->o[2] + i, r.permuted_o.z);
    lanes_store(to->d[0] + i, r.permuted_d.x);
    lanes_store(to->d[1] + i, r.permuted_d.y);
    lanes_store(to->d[2] + i, r.permuted_d.z);
    lanes_store(to->sx + i, r.sx);
    lanes_store(to->sy + i, r.sy);
    lanes_store(to->inv_dd + i, r.inv_dd);
    lanes_store(to->near + i, r.near);
    to->along_x |= (uint64_t)lane_mask_bits(r.kz.x) << i;
    to->along_y |= (uint64_t)lane_mask_bits(r.kz.y) << i;
    to->forward |= (uint64_t)lane_mask_bits(lanes_less(lanes_splat(0), r.permuted_d.z)) << i;
}

/* As lanes_ray_of, with results in the rays of the array from i on. */
static inline __attribute__((always_inline)) lane_mask
lanes_ray_array_make(struct pen_ray_array *to, int i, struct lanes3 o, struct lanes3 d)
{
    struct lanes_ray r;
    const lane_mask made = lanes_ray_of(&r, o, d);
    lanes_ray_array_put(&r, to, i);
    return made;
}

#endif
