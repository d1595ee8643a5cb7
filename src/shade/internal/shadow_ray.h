/* SPDX-License-Identifier: MIT */
/* The transmittance of one shadow ray: black if an opaque surface occludes the light. Else it is
 * the product of kt over the surfaces that the ray intersects, in the order of the intersections.
 */
#ifndef PEN_SHADE_INTERNAL_SHADOW_RAY_H
#define PEN_SHADE_INTERNAL_SHADOW_RAY_H

#include "shade/internal/unshadowed_light.h"

/* A shadow ray from a shaded point, before it is traced. */
struct shadow_ray {
    struct pen_vec3 d;
    bool to_point;      /* it ends in the light at o + d; else it is infinite */
    bool through;       /* it starts on the side of the surface away from the viewer */
    uint32_t light;     /* number in the frozen scene */
    struct pen_vec3 in; /* its transmittance at the start */
};

static ALWAYS_INLINE struct pen_vec3 shadow_filter(const struct pen_scene *scene, uint32_t prim,
                                                   struct pen_vec3 t)
{
    return pen_mul(t, pen_scene_material(scene, prim)->kt);
}

/* The same at the hit of a ray on the primitive, whose kt may be a pattern. */
static ALWAYS_INLINE struct pen_vec3 shadow_filter_at(const struct pen_scene *scene,
                                                      const struct pen_ray *ray,
                                                      const struct pen_origin_surface *origin,
                                                      struct pen_hit hit, struct pen_vec3 t,
                                                      const unsigned fx)
{
    if (fx & PEN_FX_PATTERNS)
        return pen_mul(t, pen_filter_at(scene, ray, origin, hit));
    return shadow_filter(scene, hit.prim, t);
}

/* The transmittance of a ray with more transmissive intersections than a query returns. It traces
 * from one intersection to the next. */
struct pen_vec3 pen_shadow_walk(const struct pen_kernel_input *input, const struct pen_ray *ray,
                                const struct pen_origin_surface *origin,
                                const struct pen_shadow *query, struct pen_vec3 in);

/* Fills in a query for a shadow ray. */
static ALWAYS_INLINE void shadow_query(const struct pen_kernel_input *input,
                                       struct pen_shadow *query, bool to_point, const unsigned fx)
{
    query->tmax = to_point ? 1 : INFINITY;
    query->to_point = to_point;
    query->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? input->scene->see_through : NULL;
    query->last_occluder = PEN_NO_PRIM;
}

/* The transmittance of a ray that starts with `in`, if the query found it not blocked. */
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
        in = shadow_filter_at(input->scene, ray, origin, query->hit[i], in, fx);
    return in;
}

/* Traces a shadow ray from a point of s and returns its transmittance. Stores the primitive that
 * blocked it as the last occluder of its light. */
static ALWAYS_INLINE struct pen_vec3 trace_shadow_ray(const struct pen_kernel_input *input,
                                                      struct pen_kernel_scratch *scratch,
                                                      const struct surface *s, int lane,
                                                      const struct shadow_ray *shadow,
                                                      const unsigned fx)
{
    const struct pen_vec3 none = {0, 0, 0};
    struct pen_ray ray;
    if (!pen_ray_make(&ray, lanes3_at(s->p, lane), shadow->d))
        return no_sample(); /* the light is farther than rays reach */
    const struct pen_origin_surface through = surface_origin(s, lane, true);
    const struct pen_origin_surface *origin = shadow->through ? &through : &s->origin[lane];
    struct pen_shadow *query = &scratch->shadow;
    shadow_query(input, query, shadow->to_point, fx);
    query->last_occluder = scratch->last_occluder[shadow->light];
    bool blocked = input->trace->shadow(input->scene->accel, &ray, origin, query);
    scratch->last_occluder[shadow->light] = query->last_occluder;
    return blocked ? none : shadow_colour(input, &ray, origin, query, shadow->in, fx);
}

/* T(p) of a light without a radius: one ray to its centre. */
static ALWAYS_INLINE struct pen_vec3 hard_transmittance(const struct pen_kernel_input *input,
                                                        struct pen_kernel_scratch *scratch,
                                                        const struct surface *s, int lane,
                                                        const struct arriving_light *arriving,
                                                        const unsigned fx)
{
    const struct shadow_ray shadow = {.d = lanes3_at(arriving->to_light, lane),
                                      .to_point = arriving->to_point,
                                      .light = arriving->light,
                                      .in = {1, 1, 1}};
    return trace_shadow_ray(input, scratch, s, lane, &shadow, fx);
}

#endif
