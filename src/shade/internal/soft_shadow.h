/* SPDX-License-Identifier: MIT */
/* Soft shadows: the mean transmittance of the shadow rays to sampled points of a light's disk,
 * which faces the shaded point. If possible the rays are tested as a packet (accel/disk_packet.h),
 * else one by one. Both sum in the order of the points, so the sum has the same bits. */
#ifndef PEN_SHADE_INTERNAL_SOFT_SHADOW_H
#define PEN_SHADE_INTERNAL_SOFT_SHADOW_H

#include "math/frame.h"
#include "shade/internal/light_points.h"
#include "shade/internal/shadow_ray.h"

/* The samples of one light from one point. */
struct soft {
    const struct surface *s;
    int lane; /* the point's, of s and arriving */
    const struct arriving_light *arriving;
    struct pen_origin_surface origin; /* of rays that start on the viewer's side */
    struct points points;
    struct pen_vec3 sum; /* of transmittances */
    bool whole;          /* the sum is a whole number */
    uint32_t count, rays;
};

/* Sets the disk of a light, perpendicular to the direction to it. The disk of a directional light
 * is at unit distance. */
static ALWAYS_INLINE void soft_disk(struct pen_disk_packet *packet, const struct pen_light *light,
                                    struct pen_vec3 to_light)
{
    struct pen_vec3 n = light->positional ? pen_normalize(to_light) : to_light;
    struct pen_across across = pen_across(n);
    packet->c = to_light;
    packet->u = pen_scale(across.u, light->radius);
    packet->v = pen_scale(across.v, light->radius);
}

/* Traces the ray to one point of the unit disk alone and adds its transmittance. A point below the
 * horizon is reached through the surface: the ray starts with kt, and is not traced if that is
 * black. A point that grazes adds nothing. */
static ALWAYS_INLINE void soft_add(const struct pen_kernel_input *input,
                                   struct pen_kernel_scratch *scratch, struct soft *soft,
                                   struct pen_point2 at, const unsigned fx)
{
    const struct surface *s = soft->s;
    const int lane = soft->lane;
    struct shadow_ray shadow = {.d = pen_disk_packet_direction(&scratch->packet, at.x, at.y),
                                .to_point = soft->arriving->to_point,
                                .light = soft->arriving->light};
    const struct lanes3 d = lanes3_splat(shadow.d);
    const struct horizon_sides side =
        horizon_sides(lanes3_dot(s->n, d), horizon_band(s, lanes3_length(d), shadow.to_point));
    shadow.through = lane_mask_bits(side.below) >> lane & 1;
    shadow.in =
        shadow.through ? surface_material(s, input->scene, lane, fx)->kt : pen_vec3(1, 1, 1);
    if (!(lane_mask_bits(side.above | side.below) >> lane & 1))
        return; /* it grazes */
    if (shadow.through && (!(fx & PEN_FX_SHADOW_TRANSMITTANCE) || is_black(shadow.in) ||
                           !input->scene->any_see_through))
        return;
    soft->rays++;
    uint32_t *last = &scratch->last_occluder[shadow.light], before = *last;
    soft->sum = pen_add(soft->sum, trace_shadow_ray(input, scratch, s, lane, &shadow, fx));
    if (*last == PEN_NO_PRIM)
        *last = before; /* keep the hint: the same primitive may block later samples */
}

/* Adds all samples, one by one. */
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

/* Whether the whole disk is above the horizon, by more than rounding. `size` is at least the length
 * of the vector to any of its points. */
static ALWAYS_INLINE bool soft_disk_is_above_horizon(const struct pen_disk_packet *packet,
                                                     const struct soft *soft)
{
    struct pen_vec3 n = lanes3_at(soft->s->n, soft->lane);
    double c = pen_dot(n, packet->c), u = pen_dot(n, packet->u), v = pen_dot(n, packet->v);
    double size = pen_norm1(packet->c) + pen_norm1(packet->u) + pen_norm1(packet->v);
    double band =
        lanes_at(horizon_band(soft->s, lanes_splat(size), soft->arriving->to_point), soft->lane);
    return c > sqrt(u * u + v * v) + band + 0x1p-40 * size;
}

static ALWAYS_INLINE enum pen_disk_visibility
soft_begin_packet(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                  struct soft *soft, const unsigned fx)
{
    struct pen_disk_packet *packet = &scratch->packet;
    uint32_t *last = &scratch->last_occluder[soft->arriving->light];
    /* Packets have one kt for each primitive. */
    if ((fx & PEN_FX_PATTERNS) && input->scene->patterned_glass)
        return PEN_DISK_NOT_POSSIBLE;
    if (!input->trace->disk_begin || !soft_disk_is_above_horizon(packet, soft))
        return PEN_DISK_NOT_POSSIBLE;
    packet->o = lanes3_at(soft->s->p, soft->lane);
    packet->origin = &soft->origin;
    packet->to_point = soft->arriving->to_point;
    packet->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? input->scene->see_through : NULL;
    packet->last_occluder = *last;
    enum pen_disk_visibility visibility = input->trace->disk_begin(input->scene->accel, packet);
    *last = packet->last_occluder;
    return visibility;
}

/* The transmittance of ray i of the packet, traced alone. */
static ALWAYS_INLINE struct pen_vec3 soft_trace_ray(const struct pen_kernel_input *input,
                                                    struct pen_kernel_scratch *scratch,
                                                    const struct soft *soft, int i,
                                                    struct pen_vec3 d, const unsigned fx)
{
    const struct pen_vec3 none = {0, 0, 0}, clear = {1, 1, 1};
    struct pen_shadow *query = &scratch->shadow;
    struct pen_ray ray;
    if (!pen_ray_make(&ray, scratch->packet.o, d))
        return no_sample();
    shadow_query(input, query, soft->arriving->to_point, fx);
    if (input->trace->disk_ray(input->scene->accel, &scratch->packet, &ray, i, query))
        return none;
    return shadow_colour(input, &ray, &soft->origin, query, clear, fx);
}

/* The transmittance of ray i: the product over its intersections, in their order. Without a
 * sequence there are at most two, and a product of two factors has the same bits in either order.
 */
static ALWAYS_INLINE struct pen_vec3 soft_ray_transmittance(const struct pen_kernel_input *input,
                                                            const struct pen_disk_packet *packet,
                                                            int i, const unsigned fx)
{
    struct pen_vec3 t = {1, 1, 1};
    if (!(fx & PEN_FX_SHADOW_TRANSMITTANCE))
        return t;
    if (packet->in_sequence >> i & 1) {
        for (int k = 0; k < packet->sequence_count[i]; k++)
            t = shadow_filter(input->scene, packet->candidate[packet->sequence[i][k]].prim, t);
        return t;
    }
    for (int k = 0; k < packet->transmissive_count; k++) {
        const struct pen_disk_candidate *candidate = &packet->candidate[packet->transmissive[k]];
        if ((candidate->once | candidate->twice) >> i & 1)
            t = shadow_filter(input->scene, candidate->prim, t);
        if (candidate->twice >> i & 1)
            t = shadow_filter(input->scene, candidate->prim, t);
    }
    return t;
}

/* Whether all unblocked rays have the same transmissive intersections, and at most two. */
static ALWAYS_INLINE bool soft_uniform(const struct pen_disk_packet *packet, uint64_t unblocked,
                                       const unsigned fx)
{
    if (!(fx & PEN_FX_SHADOW_TRANSMITTANCE))
        return true;
    if (packet->in_sequence)
        return false;
    for (int k = 0; k < packet->transmissive_count; k++) {
        uint64_t once = packet->candidate[packet->transmissive[k]].once & unblocked;
        uint64_t twice = packet->candidate[packet->transmissive[k]].twice & unblocked;
        if ((once && once != unblocked) || (twice && twice != unblocked))
            return false;
    }
    return true;
}

/* Adds the transmittance of each unblocked ray, in order. */
static ALWAYS_INLINE void soft_add_each(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, struct soft *soft,
                                        const struct point_list *list, uint64_t unblocked,
                                        uint64_t fallback, const unsigned fx)
{
    struct pen_disk_packet *packet = &scratch->packet;
    for (; unblocked; unblocked &= unblocked - 1) {
        int i = __builtin_ctzll(unblocked);
        struct pen_vec3 t;
        if (fallback >> i & 1)
            t = soft_trace_ray(input, scratch, soft, i,
                               pen_disk_packet_direction(packet, list->a[i], list->b[i]), fx);
        else
            t = soft_ray_transmittance(input, packet, i, fx);
        soft->sum = pen_add(soft->sum, t);
    }
}

/* Adds the rays to a list of points. If all unblocked rays have transmittance 1, the sum is a whole
 * number without rounding, so their number is added at once. */
static ALWAYS_INLINE void soft_add_rays(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, struct soft *soft,
                                        const struct point_list *list, const unsigned fx)
{
    struct pen_disk_packet *packet = &scratch->packet;
    uint64_t all = list->count < 64 ? (UINT64_C(1) << list->count) - 1 : UINT64_MAX, fallback;
    uint64_t unblocked =
        all & ~input->trace->disk_test(packet, list->a, list->b, list->count, &fallback);
    if (!unblocked)
        return;
    if (fallback || !soft_uniform(packet, unblocked, fx)) {
        soft->whole = false;
        soft_add_each(input, scratch, soft, list, unblocked, fallback, fx);
        return;
    }
    struct pen_vec3 t = soft_ray_transmittance(input, packet, __builtin_ctzll(unblocked), fx);
    int rays = __builtin_popcountll(unblocked);
    soft->whole = soft->whole && t.x == 1 && t.y == 1 && t.z == 1;
    if (soft->whole)
        soft->sum = pen_add(soft->sum, pen_vec3(rays, rays, rays));
    else
        for (int i = 0; i < rays; i++)
            soft->sum = pen_add(soft->sum, t);
}

static ALWAYS_INLINE void soft_add_packet(const struct pen_kernel_input *input,
                                          struct pen_kernel_scratch *scratch, struct soft *soft,
                                          const unsigned fx)
{
    struct point_list list;
    for (int n; (n = points_fill(&soft->points, &list)) > 0; soft->count += (uint32_t)n) {
        for (int i = n; i % LANES; i++) /* rays are tested in whole groups */
            list.a[i] = list.b[i] = 0;
        soft_add_rays(input, scratch, soft, &list, fx);
    }
    soft->rays = soft->count;
}

/* T(p) of a light with a radius, for one point of s. */
static ALWAYS_INLINE struct pen_vec3
soft_transmittance(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   const struct surface *s, int lane, const struct arriving_light *arriving,
                   struct pen_ray_counts *counts, const unsigned fx)
{
    struct soft soft = {.s = s,
                        .lane = lane,
                        .arriving = arriving,
                        .origin = surface_origin(s, lane, false),
                        .whole = true};
    soft_disk(&scratch->packet, &input->scene->lights[arriving->light],
              lanes3_at(arriving->to_light, lane));
    scratch->key.light = input->scene->light_index[arriving->light];
    soft.points = points_begin(input->settings, pen_sample_hash(&scratch->key));
    if (fx & PEN_FX_ANTI_ALIASING)
        points_skip(&soft.points, scratch->ray);
    enum pen_disk_visibility visibility = soft_begin_packet(input, scratch, &soft, fx);
    if (visibility == PEN_DISK_ALL_VISIBLE || visibility == PEN_DISK_ALL_OCCLUDED) {
        double t = visibility == PEN_DISK_ALL_VISIBLE;
        counts->shadow += points_count(&soft.points);
        return pen_vec3(t, t, t);
    }
    if (visibility == PEN_DISK_MIXED)
        soft_add_packet(input, scratch, &soft, fx);
    else
        soft_add_singly(input, scratch, &soft, fx);
    counts->shadow += soft.rays;
    double points = soft.count;
    return pen_vec3(soft.sum.x / points, soft.sum.y / points, soft.sum.z / points);
}

#endif
