/* SPDX-License-Identifier: MIT */
/* Soft shadows: the mean transmittance of shadow rays to points of a light's disk, which faces the
 * shaded point. The rays are taken together where they can (pen/accel/fan.h), else one by one; the
 * sum is the same to the bit, since it is made in the order of the points. */
#ifndef SHADE_SOFT_H
#define SHADE_SOFT_H

#include "pen/math/frame.h"
#include "points.h"
#include "shadow.h"

/* The samples of one light from one point. */
struct soft {
    const struct surface *s;
    const struct lit *lit;
    struct pen_leave leave; /* of rays that stay above the horizon */
    struct points points;
    struct pen_vec3 sum; /* of transmittances */
    uint32_t count, rays;
};

/* A light's disk is perpendicular to the direction to it; that of a directional one is at unit
 * distance. */
static ALWAYS_INLINE void soft_disk(struct pen_fan *fan, const struct pen_light *light,
                                    struct pen_vec3 to_light)
{
    struct pen_vec3 n = light->kind == PEN_LIGHT_DIRECTIONAL ? to_light : pen_normalize(to_light);
    struct pen_across across = pen_across(n);
    fan->c = to_light;
    fan->u = pen_scale(across.u, light->radius);
    fan->v = pen_scale(across.v, light->radius);
}

/* Adds the sample at a point of the unit disk by itself. One below the horizon is reached through
 * the surface, which takes its share first, or all of it. */
static ALWAYS_INLINE void soft_add(const struct pen_kernel_input *input,
                                   struct pen_kernel_scratch *scratch, struct soft *soft,
                                   struct pen_point2 at, const unsigned fx)
{
    const struct surface *s = soft->s;
    struct shadow_way way = {.d = pen_fan_way(&scratch->fan, at.x, at.y),
                             .to_point = soft->lit->to_point,
                             .light = soft->lit->light};
    way.through = !(pen_dot(s->n, way.d) > 0);
    way.in = way.through ? s->material->kt : pen_vec3(1, 1, 1);
    if (way.through && (!(fx & PEN_FX_SHADOW_TRANSMITTANCE) || is_black(way.in)))
        return;
    soft->rays++;
    uint32_t *last = &scratch->last_occluder[way.light], before = *last;
    soft->sum = pen_add(soft->sum, shadow_ray(input, scratch, s, &way, fx));
    if (*last == PEN_NO_PRIM)
        *last = before; /* what blocked one sample may block the next but one */
}

/* All samples, one by one. */
static ALWAYS_INLINE void soft_add_singly(const struct pen_kernel_input *input,
                                          struct pen_kernel_scratch *scratch, struct soft *soft,
                                          const unsigned fx)
{
    double a[PEN_FAN_RAYS], b[PEN_FAN_RAYS];
    for (int n; (n = points_fill(&soft->points, a, b)) > 0; soft->count += (uint32_t)n) {
        for (int i = 0; i < n; i++)
            soft_add(input, scratch, soft, (struct pen_point2){a[i], b[i]}, fx);
    }
}

/* Whether all of the disk is above the horizon, by more than rounding. */
static ALWAYS_INLINE bool soft_above(const struct pen_fan *fan, struct pen_vec3 n)
{
    double c = pen_dot(n, fan->c), u = pen_dot(n, fan->u), v = pen_dot(n, fan->v);
    double size = pen_norm1(fan->c) + pen_norm1(fan->u) + pen_norm1(fan->v);
    return c > sqrt(u * u + v * v) + 0x1p-40 * size;
}

static ALWAYS_INLINE enum pen_fan_fate soft_fan(const struct pen_kernel_input *input,
                                                struct pen_kernel_scratch *scratch,
                                                struct soft *soft, const unsigned fx)
{
    struct pen_fan *fan = &scratch->fan;
    uint32_t *last = &scratch->last_occluder[soft->lit->light];
    if (!input->trace->fan_begin || !soft_above(fan, soft->s->n))
        return PEN_FAN_NONE;
    fan->o = soft->s->p;
    fan->leave = &soft->leave;
    fan->to_point = soft->lit->to_point;
    fan->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? input->scene->see_through : NULL;
    fan->last_occluder = *last;
    enum pen_fan_fate fate = input->trace->fan_begin(input->scene->accel, fan);
    *last = fan->last_occluder;
    return fate;
}

/* What arrives along ray i of the fan. */
static ALWAYS_INLINE struct pen_vec3 soft_ask(const struct pen_kernel_input *input,
                                              struct pen_kernel_scratch *scratch,
                                              const struct soft *soft, int i, struct pen_vec3 d,
                                              const unsigned fx)
{
    const struct pen_vec3 none = {0, 0, 0}, clear = {1, 1, 1};
    struct pen_shadow *query = &scratch->shadow;
    struct pen_ray ray;
    if (!pen_ray_make(&ray, soft->s->p, d))
        return none;
    shadow_query(input, query, soft->lit->to_point, fx);
    if (input->trace->fan_ray(input->scene->accel, &scratch->fan, &ray, i, query))
        return none;
    return shadow_colour(input, &ray, &soft->leave, query, clear, fx);
}

static ALWAYS_INLINE void soft_add_fan(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, struct soft *soft,
                                       const unsigned fx)
{
    double a[PEN_FAN_RAYS] = {0}, b[PEN_FAN_RAYS] = {0};
    const struct pen_vec3 clear = {1, 1, 1};
    for (int n; (n = points_fill(&soft->points, a, b)) > 0; soft->count += (uint32_t)n) {
        uint64_t ask, blocked = input->trace->fan_look(&scratch->fan, a, b, n, &ask);
        for (int i = 0; i < n; i++) {
            if (blocked >> i & 1)
                continue;
            struct pen_vec3 t = clear;
            if (ask >> i & 1)
                t = soft_ask(input, scratch, soft, i, pen_fan_way(&scratch->fan, a[i], b[i]), fx);
            soft->sum = pen_add(soft->sum, t);
        }
    }
    soft->rays = soft->count;
}

/* T(p) of a light with a disk. */
static ALWAYS_INLINE struct pen_vec3
soft_transmittance(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   const struct surface *s, const struct lit *lit, struct pen_ray_counts *counts,
                   const unsigned fx)
{
    struct soft soft = {.s = s, .lit = lit, .leave = surface_leave(s, false)};
    soft_disk(&scratch->fan, &input->scene->lights[lit->light], lit->to_light);
    scratch->key.light = input->scene->light_index[lit->light];
    soft.points = points_begin(input->settings, pen_sample_hash(&scratch->key));
    enum pen_fan_fate fate = soft_fan(input, scratch, &soft, fx);
    if (fate == PEN_FAN_OPEN || fate == PEN_FAN_SHUT) {
        double t = fate == PEN_FAN_OPEN;
        counts->shadow += points_count(&soft.points);
        return pen_vec3(t, t, t);
    }
    if (fate == PEN_FAN_MIXED)
        soft_add_fan(input, scratch, &soft, fx);
    else
        soft_add_singly(input, scratch, &soft, fx);
    counts->shadow += soft.rays;
    double points = soft.count;
    return pen_vec3(soft.sum.x / points, soft.sum.y / points, soft.sum.z / points);
}

#endif
