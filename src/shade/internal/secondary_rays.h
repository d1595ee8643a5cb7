/* SPDX-License-Identifier: MIT */
/* The secondary rays from a surface: the reflected ray, and the transmitted ray, which goes
 * straight through or is refracted. */
#ifndef PEN_SHADE_INTERNAL_SECONDARY_RAYS_H
#define PEN_SHADE_INTERNAL_SECONDARY_RAYS_H

#include "geom/ray_lanes.h"
#include "shade/internal/refraction.h"

/* Whether a path continues. It ends when its weight is 0, or below min_contribution, in all
 * channels. */
static ALWAYS_INLINE bool path_contributes(const struct pen_kernel_input *input, struct pen_vec3 w)
{
    double least = input->settings->min_contribution;
    return (w.x > 0 && w.x >= least) || (w.y > 0 && w.y >= least) || (w.z > 0 && w.z >= least);
}

/* The factor of the weight of reflected paths: kr, plus with refraction Fresnel's share of kt.
 * `bend` is set in kernels with refraction. */
static ALWAYS_INLINE struct lanes3 reflected_factors(const struct surface *s,
                                                     const struct pen_scene *scene,
                                                     const struct refraction *bend,
                                                     const unsigned fx)
{
    if (fx & PEN_FX_REFRACTION)
        return lanes3_load(bend->reflected);
    return surface_colours(s, scene, offsetof(struct pen_material, kr), fx);
}

static ALWAYS_INLINE struct pen_vec3 reflected_factor(const struct surface *s,
                                                      const struct pen_scene *scene,
                                                      const struct refraction *bend, int lane,
                                                      const unsigned fx)
{
    if (fx & PEN_FX_REFRACTION)
        return bend->reflected[lane];
    return surface_material(s, scene, lane, fx)->kr;
}

/* Whether rounding certainly does not mirror the viewer's ray to the other side of a surface. */
static ALWAYS_INLINE lane_mask surface_mirrors(const struct surface *s)
{
    return lanes_less(lanes_splat(PEN_HORIZON_SINE), -s->nv) &
           lane_mask_not(surface_viewer_grazes(s));
}

/* The points of s that reflect their path, as bits. A point does so if the path's weight is large
 * enough and the viewer does not graze the surface. At a grazing angle rounding could mirror the
 * ray to the other side. */
static ALWAYS_INLINE unsigned paths_reflected(const struct pen_kernel_input *input,
                                              const struct surface *s,
                                              const struct refraction *bend,
                                              const struct path *const *path, int count,
                                              const unsigned fx)
{
    const struct pen_scene *scene = input->scene;
    const lane_mask mirrors = lane_mask_not(lanes_black(reflected_factors(s, scene, bend, fx)));
    unsigned reflected = 0;
    if (!lane_mask_bits(mirrors))
        return 0;
    unsigned left = lane_mask_bits(mirrors & surface_mirrors(s)) & LANES_ALL >> (LANES - count);
    for (; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        if (path_contributes(input,
                             pen_mul(path[i]->weight, reflected_factor(s, scene, bend, i, fx))))
            reflected |= 1u << i;
    }
    return reflected;
}

/* Makes the reflected paths of the points that reflect, in *reflected[lane]. Returns the points
 * that have one, which are all of them: p is finite, and n and v are finite and of length 1, hence
 * so is their mirror image. */
static ALWAYS_INLINE unsigned paths_reflect(const struct pen_kernel_input *input,
                                            const struct surface *s, const struct refraction *bend,
                                            unsigned points, const struct path *const *path,
                                            struct path *const *reflected, const unsigned fx)
{
    struct pen_ray *ray[LANES], nowhere;
    for (int i = 0; i < LANES; i++) {
        ray[i] = points >> i & 1 ? &reflected[i]->ray : &nowhere;
        if (!(points >> i & 1))
            continue;
        reflected[i]->origin = surface_origin(s, i, false);
        reflected[i]->after = pen_after_start;
        reflected[i]->weight =
            pen_mul(path[i]->weight, reflected_factor(s, input->scene, bend, i, fx));
        reflected[i]->depth = path[i]->depth + 1;
        if (fx & FX_BLUR)
            reflected[i]->share = path[i]->share;
        if (fx & FX_SAMPLED)
            reflected[i]->node = pen_sample_node(path[i]->node, true);
    }
    const struct lanes3 d = lanes3_along(s->v, s->n, -2 * s->nv);
    return points & lane_mask_bits(lanes_ray_make(ray, s->p, d));
}

/* Continues the path through the surface: with the same ray, after this intersection, or with the
 * refracted ray. Returns false if its weight is too small. */
static ALWAYS_INLINE bool path_transmit(const struct pen_kernel_input *input, struct path *path,
                                        const struct surface *s, const struct refraction *bend,
                                        int lane, const unsigned fx)
{
    struct pen_vec3 weight = pen_mul(
        path->weight, fx & PEN_FX_REFRACTION ? bend->transmitted[lane]
                                             : surface_material(s, input->scene, lane, fx)->kt);
    if (!path_contributes(input, weight))
        return false;
    if ((fx & PEN_FX_REFRACTION) && !(bend->straight >> lane & 1))
        refraction_turn(bend, s, lane, path);
    else
        path->after = s->hit[lane];
    path->weight = weight;
    path->depth++;
    if (fx & FX_SAMPLED)
        path->node = pen_sample_node(path->node, false);
    return true;
}

#endif
