/* SPDX-License-Identifier: MIT */
/* Soft shadows of the stripped block kernel: src/shade/internal/soft_shadow.h and shadow_ray.h
 * without transmissive surfaces, so a ray is blocked or adds 1. */
#ifndef TESTS_EFFECTS_STRIPPED_SOFT_H
#define TESTS_EFFECTS_STRIPPED_SOFT_H

#include "effects/stripped/shadows.h"
#include "math/frame.h"
#include "shade/internal/light_points.h"

struct samples {
    const struct surface *s;
    int lane;
    const struct arriving_light *arriving;
    struct pen_origin_surface origin;
    struct points points;
    struct pen_vec3 sum;
    uint32_t count, rays;
};

static ALWAYS_INLINE void samples_disk(struct pen_disk_packet *packet,
                                       const struct pen_light *light, struct pen_vec3 to_light)
{
    struct pen_vec3 n = light->positional ? pen_normalize(to_light) : to_light;
    struct pen_across across = pen_across(n);
    packet->c = to_light;
    packet->u = pen_scale(across.u, light->radius);
    packet->v = pen_scale(across.v, light->radius);
}

static ALWAYS_INLINE void begin_query(struct pen_shadow *query, bool to_point)
{
    query->tmax = to_point ? 1 : INFINITY;
    query->to_point = to_point;
    query->see_through = NULL;
    query->last_occluder = PEN_NO_PRIM;
}

static ALWAYS_INLINE struct pen_vec3 trace_sample(const struct pen_kernel_input *input,
                                                  struct pen_kernel_scratch *scratch,
                                                  const struct samples *in, struct pen_vec3 d)
{
    const struct pen_vec3 none = {0, 0, 0}, clear = {1, 1, 1};
    const uint32_t light = in->arriving->light;
    struct pen_ray ray;
    if (!pen_ray_make(&ray, lanes3_at(in->s->p, in->lane), d))
        return no_sample();
    struct pen_shadow *query = &scratch->shadow;
    begin_query(query, in->arriving->to_point);
    query->last_occluder = scratch->last_occluder[light];
    bool blocked = input->trace->shadow(input->scene->accel, &ray, &in->s->origin[in->lane], query);
    scratch->last_occluder[light] = query->last_occluder;
    return blocked ? none : clear;
}

static ALWAYS_INLINE void samples_add(const struct pen_kernel_input *input,
                                      struct pen_kernel_scratch *scratch, struct samples *in,
                                      struct pen_point2 at)
{
    const struct surface *s = in->s;
    const struct pen_vec3 to = pen_disk_packet_direction(&scratch->packet, at.x, at.y);
    const struct lanes3 d = lanes3_splat(to);
    const struct horizon_sides side = horizon_sides(
        lanes3_dot(s->n, d), horizon_band(s, lanes3_length(d), in->arriving->to_point));
    if (!(lane_mask_bits(side.above) >> in->lane & 1))
        return;
    in->rays++;
    uint32_t *last = &scratch->last_occluder[in->arriving->light], before = *last;
    in->sum = pen_add(in->sum, trace_sample(input, scratch, in, to));
    if (*last == PEN_NO_PRIM)
        *last = before;
}

static ALWAYS_INLINE void samples_add_singly(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch, struct samples *in)
{
    struct point_list list;
    for (int n; (n = points_fill(&in->points, &list)) > 0; in->count += (uint32_t)n) {
        for (int i = 0; i < n; i++)
            samples_add(input, scratch, in, (struct pen_point2){list.a[i], list.b[i]});
    }
}

static ALWAYS_INLINE bool disk_is_above_horizon(const struct pen_disk_packet *packet,
                                                const struct samples *in)
{
    struct pen_vec3 n = lanes3_at(in->s->n, in->lane);
    double c = pen_dot(n, packet->c), u = pen_dot(n, packet->u), v = pen_dot(n, packet->v);
    double size = pen_norm1(packet->c) + pen_norm1(packet->u) + pen_norm1(packet->v);
    double band =
        lanes_at(horizon_band(in->s, lanes_splat(size), in->arriving->to_point), in->lane);
    return c > sqrt(u * u + v * v) + band + 0x1p-40 * size;
}

static ALWAYS_INLINE enum pen_disk_visibility
samples_begin_packet(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                     struct samples *in)
{
    struct pen_disk_packet *packet = &scratch->packet;
    uint32_t *last = &scratch->last_occluder[in->arriving->light];
    if (!input->trace->disk_begin || !disk_is_above_horizon(packet, in))
        return PEN_DISK_NOT_POSSIBLE;
    packet->o = lanes3_at(in->s->p, in->lane);
    packet->origin = &in->origin;
    packet->to_point = in->arriving->to_point;
    packet->see_through = NULL;
    packet->last_occluder = *last;
    enum pen_disk_visibility visibility = input->trace->disk_begin(input->scene->accel, packet);
    *last = packet->last_occluder;
    return visibility;
}

/* Traces the rays that the packet does not decide one by one, in order. */
static ALWAYS_INLINE void samples_add_each(const struct pen_kernel_input *input,
                                           struct pen_kernel_scratch *scratch, struct samples *in,
                                           const struct point_list *list, uint64_t unblocked,
                                           uint64_t fallback)
{
    struct pen_disk_packet *packet = &scratch->packet;
    struct pen_shadow *query = &scratch->shadow;
    for (; unblocked; unblocked &= unblocked - 1) {
        const int i = __builtin_ctzll(unblocked);
        struct pen_vec3 t = {1, 1, 1};
        struct pen_ray ray;
        if (fallback >> i & 1) {
            const struct pen_vec3 d = pen_disk_packet_direction(packet, list->a[i], list->b[i]);
            begin_query(query, in->arriving->to_point);
            if (!pen_ray_make(&ray, packet->o, d))
                t = no_sample();
            else if (input->trace->disk_ray(input->scene->accel, packet, &ray, i, query))
                t = pen_vec3(0, 0, 0);
        }
        in->sum = pen_add(in->sum, t);
    }
}

static ALWAYS_INLINE void samples_add_rays(const struct pen_kernel_input *input,
                                           struct pen_kernel_scratch *scratch, struct samples *in,
                                           const struct point_list *list)
{
    struct pen_disk_packet *packet = &scratch->packet;
    uint64_t all = list->count < 64 ? (UINT64_C(1) << list->count) - 1 : UINT64_MAX, fallback;
    uint64_t unblocked =
        all & ~input->trace->disk_test(packet, list->a, list->b, list->count, &fallback);
    if (!unblocked)
        return;
    if (fallback) {
        samples_add_each(input, scratch, in, list, unblocked, fallback);
        return;
    }
    const int rays = __builtin_popcountll(unblocked);
    in->sum = pen_add(in->sum, pen_vec3(rays, rays, rays));
}

static ALWAYS_INLINE void samples_add_packet(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch, struct samples *in)
{
    struct point_list list;
    for (int n; (n = points_fill(&in->points, &list)) > 0; in->count += (uint32_t)n) {
        for (int i = n; i % LANES; i++)
            list.a[i] = list.b[i] = 0;
        samples_add_rays(input, scratch, in, &list);
    }
    in->rays = in->count;
}

static ALWAYS_INLINE struct pen_vec3 samples_mean(const struct pen_kernel_input *input,
                                                  struct pen_kernel_scratch *scratch,
                                                  const struct surface *s, int lane,
                                                  const struct arriving_light *arriving,
                                                  struct pen_ray_counts *counts)
{
    struct samples in = {
        .s = s, .lane = lane, .arriving = arriving, .origin = surface_origin(s, lane, false)};
    samples_disk(&scratch->packet, &input->scene->lights[arriving->light],
                 lanes3_at(arriving->to_light, lane));
    scratch->key.light = input->scene->light_index[arriving->light];
    in.points = points_begin(input->settings, pen_sample_hash(&scratch->key));
    enum pen_disk_visibility visibility = samples_begin_packet(input, scratch, &in);
    if (visibility == PEN_DISK_ALL_VISIBLE || visibility == PEN_DISK_ALL_OCCLUDED) {
        double t = visibility == PEN_DISK_ALL_VISIBLE;
        counts->shadow += points_count(&in.points);
        return pen_vec3(t, t, t);
    }
    if (visibility == PEN_DISK_MIXED)
        samples_add_packet(input, scratch, &in);
    else
        samples_add_singly(input, scratch, &in);
    counts->shadow += in.rays;
    double points = in.count;
    return pen_vec3(in.sum.x / points, in.sum.y / points, in.sum.z / points);
}

#endif
