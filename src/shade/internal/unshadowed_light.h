/* SPDX-License-Identifier: MIT */
/* The light that a surface reflects to its viewer if nothing occludes the light source: intensity,
 * attenuation, beam, and the diffuse and specular terms (kd and ks); see src/shade/README.md. */
#ifndef PEN_SHADE_INTERNAL_UNSHADOWED_LIGHT_H
#define PEN_SHADE_INTERNAL_UNSHADOWED_LIGHT_H

#include "math/fn.h"
#include "shade/internal/horizon.h"

/* What one light contributes at a surface. */
struct arriving_light {
    struct pen_vec3 term;     /* unshadowed: I (kd |n.l| + ks ...); black if nothing arrives */
    struct pen_vec3 to_light; /* from p: to the light, or against a directional light's direction */
    bool to_point;            /* to_light ends in the light; else it is only a direction */
    uint32_t light;           /* number in the frozen scene */
};

/* The share of the arriving light that the material reflects to the viewer:
 * kd |n.l| + ks max(0, -v.r)^shininess, with r = l - 2 (n.l) n, so that -v.r = 2 (n.l)(n.v) - v.l.
 * Rounding may lift -v.r above 1, which a large power would amplify, so it is clamped to 1. */
static ALWAYS_INLINE struct pen_vec3
light_towards_viewer(const struct surface *s, struct pen_vec3 l, double nl, const unsigned fx)
{
    const struct pen_material *m = s->material;
    struct pen_vec3 share = pen_scale(m->kd, -nl);
    if (!(fx & PEN_FX_SPECULAR) || is_black(m->ks))
        return share;
    double mirror = 2 * nl * s->nv - pen_dot(s->v, l);
    double highlight = pen_pow(mirror < 1 ? mirror : 1, m->shininess);
    return pen_add(share, pen_scale(m->ks, highlight));
}

static ALWAYS_INLINE struct pen_vec3
light_of_directional(const struct pen_light *light, const struct surface *s, const unsigned fx)
{
    double nl = pen_dot(s->n, light->direction);
    if (horizon_side_of(-nl, horizon_band(s, 1, false)) != HORIZON_ABOVE)
        return pen_vec3(0, 0, 0);
    return pen_mul(light->intensity, light_towards_viewer(s, light->direction, nl, fx));
}

static ALWAYS_INLINE struct pen_vec3 light_of_positional(const struct pen_light *light,
                                                         const struct surface *s, struct pen_vec3 q,
                                                         const unsigned fx)
{
    const struct pen_vec3 black = {0, 0, 0};
    double nq = pen_dot(s->n, q);
    if (!(nq < -s->origin.bound))
        return black;
    double d = pen_length(q);
    if (horizon_side_of(-nq, horizon_band(s, d, true)) != HORIZON_ABOVE)
        return black;
    struct pen_vec3 l = pen_scale(q, 1 / d);
    double beam = 1;
    if (light->beam) {
        double cosine = pen_dot(light->direction, l);
        if (!(cosine > 0))
            return black;
        beam = pen_pow(cosine < 1 ? cosine : 1, light->beam_exponent);
    }
    double falloff = light->kc + d * (light->kl + d * light->kq);
    struct pen_vec3 intensity = pen_scale(light->intensity, beam / falloff);
    return pen_mul(intensity, light_towards_viewer(s, l, nq / d, fx));
}

/* For a surface that the viewer sees from one side: surface_lit. */
static ALWAYS_INLINE struct arriving_light
light_unshadowed(const struct pen_light *light, const struct surface *s, const unsigned fx)
{
    struct arriving_light arriving = {.term = {0, 0, 0}};
    if (!light->positional) {
        arriving.term = light_of_directional(light, s, fx);
        arriving.to_light = pen_neg(light->direction);
        return arriving;
    }
    struct pen_vec3 q = pen_sub(s->p, light->position);
    arriving.term = light_of_positional(light, s, q, fx);
    arriving.to_light = pen_neg(q);
    arriving.to_point = true;
    return arriving;
}

#endif
