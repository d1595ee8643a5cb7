/* SPDX-License-Identifier: MIT */
/* The block kernel stripped by hand: block_body.h and block_wave.h of src/shade/internal, without
 * anti-aliasing, lens, sky, refraction, transmission and blur. Shadows are in shadows.h and soft.h,
 * mirrors in kernel_mirror.h. */
#ifndef TESTS_EFFECTS_STRIPPED_BLOCK_H
#define TESTS_EFFECTS_STRIPPED_BLOCK_H

#include <float.h>
#include <string.h>

#include "effects/stripped/points.h"
#include "geom/ray_lanes.h"
#include "shade/internal/block_scratch.h"

static ALWAYS_INLINE bool is_layered(const struct pen_kernel_input *input, const struct path *path,
                                     struct pen_hit hit)
{
    const uint32_t *first = input->scene->layer_first;
    return first && first[hit.prim] != first[hit.prim + 1] && hit.t > PEN_LAST_LAYER_T &&
           pen_layers_met(input, path, hit);
}

static ALWAYS_INLINE void block_add_point(struct pen_block_scratch *b, int i, struct pen_hit hit)
{
    int k = b->parts_met;
    while (k > 0 && !(b->part[k - 1].prim == hit.prim && b->part[k - 1].part == hit.part))
        k--;
    if (k == 0) {
        k = ++b->parts_met;
        b->part[k - 1] = (struct block_part){.prim = hit.prim, .part = hit.part};
    }
    b->part[k - 1].paths |= UINT64_C(1) << i;
}

static ALWAYS_INLINE void block_order_points(struct pen_block_scratch *b)
{
    struct block_path *wave[PEN_RAY_PACKET_MAX];
    int points = 0;
    for (int k = 0; k < b->parts_met; k++) {
        for (uint64_t left = b->part[k].paths; left; left &= left - 1) {
            const int i = __builtin_ctzll(left);
            b->surface[points / LANES].hit[points % LANES] = b->packet.hit[i];
            wave[points++] = b->wave[i];
        }
    }
    for (int i = 0; i < points; i++)
        b->wave[i] = wave[i];
    b->count = points;
}

static ALWAYS_INLINE uint64_t block_all_paths(const struct pen_block_scratch *b)
{
    return b->count < 64 ? (UINT64_C(1) << b->count) - 1 : UINT64_MAX;
}

static ALWAYS_INLINE void block_set_packet(struct pen_block_scratch *b)
{
    struct pen_ray_packet *packet = &b->packet;
    packet->live = block_all_paths(b);
    pen_ray_array_begin(&packet->rays);
    pen_ray_packet_start(packet);
    for (int i = 0; i < b->count; i++) {
        const struct path *path = &b->wave[i]->path;
        pen_ray_array_set(&packet->rays, i, &path->ray);
        pen_ray_packet_start_ray(packet, i, &path->origin);
        packet->after[i] = path->after;
    }
}

static ALWAYS_INLINE void block_trace(const struct pen_kernel_input *input,
                                      struct pen_block_scratch *b)
{
    const struct pen_scene *scene = input->scene;
    struct pen_ray_packet *packet = &b->packet;
    const uint64_t met = input->trace->nearest_packet(scene->accel, packet);
    b->parts_met = 0;
    for (int i = 0; i < b->count; i++) {
        struct block_path *at = b->wave[i];
        if (!(met >> i & 1)) {
            b->record[at->record].radiance = pen_mul(at->path.weight, scene->background);
        } else if (is_layered(input, &at->path, packet->hit[i])) {
            block_defer(b, at);
        } else {
            block_add_point(b, i, packet->hit[i]);
        }
    }
    block_order_points(b);
}

static ALWAYS_INLINE void block_surfaces(const struct pen_kernel_input *input,
                                         struct pen_block_scratch *b)
{
    for (int g = 0; g < block_groups(b); g++) {
        const struct path *path[LANES];
        const int first = g * LANES, count = block_group_paths(b, g, path);
        points_at(&b->surface[g], input->scene, path, count);
        unsigned finite = lane_mask_bits(b->surface[g].finite);
        if (path[0]->depth > 0)
            finite &= ~lane_mask_bits(b->surface[g].corner);
        for (int i = 0; i < count; i++)
            if (!(finite >> i & 1))
                block_defer(b, b->wave[first + i]);
    }
}

/* Sets the radiance without lights. Returns true if lights contribute to any point. */
static ALWAYS_INLINE bool block_emitted(const struct pen_kernel_input *input,
                                        struct pen_block_scratch *b)
{
    bool any = false;
    for (int g = 0; g < block_groups(b); g++) {
        const bool primary = b->wave[g * LANES]->path.depth == 0;
        b->radiance[g] = emitted(input->scene, &b->surface[g], primary);
        b->lit[g] = surface_lit(&b->surface[g]);
        any |= lane_mask_bits(b->lit[g]) != 0;
    }
    return any;
}

/* Adds a light without shadows. Returns the points that it reaches. */
static ALWAYS_INLINE uint64_t block_unshadowed(const struct pen_kernel_input *input,
                                               struct pen_block_scratch *b, uint32_t light)
{
    uint64_t points = 0;
    for (int g = 0; g < block_groups(b); g++) {
        unshadowed(&b->arriving[g], &input->scene->lights[light], &b->surface[g], b->lit[g]);
        b->arriving[g].light = light;
        points |= (uint64_t)lane_mask_bits(b->arriving[g].arrives) << (g * LANES);
    }
    return points;
}

static ALWAYS_INLINE void block_add_light(struct pen_block_scratch *b, int g)
{
    b->radiance[g] = lanes3_select(b->arriving[g].arrives,
                                   lanes3_add(b->radiance[g], b->arriving[g].term), b->radiance[g]);
}

static ALWAYS_INLINE void block_begin_path(struct pen_block_scratch *b, struct block_path *wave,
                                           int pixel, int32_t record)
{
    wave->path.origin = pen_origin_none;
    wave->path.after = pen_after_start;
    wave->path.weight = pen_vec3(1, 1, 1);
    wave->path.depth = 0;
    wave->path.node = 1;
    wave->record = record;
    wave->pixel = (uint8_t)pixel;
    b->wave[b->count++] = wave;
}

static ALWAYS_INLINE void block_begin_packet(struct pen_block_scratch *b)
{
    struct pen_ray_packet *packet = &b->packet;
    packet->live = block_all_paths(b);
    packet->rays.along_x &= packet->live;
    packet->rays.along_y &= packet->live;
    packet->rays.forward &= packet->live;
    pen_ray_packet_start(packet);
    pen_ray_packet_start_on(packet, PEN_NO_PRIM, packet->live);
    for (int i = 0; i < b->count; i++) {
        packet->origin[i] = &pen_origin_none;
        packet->bound[i] = -1;
        packet->after[i] = pen_after_start;
    }
}

static ALWAYS_INLINE lane_mask block_rays_of(const struct pen_kernel_input *input, const double *x,
                                             const double *y, struct lanes_ray *rays)
{
    const struct pen_pinhole *pinhole = &input->pinhole;
    struct lanes3 d = lanes3_along(lanes3_splat(pinhole->middle), lanes3_splat(pinhole->dx),
                                   lanes_load(x) - pinhole->half_width);
    d = lanes3_along(d, lanes3_splat(pinhole->dy), lanes_load(y) - pinhole->half_height);
    return lanes_ray_of(rays, lanes3_splat(pinhole->eye), d);
}

static ALWAYS_INLINE void block_camera_rays(const struct pen_kernel_input *input,
                                            struct pen_block_scratch *b, const double *x,
                                            const double *y, int pixels)
{
    b->count = b->record_count = 0;
    pen_ray_array_begin(&b->packet.rays);
    for (int first = 0; first < pixels; first += LANES) {
        struct pen_ray *ray[LANES];
        struct lanes_ray rays;
        for (int i = 0; i < LANES; i++)
            ray[i] = &b->pool[first + i].path.ray;
        const unsigned made = lane_mask_bits(block_rays_of(input, x + first, y + first, &rays));
        lanes_ray_put(&rays, ray);
        lanes_ray_array_put(&rays, &b->packet.rays, first);
        for (int i = first; i < first + LANES && i < pixels; i++) {
            const int32_t record = block_record_new(b, i);
            if (made >> (i - first) & 1)
                block_begin_path(b, &b->pool[i], i, record);
            else
                b->deferred |= UINT64_C(1) << i;
        }
    }
    if (b->count < pixels)
        block_set_packet(b);
    else
        block_begin_packet(b);
}

#define PIXELS_4(n) (n), (n) + 1, (n) + 8, (n) + 9
#define PIXELS_16(n) PIXELS_4(n), PIXELS_4(n + 2), PIXELS_4(n + 16), PIXELS_4(n + 18)
static const uint8_t block_z_order[BLOCK_PIXELS] = {PIXELS_16(0), PIXELS_16(4), PIXELS_16(32),
                                                    PIXELS_16(36)};
#undef PIXELS_4
#undef PIXELS_16

static ALWAYS_INLINE int block_order(struct pen_block_scratch *b, struct pen_rect rect)
{
    int pixels = 0;
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const int x = block_z_order[i] % 8, y = block_z_order[i] / 8;
        if (x >= rect.width || y >= rect.height)
            continue;
        b->x[pixels] = rect.x + x;
        b->y[pixels++] = rect.y + y;
    }
    return pixels;
}

/* Makes the camera rays of a block's pixels. Returns the number of pixels. */
static ALWAYS_INLINE int block_begin(const struct pen_kernel_input *input,
                                     struct pen_block_scratch *b, struct pen_rect rect,
                                     struct pen_ray_counts *counts)
{
    const struct pen_ray_counts none = {.primary = 0};
    double x[BLOCK_PIXELS], y[BLOCK_PIXELS];
    const int pixels = block_order(b, rect);
    memset(x, 0, sizeof x);
    memset(y, 0, sizeof y);
    b->deferred = 0;
    for (int i = 0; i < pixels; i++) {
        x[i] = 0.5 + b->x[i];
        y[i] = 0.5 + b->y[i];
        b->counts[i] = none;
        b->surfaces[i] = 0;
    }
    counts->primary += (uint64_t)pixels;
    block_camera_rays(input, b, x, y, pixels);
    return pixels;
}

/* Sums the radiance of the pixels' surfaces; `alone` renders the deferred pixels. */
static ALWAYS_INLINE void block_end(const struct pen_kernel_input *input,
                                    struct pen_kernel_scratch *scratch, struct pen_rect rect,
                                    int pixels, double (*rgb)[3], struct pen_ray_counts *counts,
                                    pen_kernel_sample_fn *alone)
{
    struct pen_block_scratch *b = scratch->block;
    for (int i = 0; i < pixels; i++) {
        struct pen_vec3 c = {0, 0, 0};
        if (b->deferred >> i & 1) {
            scratch->key.x = (uint32_t)b->x[i];
            scratch->key.y = (uint32_t)b->y[i];
            const struct pen_camera_point at = {.x = 0.5 + b->x[i], .y = 0.5 + b->y[i]};
            c = alone(input, scratch, at, counts);
        } else {
            c = block_sum(b, i, c);
            pen_ray_counts_add(counts, &b->counts[i]);
        }
        double *out = rgb[(b->y[i] - rect.y) * rect.width + b->x[i] - rect.x];
        const bool fits = fabs(c.x) <= FLT_MAX && fabs(c.y) <= FLT_MAX && fabs(c.z) <= FLT_MAX;
        counts->dropped_samples += !fits;
        out[0] = fits ? c.x : 0;
        out[1] = fits ? c.y : 0;
        out[2] = fits ? c.z : 0;
    }
}

#endif
