/* SPDX-License-Identifier: MIT */
/* Soft shadows: the mean transmittance of shadow rays to points of a light's disk, which faces the
 * shaded point. The rays are taken together where they can (accel/fan.h), else one by one; the
 * sum is the same to the bit, since it is made in the order of the points. */
#ifndef PEN_SHADE_INTERNAL_SOFT_H
#define PEN_SHADE_INTERNAL_SOFT_H

#include "math/frame.h"
#include "shade/internal/points.h"
#include "shade/internal/shadow.h"

/* The samples of one light from one point. */
struct soft {
    const struct surface *s;
    const struct lit *lit;
    struct pen_leave leave; /* of rays that stay above the horizon */
    struct points points;
    struct pen_vec3 sum; /* of transmittances */
    bool whole;          /* it is a whole number */
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
    struct point_list list;
    for (int n; (n = points_fill(&soft->points, &list)) > 0; soft->count += (uint32_t)n) {
        for (int i = 0; i < n; i++)
            soft_add(input, scratch, soft, (struct pen_point2){list.a[i], list.b[i]}, fx);
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
        return no_sample();
    shadow_query(input, query, soft->lit->to_point, fx);
    if (input->trace->fan_ray(input->scene->accel, &scratch->fan, &ray, i, query))
        return none;
    return shadow_colour(input, &ray, &soft->leave, query, clear, fx);
}

/* What arrives of ray i, which crosses bodies no more than twice in all. */
static ALWAYS_INLINE struct pen_vec3 soft_tint(const struct pen_kernel_input *input,
                                               const struct pen_fan *fan, int i)
{
    struct pen_vec3 t = {1, 1, 1};
    for (int k = 0; k < fan->tints; k++) {
        const struct pen_gate *gate = &fan->gate[fan->tint[k]];
        if ((gate->once | gate->twice) >> i & 1)
            t = shadow_filter(input->scene, gate->prim, t);
        if (gate->twice >> i & 1)
            t = shadow_filter(input->scene, gate->prim, t);
    }
    return t;
}

/* Whether all rays of `open` cross the same bodies. */
static ALWAYS_INLINE bool soft_uniform(const struct pen_fan *fan, uint64_t open)
{
    for (int k = 0; k < fan->tints; k++) {
        uint64_t once = fan->gate[fan->tint[k]].once & open;
        uint64_t twice = fan->gate[fan->tint[k]].twice & open;
        if ((once && once != open) || (twice && twice != open))
            return false;
    }
    return true;
}

/* Adds rays one after the other, and each asked or coloured by itself. */
static ALWAYS_INLINE void soft_add_each(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, struct soft *soft,
                                        const struct point_list *list, uint64_t open, uint64_t ask,
                                        const unsigned fx)
{
    struct pen_fan *fan = &scratch->fan;
    for (; open; open &= open - 1) {
        int i = __builtin_ctzll(open);
        struct pen_vec3 t;
        if (ask >> i & 1)
            t = soft_ask(input, scratch, soft, i, pen_fan_way(fan, list->a[i], list->b[i]), fx);
        else
            t = soft_tint(input, fan, i);
        soft->sum = pen_add(soft->sum, t);
    }
}

/* Adds the rays of a list. Sums of ones have no rounding, and need not be made one by one. */
static ALWAYS_INLINE void soft_add_list(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, struct soft *soft,
                                        const struct point_list *list, const unsigned fx)
{
    struct pen_fan *fan = &scratch->fan;
    uint64_t all = list->count < 64 ? (UINT64_C(1) << list->count) - 1 : UINT64_MAX, ask;
    uint64_t open = all & ~input->trace->fan_look(fan, list->a, list->b, list->count, &ask);
    if (!open)
        return;
    if (ask || !soft_uniform(fan, open)) {
        soft->whole = false;
        soft_add_each(input, scratch, soft, list, open, ask, fx);
        return;
    }
    struct pen_vec3 t = soft_tint(input, fan, __builtin_ctzll(open));
    int rays = __builtin_popcountll(open);
    soft->whole = soft->whole && t.x == 1 && t.y == 1 && t.z == 1;
    if (soft->whole)
        soft->sum = pen_add(soft->sum, pen_vec3(rays, rays, rays));
    else
        for (int i = 0; i < rays; i++)
            soft->sum = pen_add(soft->sum, t);
}

static ALWAYS_INLINE void soft_add_fan(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, struct soft *soft,
                                       const unsigned fx)
{
    struct point_list list;
    for (int n; (n = points_fill(&soft->points, &list)) > 0; soft->count += (uint32_t)n) {
        for (int i = n; i & 3; i++) /* whole groups of four */
            list.a[i] = list.b[i] = 0;
        soft_add_list(input, scratch, soft, &list, fx);
    }
    soft->rays = soft->count;
}

/* T(p) of a light with a disk. */
static ALWAYS_INLINE struct pen_vec3
soft_transmittance(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   const struct surface *s, const struct lit *lit, struct pen_ray_counts *counts,
                   const unsigned fx)
{
    struct soft soft = {.s = s, .lit = lit, .leave = surface_leave(s, false), .whole = true};
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
