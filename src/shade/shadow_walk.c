/* SPDX-License-Identifier: MIT */
/* The rare shadow ray through more transmissive surfaces than a query returns. It is traced from
 * one intersection to the next, by the rules of the query: strictly before the light, and not on a
 * surface that contains the light. */
#include "shade/internal/shadow_ray.h"

struct pen_vec3 pen_shadow_walk(const struct pen_kernel_input *input, const struct pen_ray *ray,
                                const struct pen_origin_surface *origin,
                                const struct pen_shadow *query, struct pen_vec3 in)
{
    const struct pen_scene *scene = input->scene;
    struct pen_vec3 t = in;
    struct pen_t_interval interval = {pen_after_start, query->tmax};
    struct pen_hit hit;
    double light = pen_ray_end_bound(ray->o, ray->d);
    while (!is_black(t) && input->trace->nearest(scene->accel, ray, origin, &interval, &hit)) {
        interval.after = hit;
        if (query->to_point && pen_prim_ends_ray(&scene->prims, hit, ray, query->tmax, light))
            continue;
        t = shadow_filter_at(scene, ray, origin, hit, t, PEN_FX_PATTERNS);
    }
    return t;
}
