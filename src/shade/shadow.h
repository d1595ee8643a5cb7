/* SPDX-License-Identifier: MIT */
/* The transmittance of a shadow ray: nothing, everything, or the colours of the sheets it crosses
 * multiplied in the order it crosses them. */
#ifndef SHADE_SHADOW_H
#define SHADE_SHADOW_H

#include "light.h"

static ALWAYS_INLINE struct pen_vec3 shadow_filter(const struct pen_scene *scene, uint32_t prim,
                                                   struct pen_vec3 t)
{
    return pen_mul(t, scene->materials[scene->prim_material[prim]].kt);
}

/* Walks a ray that crosses more sheets than a query returns at once. */
struct pen_vec3 pen_shadow_walk(const struct pen_kernel_input *input, const struct pen_ray *ray,
                                const struct pen_leave *leave, const struct pen_shadow *query);

/* T(p) of light number `light`. */
static ALWAYS_INLINE struct pen_vec3 shadow_transmittance(const struct pen_kernel_input *input,
                                                          struct pen_kernel_scratch *scratch,
                                                          const struct surface *s,
                                                          const struct lit *lit, uint32_t light,
                                                          const unsigned fx)
{
    struct pen_vec3 t = {1, 1, 1};
    const struct pen_vec3 none = {0, 0, 0};
    const struct pen_scene *scene = input->scene;
    struct pen_ray ray;
    if (!pen_ray_make(&ray, s->p, lit->to_light))
        return none;
    struct pen_leave leave = surface_leave(s);
    struct pen_shadow *query = &scratch->shadow;
    query->tmax = lit->to_point ? 1 : INFINITY;
    query->to_point = lit->to_point;
    query->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? scene->see_through : NULL;
    query->last_occluder = scratch->last_occluder[light];
    bool blocked = input->trace->shadow(scene->accel, &ray, &leave, query);
    scratch->last_occluder[light] = query->last_occluder;
    if (blocked)
        return none;
    if (!(fx & PEN_FX_SHADOW_TRANSMITTANCE))
        return t;
    if (query->overflow)
        return pen_shadow_walk(input, &ray, &leave, query);
    for (int i = 0; i < query->count; i++)
        t = shadow_filter(scene, query->hit[i].prim, t);
    return t;
}

#endif
