/* SPDX-License-Identifier: MIT */
/* Points and the light at them, for kernels without any effect but ambient and specular light:
 * src/shade/internal/surface.h and unshadowed_light.h, without patterns and refraction. Code of
 * these headers that belongs to no effect is used from there. */
#ifndef TESTS_EFFECTS_STRIPPED_POINTS_H
#define TESTS_EFFECTS_STRIPPED_POINTS_H

#include "shade/internal/unshadowed_light.h"

static ALWAYS_INLINE struct lanes3 point_colours(const struct surface *s,
                                                 const struct pen_scene *scene, size_t sort)
{
    return lanes3_rows((const struct pen_vec3 *)((const char *)scene->materials + sort),
                       MATERIAL_DOUBLES, s->material);
}

static ALWAYS_INLINE void point_materials(struct surface *s, const struct pen_scene *scene,
                                          int count)
{
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++)
        s->material[i] = i < count ? pen_scene_material_of(scene, s->hit[i].prim) : 0;
    s->kd = point_colours(s, scene, offsetof(struct pen_material, kd));
    s->ks = point_colours(s, scene, offsetof(struct pen_material, ks));
    s->shininess = lanes_rows(&scene->materials->shininess, MATERIAL_DOUBLES, s->material);
}

static ALWAYS_INLINE void points_at(struct surface *s, const struct pen_scene *scene,
                                    const struct path *const *path, int count)
{
    struct lanes3 d;
    point_materials(s, scene, count);
    const struct lanes_arrived ray = surface_rays(s, path, count, &d);
    const struct lanes_prim_point at =
        surface_points(s, scene, path, count, lanes3_along(ray.o, d, ray.t));
    s->p = at.p;
    s->n = at.n;
    s->v = lanes3_normalize(d);
    s->nv = lanes3_dot(s->n, s->v);
    surface_keep_in_outlines(s, &scene->prims, path, count);
    const struct lanes_origin origin = lanes_origin_at(&ray, s->p, at.scale);
    s->bound = origin.bound;
    surface_set_origins(s, &origin);
    const lane_mask outside = surface_seen_from_outside(s, scene, path, count);
    s->n = lanes3_select(outside, s->n, lanes3_neg(s->n));
    s->nv = lanes_select(outside, s->nv, -s->nv);
    s->nv = lanes_select(lanes_less(lanes_splat(0), s->nv), lanes_splat(0), s->nv);
    const lanes turn = s->bound * at.curvature;
    s->grazing_sine = surface_grazing_sine(turn, outside);
    s->unsure = surface_unsure(turn, outside);
    s->corner = lane_mask_of(0);
    if (path[0]->depth > 0) {
        s->corner = surface_met_within(&ray, CORNER_BOUNDS * s->bound) |
                    lanes_at_most(-s->nv, lanes_splat(PEN_HORIZON_SINE));
        s->unsure =
            lanes_select(surface_hardly_left(&ray, s->bound), lanes_splat(INFINITY), s->unsure);
    }
    s->finite = lane_mask_of((1u << count) - 1) &
                lanes_less(lanes_abs(s->nv - s->bound), lanes_splat(INFINITY));
}

static ALWAYS_INLINE struct lanes3 emitted(const struct pen_scene *scene, const struct surface *s,
                                           bool primary)
{
    const struct lanes3 emission = point_colours(s, scene, offsetof(struct pen_material, emission));
    if (!primary)
        return emission;
    const struct lanes3 ka = point_colours(s, scene, offsetof(struct pen_material, ka));
    return lanes3_add(emission, lanes3_mul(lanes3_splat(scene->ambient), ka));
}

static ALWAYS_INLINE struct lanes3 towards_viewer(const struct surface *s, struct lanes3 l,
                                                  lanes nl, lane_mask above)
{
    const struct lanes3 share = lanes3_scale(s->kd, -nl);
    const lane_mask shines = above & lane_mask_not(lanes_black(s->ks));
    if (!lane_mask_bits(shines))
        return share;
    const lanes mirror = 2 * nl * s->nv - lanes3_dot(s->v, l);
    const lanes highlight = lanes_pow(lanes_min(mirror, lanes_splat(1)), s->shininess);
    return lanes3_select(shines, lanes3_add(share, lanes3_scale(s->ks, highlight)), share);
}

static ALWAYS_INLINE void directional(struct arriving_light *arriving,
                                      const struct pen_light *light, const struct surface *s)
{
    const struct lanes3 l = lanes3_splat(light->direction);
    const lanes nl = lanes3_dot(s->n, l);
    arriving->to_light = lanes3_neg(l);
    arriving->arrives &= horizon_sides(-nl, horizon_band(s, lanes_splat(1), false)).above;
    if (lane_mask_bits(arriving->arrives))
        arriving->term =
            lanes3_mul(lanes3_splat(light->intensity), towards_viewer(s, l, nl, arriving->arrives));
}

static ALWAYS_INLINE void positional(struct arriving_light *arriving, const struct pen_light *light,
                                     const struct surface *s)
{
    const struct lanes3 q = lanes3_sub(s->p, lanes3_splat(light->position));
    const lanes nq = lanes3_dot(s->n, q);
    arriving->to_light = lanes3_neg(q);
    arriving->arrives &= lanes_less(nq, -s->bound);
    if (!lane_mask_bits(arriving->arrives))
        return;
    const lanes d = lanes3_length(q);
    arriving->arrives &= horizon_sides(-nq, horizon_band(s, d, true)).above;
    if (!lane_mask_bits(arriving->arrives))
        return;
    const struct lanes3 l = lanes3_scale(q, 1 / d);
    lanes beam = lanes_splat(1);
    if (light->beam) {
        const lanes cosine = lanes3_dot(lanes3_splat(light->direction), l);
        arriving->arrives &= lanes_less(lanes_splat(0), cosine);
        if (!lane_mask_bits(arriving->arrives))
            return;
        beam = lanes_pow(lanes_min(cosine, lanes_splat(1)), lanes_splat(light->beam_exponent));
    }
    const lanes falloff = light->kc + d * (light->kl + d * light->kq);
    const struct lanes3 intensity = lanes3_scale(lanes3_splat(light->intensity), beam / falloff);
    arriving->term = lanes3_mul(intensity, towards_viewer(s, l, nq / d, arriving->arrives));
}

static ALWAYS_INLINE void unshadowed(struct arriving_light *arriving, const struct pen_light *light,
                                     const struct surface *s, lane_mask lit)
{
    arriving->arrives = lit;
    arriving->to_point = light->positional;
    if (light->positional)
        positional(arriving, light, s);
    else
        directional(arriving, light, s);
    if (lane_mask_bits(arriving->arrives))
        arriving->arrives &= lane_mask_not(lanes_black(arriving->term));
}

#endif
