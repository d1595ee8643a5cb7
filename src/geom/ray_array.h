/* SPDX-License-Identifier: MIT */
/* Up to 64 rays as arrays. Ray packets read LANES of them at a time (math/lanes.h). */
#ifndef PEN_GEOM_RAY_ARRAY_H
#define PEN_GEOM_RAY_ARRAY_H

#include "geom/ray.h"

enum { PEN_RAY_ARRAY_MAX = 64 };

/* The numbers of struct pen_ray, by ray. The axes of o and d are in the ray's own order, as
 * pen_permuted. Each mask has one bit per ray. */
struct pen_ray_array {
    double o[3][PEN_RAY_ARRAY_MAX], d[3][PEN_RAY_ARRAY_MAX];
    double sx[PEN_RAY_ARRAY_MAX], sy[PEN_RAY_ARRAY_MAX];
    double inv_dd[PEN_RAY_ARRAY_MAX], near[PEN_RAY_ARRAY_MAX];
    uint64_t along_x, along_y; /* kz is 0; kz is 1; it is 2 for all other rays */
    uint64_t forward;          /* d[kz] is positive */
};

/* Sets the axes of a ray with this kz. */
static inline void pen_ray_axes(int kz, int axis[3])
{
    axis[0] = kz == 2 ? 0 : kz + 1;
    axis[1] = kz == 0 ? 2 : kz - 1;
    axis[2] = kz;
}

/* Begins an array without rays. Each ray is set once. */
static inline void pen_ray_array_begin(struct pen_ray_array *to)
{
    to->along_x = to->along_y = to->forward = 0;
}

static inline void pen_ray_array_set(struct pen_ray_array *to, int i, const struct pen_ray *ray)
{
    to->o[0][i] = ray->permuted_o.x;
    to->o[1][i] = ray->permuted_o.y;
    to->o[2][i] = ray->permuted_o.z;
    to->d[0][i] = ray->permuted_d.x;
    to->d[1][i] = ray->permuted_d.y;
    to->d[2][i] = ray->permuted_d.z;
    to->sx[i] = ray->sx;
    to->sy[i] = ray->sy;
    to->inv_dd[i] = ray->inv_dd;
    to->near[i] = ray->near;
    to->along_x |= (uint64_t)(ray->kz == 0) << i;
    to->along_y |= (uint64_t)(ray->kz == 1) << i;
    to->forward |= (uint64_t)(ray->permuted_d.z > 0) << i;
}

static inline int pen_ray_array_kz(const struct pen_ray_array *rays, int i)
{
    return rays->along_x >> i & 1 ? 0 : rays->along_y >> i & 1 ? 1 : 2;
}

/* Restores the ray that pen_ray_make made, to the bit. */
static inline void pen_ray_array_get(const struct pen_ray_array *from, int i, struct pen_ray *ray)
{
    int axis[3];
    pen_ray_axes(pen_ray_array_kz(from, i), axis);
    for (int k = 0; k < 3; k++) {
        ((double *)&ray->o)[axis[k]] = ((double *)&ray->permuted_o)[k] = from->o[k][i];
        ((double *)&ray->d)[axis[k]] = ((double *)&ray->permuted_d)[k] = from->d[k][i];
    }
    ray->inv_dd = from->inv_dd[i];
    ray->sx = from->sx[i];
    ray->sy = from->sy[i];
    ray->sz = 1.0 / ray->permuted_d.z;
    ray->near = from->near[i];
    ray->kx = axis[0];
    ray->ky = axis[1];
    ray->kz = axis[2];
}

#endif
