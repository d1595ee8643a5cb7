/* SPDX-License-Identifier: MIT */
/* The light that a surface reflects to its viewer if nothing occludes the light source: intensity,
 * attenuation, beam, and the diffuse and specular terms (kd and ks). See src/shade/README.md. */
#ifndef PEN_SHADE_INTERNAL_UNSHADOWED_LIGHT_H
#define PEN_SHADE_INTERNAL_UNSHADOWED_LIGHT_H

#include "math/lanes_fn.h"
#include "shade/internal/horizon.h"

/* The radiance that the points send to the viewer without a light: emission, and ambient light if
 * the rays are primary. */
static ALWAYS_INLINE struct lanes3 light_emitted(const struct pen_scene *scene,
                                                 const struct surface *s, bool primary,
                                                 const unsigned fx)
{
    const struct lanes3 emission =
        surface_colours(s, scene, offsetof(struct pen_material, emission), fx);
    if (!(fx & PEN_FX_AMBIENT) || !primary)
        return emission;
    const struct lanes3 ka = surface_colours(s, scene, offsetof(struct pen_material, ka), fx);
    return lanes3_add(emission, lanes3_mul(lanes3_splat(scene->ambient), ka));
}

/* The contribution of one light at the points of a surface. */
struct arriving_light {
    lane_mask arrives;  /* some light arrives if nothing occludes the light */
    struct lanes3 term; /* unshadowed: I (kd |n.l| + ks ...) */
    /* From p to the light, or opposite to a directional light's direction. */
    struct lanes3 to_light;
    bool to_point;  /* to_light ends in the light; else it is a direction */
    uint32_t light; /* number in the frozen scene */
};

/* n.q for the shading normal; `nq` is that of the surface's own normal. From -q, light arrives only
 * above the horizon of both. */
static ALWAYS_INLINE lanes light_on_shading_normal(struct arriving_light *arriving,
                                                   const struct surface *s, struct lanes3 q,
                                                   lanes nq, lanes band, const unsigned fx)
{
    if (!surface_is_smooth(s, fx))
        return nq;
    const lanes shading_q = lanes3_dot(s->shading, q);
    arriving->arrives &= horizon_sides(-shading_q, band).above;
    return shading_q;
}

/* The share of the arriving light that the material reflects to the viewer: kd |n.l| + ks max(0,
 * -v.r)^shininess, with r = l - 2 (n.l) n, so that -v.r = 2 (n.l)(n.v) - v.l. Here n is the shading
 * normal. Rounding may lift -v.r above 1, which a large power would amplify, so it is limited to 1.
 */
static ALWAYS_INLINE struct lanes3 light_towards_viewer(const struct surface *s, struct lanes3 l,
                                                        lanes nl, lane_mask above,
                                                        const unsigned fx)
{
    const struct lanes3 share = lanes3_scale(s->kd, -nl);
    if (!(fx & PEN_FX_SPECULAR))
        return share;
    const lane_mask shines = above & lane_mask_not(lanes_black(s->ks));
    if (!lane_mask_bits(shines))
        return share;
    const lanes nv = surface_is_smooth(s, fx) ? s->shading_v : s->nv;
    const lanes mirror = 2 * nl * nv - lanes3_dot(s->v, l);
    const lanes highlight = lanes_pow(lanes_min(mirror, lanes_splat(1)), s->shininess);
    return lanes3_select(shines, lanes3_add(share, lanes3_scale(s->ks, highlight)), share);
}

static ALWAYS_INLINE void light_of_directional(struct arriving_light *arriving,
                                               const struct pen_light *light,
                                               const struct surface *s, const unsigned fx)
{
    const struct lanes3 l = lanes3_splat(light->direction);
    const lanes band = horizon_band(s, lanes_splat(1), false);
    lanes nl = lanes3_dot(s->n, l);
    arriving->to_light = lanes3_neg(l);
    arriving->arrives &= horizon_sides(-nl, band).above;
    nl = light_on_shading_normal(arriving, s, l, nl, band, fx);
    if (lane_mask_bits(arriving->arrives))
        arriving->term = lanes3_mul(lanes3_splat(light->intensity),
                                    light_towards_viewer(s, l, nl, arriving->arrives, fx));
}

static ALWAYS_INLINE void light_of_positional(struct arriving_light *arriving,
                                              const struct pen_light *light,
                                              const struct surface *s, const unsigned fx)
{
    const struct lanes3 q = lanes3_sub(s->p, lanes3_splat(light->position));
    lanes nq = lanes3_dot(s->n, q);
    arriving->to_light = lanes3_neg(q);
    arriving->arrives &= lanes_less(nq, -s->bound);
    if (!lane_mask_bits(arriving->arrives))
        return;
    const lanes d = lanes3_length(q);
    const lanes band = horizon_band(s, d, true);
    arriving->arrives &= horizon_sides(-nq, band).above;
    nq = light_on_shading_normal(arriving, s, q, nq, band, fx);
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
    arriving->term =
        lanes3_mul(intensity, light_towards_viewer(s, l, nq / d, arriving->arrives, fx));
}

/* Computes the contribution of one light at the points `lit` of a surface (surface_lit), which the
 * viewer sees from one side. */
static ALWAYS_INLINE void light_unshadowed(struct arriving_light *arriving,
                                           const struct pen_light *light, const struct surface *s,
                                           lane_mask lit, const unsigned fx)
{
    arriving->arrives = lit;
    arriving->to_point = light->positional;
    if (light->positional)
        light_of_positional(arriving, light, s, fx);
    else
        light_of_directional(arriving, light, s, fx);
    if (lane_mask_bits(arriving->arrives))
        arriving->arrives &= lane_mask_not(lanes_black(arriving->term));
}

#endif
