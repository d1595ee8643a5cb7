/* SPDX-License-Identifier: MIT */
/* The transmittance of a shadow ray: nothing, everything, or the colours of the sheets it crosses
 * multiplied in the order it crosses them. */
#ifndef PEN_SHADE_INTERNAL_SHADOW_H
#define PEN_SHADE_INTERNAL_SHADOW_H

#include "shade/internal/light.h"

/* A shadow ray from a shaded point. */
struct shadow_way {
    struct pen_vec3 d;
    bool to_point;      /* it ends in the light at o + d; else it has no end */
    bool through;       /* it leaves on the other side of the surface than the viewer's */
    uint32_t light;     /* number in the frozen scene */
    struct pen_vec3 in; /* what it carries when it leaves */
};

static ALWAYS_INLINE struct pen_vec3 shadow_filter(const struct pen_scene *scene, uint32_t prim,
                                                   struct pen_vec3 t)
{
    return pen_mul(t, scene->materials[scene->prim_material[prim]].kt);
}

/* Walks a ray that crosses more sheets than a query returns at once. */
struct pen_vec3 pen_shadow_walk(const struct pen_kernel_input *input, const struct pen_ray *ray,
                                const struct pen_origin_surface *origin,
                                const struct pen_shadow *query, struct pen_vec3 in);

/* What a query of the kernel's asks for. */
static ALWAYS_INLINE void shadow_query(const struct pen_kernel_input *input,
                                       struct pen_shadow *query, bool to_point, const unsigned fx)
{
    query->tmax = to_point ? 1 : INFINITY;
    query->to_point = to_point;
    query->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? input->scene->see_through : NULL;
    query->last_occluder = PEN_NO_PRIM;
}

/* What arrives of `in` along a ray that the query found not blocked. */
static ALWAYS_INLINE struct pen_vec3 shadow_colour(const struct pen_kernel_input *input,
                                                   const struct pen_ray *ray,
                                                   const struct pen_origin_surface *origin,
                                                   const struct pen_shadow *query,
                                                   struct pen_vec3 in, const unsigned fx)
{
    if (!(fx & PEN_FX_SHADOW_TRANSMITTANCE))
        return in;
    if (query->overflow)
        return pen_shadow_walk(input, ray, origin, query, in);
    for (int i = 0; i < query->count && !is_black(in); i++)
        in = shadow_filter(input->scene, query->hit[i].prim, in);
    return in;
}

/* What arrives of what the ray carries. The primitive that blocked it is remembered for its light.
 */
static ALWAYS_INLINE struct pen_vec3
shadow_ray(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
           const struct surface *s, const struct shadow_way *direction, const unsigned fx)
{
    const struct pen_vec3 none = {0, 0, 0};
    struct pen_ray ray;
    if (!pen_ray_make(&ray, s->p, direction->d))
        return no_sample(); /* the light is farther than rays go */
    struct pen_origin_surface origin = surface_origin(s, direction->through);
    struct pen_shadow *query = &scratch->shadow;
    shadow_query(input, query, direction->to_point, fx);
    query->last_occluder = scratch->last_occluder[direction->light];
    bool blocked = input->trace->shadow(input->scene->accel, &ray, &origin, query);
    scratch->last_occluder[direction->light] = query->last_occluder;
    return blocked ? none : shadow_colour(input, &ray, &origin, query, direction->in, fx);
}

/* T(p) of a light without a disk: one ray. */
static ALWAYS_INLINE struct pen_vec3 hard_transmittance(const struct pen_kernel_input *input,
                                                        struct pen_kernel_scratch *scratch,
                                                        const struct surface *s,
                                                        const struct lit *lit, const unsigned fx)
{
    const struct shadow_way direction = {
        .d = lit->to_light, .to_point = lit->to_point, .light = lit->light, .in = {1, 1, 1}};
    return shadow_ray(input, scratch, s, &direction, fx);
}

#endif
