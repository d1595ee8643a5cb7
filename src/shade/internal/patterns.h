/* SPDX-License-Identifier: MIT */
/* Colours that depend on the place: checkers and gradients, in the object's own coordinates. */
#ifndef PEN_SHADE_INTERNAL_PATTERNS_H
#define PEN_SHADE_INTERNAL_PATTERNS_H

#include "scene/scene.h"

/* The material of a primitive at its point p in the local frame, which is known to `bound`. */
struct pen_material pen_material_at(const struct pen_scene *scene, uint32_t prim, struct pen_vec3 p,
                                    double bound);

static inline bool prim_is_patterned(const struct pen_scene *scene, uint32_t prim)
{
    return pen_scene_material(scene, prim)->patterns != NULL;
}

/* Its kt at the hit of a ray. */
struct pen_vec3 pen_filter_at(const struct pen_scene *scene, const struct pen_ray *ray,
                              const struct pen_origin_surface *origin, struct pen_hit hit);

#endif
