/* SPDX-License-Identifier: MIT */
/* Light that arrives at a point if nothing is in its way: intensity, attenuation, beam, and the
 * share that the surface sends on to the viewer (the terms with kd and ks). */
#ifndef PEN_SHADE_INTERNAL_LIGHT_H
#define PEN_SHADE_INTERNAL_LIGHT_H

#include "math/fn.h"
#include "shade/internal/surface.h"

/* What one light brings to a surface. */
struct lit {
    struct pen_vec3 term;     /* unshadowed: I (kd |n.l| + ks ...); black if nothing arrives */
    struct pen_vec3 to_light; /* from p: to the light, or against the direction of a far one */
    bool to_point;            /* to_light ends in the light */
    uint32_t light;           /* number in the frozen scene */
};

/* The part of the light that the material sends on: kd |n.l| + ks max(0, -v.r)^shininess, with
 * r = l - 2 (n.l) n, so that -v.r = 2 (n.l)(n.v) - v.l. Rounding may lift that above 1, where a
 * large power would make much of it: it is cut. */
static ALWAYS_INLINE struct pen_vec3 light_sent_on(const struct surface *s, struct pen_vec3 l,
                                                   double nl, const unsigned fx)
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
    if (!(nl < 0))
        return pen_vec3(0, 0, 0);
    return pen_mul(light->intensity, light_sent_on(s, light->direction, nl, fx));
}

/* A light within rounding of the surface's plane is on neither side of it. */
static ALWAYS_INLINE struct pen_vec3 light_of_point(const struct pen_light *light,
                                                    const struct surface *s, struct pen_vec3 q,
                                                    const unsigned fx)
{
    const struct pen_vec3 black = {0, 0, 0};
    double nq = pen_dot(s->n, q);
    if (!(nq < -s->origin.bound))
        return black;
    double d = pen_length(q);
    struct pen_vec3 l = pen_scale(q, 1 / d);
    double beam = 1;
    if (light->kind == PEN_LIGHT_SPOT) {
        double cosine = pen_dot(light->direction, l);
        if (!(cosine > 0))
            return black;
        beam = pen_pow(cosine < 1 ? cosine : 1, light->beam_exponent);
    }
    double falloff = light->kc + d * (light->kl + d * light->kq);
    struct pen_vec3 arriving = pen_scale(light->intensity, beam / falloff);
    return pen_mul(arriving, light_sent_on(s, l, nq / d, fx));
}

static ALWAYS_INLINE struct lit light_unshadowed(const struct pen_light *light,
                                                 const struct surface *s, const unsigned fx)
{
    struct lit lit = {.term = {0, 0, 0}};
    if (!(s->nv < 0))
        return lit; /* the viewer is in the surface's plane, on no side of it */
    if (light->kind == PEN_LIGHT_DIRECTIONAL) {
        lit.term = light_of_directional(light, s, fx);
        lit.to_light = pen_neg(light->direction);
        return lit;
    }
    struct pen_vec3 q = pen_sub(s->p, light->position);
    lit.term = light_of_point(light, s, q, fx);
    lit.to_light = pen_neg(q);
    lit.to_point = true;
    return lit;
}

#endif
