/* SPDX-License-Identifier: MIT */
/* The secondary rays from a surface: the reflected one, and the one transmitted straight through.
 */
#ifndef PEN_SHADE_INTERNAL_SECONDARY_RAYS_H
#define PEN_SHADE_INTERNAL_SECONDARY_RAYS_H

#include "shade/internal/surface.h"

/* Whether a path continues: it ends when its weight is 0, or below min_contribution, in all
 * channels. */
static ALWAYS_INLINE bool path_contributes(const struct pen_kernel_input *input, struct pen_vec3 w)
{
    double least = input->settings->min_contribution;
    return (w.x > 0 && w.x >= least) || (w.y > 0 && w.y >= least) || (w.z > 0 && w.z >= least);
}

/* Whether rounding cannot mirror the viewer's ray to the other side of a surface. */
static ALWAYS_INLINE lane_mask surface_mirrors(const struct surface *s)
{
    return lanes_less(lanes_splat(PEN_HORIZON_SINE), -s->nv) &
           lane_mask_not(surface_viewer_grazes(s));
}

/* Makes the reflected path, a new ray from a point of s. False if its weight is too small, or if
 * the viewer grazes the surface: rounding may then mirror the ray to the other side.
 * pen_ray_make accepts the ray: p is finite, and n and v are finite and of length 1, hence so is
 * their mirror image. */
static ALWAYS_INLINE bool path_reflect(const struct pen_kernel_input *input,
                                       const struct path *path, const struct surface *s, int lane,
                                       struct path *reflected, const unsigned fx)
{
    struct pen_vec3 weight = pen_mul(path->weight, input->scene->materials[s->material[lane]].kr);
    if (!path_contributes(input, weight) || !(lane_mask_bits(surface_mirrors(s)) >> lane & 1))
        return false;
    struct lanes3 d = lanes3_along(s->v, s->n, -2 * s->nv);
    if (!pen_ray_make(&reflected->ray, lanes3_at(s->p, lane), lanes3_at(d, lane)))
        return false;
    reflected->origin = surface_origin(s, lane, false);
    reflected->after = pen_after_start;
    reflected->weight = weight;
    reflected->depth = path->depth + 1;
    if (fx & PEN_FX_SOFT_SHADOWS)
        reflected->node = pen_sample_node(path->node, true);
    return true;
}

/* Continues the path through the surface: the same ray, after this intersection. False if its
 * weight is too small. */
static ALWAYS_INLINE bool path_transmit(const struct pen_kernel_input *input, struct path *path,
                                        const struct surface *s, int lane, const unsigned fx)
{
    struct pen_vec3 weight = pen_mul(path->weight, input->scene->materials[s->material[lane]].kt);
    if (!path_contributes(input, weight))
        return false;
    path->after = s->hit[lane];
    path->weight = weight;
    path->depth++;
    if (fx & PEN_FX_SOFT_SHADOWS)
        path->node = pen_sample_node(path->node, false);
    return true;
}

#endif
