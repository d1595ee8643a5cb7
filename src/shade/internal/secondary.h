/* SPDX-License-Identifier: MIT */
/* The rays that go on from a surface: the mirrored one, and the one that goes straight through. */
#ifndef PEN_SHADE_INTERNAL_SECONDARY_H
#define PEN_SHADE_INTERNAL_SECONDARY_H

#include "shade/internal/surface.h"

/* A path ends when its weight is 0, or below min_contribution, in all channels. */
static ALWAYS_INLINE bool path_worth(const struct pen_kernel_input *input, struct pen_vec3 w)
{
    double least = input->settings->min_contribution;
    return (w.x > 0 && w.x >= least) || (w.y > 0 && w.y >= least) || (w.z > 0 && w.z >= least);
}

/* Makes the mirrored path, a new ray from p. False if there is nothing to trace. The ray cannot be
 * refused: p is finite, and so are n and v, of length 1, hence their mirror image is of length 1.
 */
static ALWAYS_INLINE bool path_mirror(const struct pen_kernel_input *input, const struct path *path,
                                      const struct surface *s, struct path *mirrored,
                                      const unsigned fx)
{
    struct pen_vec3 weight = pen_mul(path->weight, s->material->kr);
    if (!path_worth(input, weight))
        return false;
    struct pen_vec3 d = pen_along(s->v, s->n, -2 * s->nv);
    if (!pen_ray_make(&mirrored->ray, s->p, d))
        return false;
    mirrored->origin = surface_origin(s, false);
    mirrored->after = pen_after_start;
    mirrored->weight = weight;
    mirrored->depth = path->depth + 1;
    if (fx & PEN_FX_SOFT_SHADOWS)
        mirrored->node = pen_sample_node(path->node, true);
    return true;
}

/* Takes the path on through the surface: the same ray, beyond this crossing. */
static ALWAYS_INLINE bool path_transmit(const struct pen_kernel_input *input, struct path *path,
                                        const struct surface *s, const unsigned fx)
{
    struct pen_vec3 weight = pen_mul(path->weight, s->material->kt);
    if (!path_worth(input, weight))
        return false;
    path->after = s->hit;
    path->weight = weight;
    path->depth++;
    if (fx & PEN_FX_SOFT_SHADOWS)
        path->node = pen_sample_node(path->node, false);
    return true;
}

#endif
