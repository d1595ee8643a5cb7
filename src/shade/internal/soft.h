/* SPDX-License-Identifier: MIT */
/* Soft shadows: the mean transmittance of shadow rays to points of a light's disk, which faces the
 * shaded point. The rays are taken together where they can (accel/packet.h), else one by one; the
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
    struct pen_origin_surface origin; /* of rays that stay above the horizon */
    struct points points;
    struct pen_vec3 sum; /* of transmittances */
    bool whole;          /* it is a whole number */
    uint32_t count, rays;
};

/* A light's disk is perpendicular to the direction to it; that of a directional one is at unit
 * distance. */
static ALWAYS_INLINE void soft_disk(struct pen_shadow_packet *packet, const struct pen_light *light,
                                    struct pen_vec3 to_light)
{
    struct pen_vec3 n = light->kind == PEN_LIGHT_DIRECTIONAL ? to_light : pen_normalize(to_light);
    struct pen_across across = pen_across(n);
    packet->c = to_light;
    packet->u = pen_scale(across.u, light->radius);
    packet->v = pen_scale(across.v, light->radius);
}

/* Adds the sample at a point of the unit disk by itself. One below the horizon is reached through
 * the surface, which takes its share first, or all of it. */
static ALWAYS_INLINE void soft_add(const struct pen_kernel_input *input,
                                   struct pen_kernel_scratch *scratch, struct soft *soft,
                                   struct pen_point2 at, const unsigned fx)
{
    const struct surface *s = soft->s;
    struct shadow_way direction = {.d = pen_packet_direction(&scratch->packet, at.x, at.y),
                                   .to_point = soft->lit->to_point,
                                   .light = soft->lit->light};
    direction.through = !(pen_dot(s->n, direction.d) > 0);
    direction.in = direction.through ? s->material->kt : pen_vec3(1, 1, 1);
    if (direction.through && (!(fx & PEN_FX_SHADOW_TRANSMITTANCE) || is_black(direction.in)))
        return;
    soft->rays++;
    uint32_t *last = &scratch->last_occluder[direction.light], before = *last;
    soft->sum = pen_add(soft->sum, shadow_ray(input, scratch, s, &direction, fx));
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
static ALWAYS_INLINE bool soft_above(const struct pen_shadow_packet *packet, struct pen_vec3 n)
{
    double c = pen_dot(n, packet->c), u = pen_dot(n, packet->u), v = pen_dot(n, packet->v);
    double size = pen_norm1(packet->c) + pen_norm1(packet->u) + pen_norm1(packet->v);
    return c > sqrt(u * u + v * v) + 0x1p-40 * size;
}

static ALWAYS_INLINE enum pen_packet_visibility soft_fan(const struct pen_kernel_input *input,
                                                         struct pen_kernel_scratch *scratch,
                                                         struct soft *soft, const unsigned fx)
{
    struct pen_shadow_packet *packet = &scratch->packet;
    uint32_t *last = &scratch->last_occluder[soft->lit->light];
    if (!input->trace->packet_begin || !soft_above(packet, soft->s->n))
        return PEN_PACKET_NOT_POSSIBLE;
    packet->o = soft->s->p;
    packet->origin = &soft->origin;
    packet->to_point = soft->lit->to_point;
    packet->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? input->scene->see_through : NULL;
    packet->last_occluder = *last;
    enum pen_packet_visibility fate = input->trace->packet_begin(input->scene->accel, packet);
    *last = packet->last_occluder;
    return fate;
}

/* What arrives along ray i of the packet. */
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
    if (input->trace->packet_ray(input->scene->accel, &scratch->packet, &ray, i, query))
        return none;
    return shadow_colour(input, &ray, &soft->origin, query, clear, fx);
}

/* What arrives of ray i, which crosses primitives no more than twice in all. */
static ALWAYS_INLINE struct pen_vec3 soft_tint(const struct pen_kernel_input *input,
                                               const struct pen_shadow_packet *packet, int i)
{
    struct pen_vec3 t = {1, 1, 1};
    for (int k = 0; k < packet->transmissive_count; k++) {
        const struct pen_candidate *candidate = &packet->candidate[packet->transmissive[k]];
        if ((candidate->once | candidate->twice) >> i & 1)
            t = shadow_filter(input->scene, candidate->prim, t);
        if (candidate->twice >> i & 1)
            t = shadow_filter(input->scene, candidate->prim, t);
    }
    return t;
}

/* Whether all rays of `open` cross the same primitives. */
static ALWAYS_INLINE bool soft_uniform(const struct pen_shadow_packet *packet, uint64_t open)
{
    for (int k = 0; k < packet->transmissive_count; k++) {
        uint64_t once = packet->candidate[packet->transmissive[k]].once & open;
        uint64_t twice = packet->candidate[packet->transmissive[k]].twice & open;
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
    struct pen_shadow_packet *packet = &scratch->packet;
    for (; open; open &= open - 1) {
        int i = __builtin_ctzll(open);
        struct pen_vec3 t;
        if (ask >> i & 1)
            t = soft_ask(input, scratch, soft, i,
                         pen_packet_direction(packet, list->a[i], list->b[i]), fx);
        else
            t = soft_tint(input, packet, i);
        soft->sum = pen_add(soft->sum, t);
    }
}

/* Adds the rays of a list. Sums of ones have no rounding, and need not be made one by one. */
static ALWAYS_INLINE void soft_add_list(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, struct soft *soft,
                                        const struct point_list *list, const unsigned fx)
{
    struct pen_shadow_packet *packet = &scratch->packet;
    uint64_t all = list->count < 64 ? (UINT64_C(1) << list->count) - 1 : UINT64_MAX, ask;
    uint64_t open = all & ~input->trace->packet_test(packet, list->a, list->b, list->count, &ask);
    if (!open)
        return;
    if (ask || !soft_uniform(packet, open)) {
        soft->whole = false;
        soft_add_each(input, scratch, soft, list, open, ask, fx);
        return;
    }
    struct pen_vec3 t = soft_tint(input, packet, __builtin_ctzll(open));
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
    struct soft soft = {.s = s, .lit = lit, .origin = surface_origin(s, false), .whole = true};
    soft_disk(&scratch->packet, &input->scene->lights[lit->light], lit->to_light);
    scratch->key.light = input->scene->light_index[lit->light];
    soft.points = points_begin(input->settings, pen_sample_hash(&scratch->key));
    enum pen_packet_visibility fate = soft_fan(input, scratch, &soft, fx);
    if (fate == PEN_PACKET_ALL_VISIBLE || fate == PEN_PACKET_ALL_OCCLUDED) {
        double t = fate == PEN_PACKET_ALL_VISIBLE;
        counts->shadow += points_count(&soft.points);
        return pen_vec3(t, t, t);
    }
    if (fate == PEN_PACKET_MIXED)
        soft_add_fan(input, scratch, &soft, fx);
    else
        soft_add_singly(input, scratch, &soft, fx);
    counts->shadow += soft.rays;
    double points = soft.count;
    return pen_vec3(soft.sum.x / points, soft.sum.y / points, soft.sum.z / points);
}

#endif
