/* SPDX-License-Identifier: MIT */
/* Hard shadows of the stripped block kernels: those of block_wave.h of src/shade/internal, without
 * transmissive surfaces. */
#ifndef TESTS_EFFECTS_STRIPPED_SHADOWS_H
#define TESTS_EFFECTS_STRIPPED_SHADOWS_H

#include "effects/stripped/block.h"

static ALWAYS_INLINE void block_set_transmittance(struct pen_block_scratch *b, int point,
                                                  struct pen_vec3 t)
{
    b->transmittance[0][point] = t.x;
    b->transmittance[1][point] = t.y;
    b->transmittance[2][point] = t.z;
}

static ALWAYS_INLINE void block_hard_shadows(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_block_scratch *b, uint32_t light,
                                             uint64_t points)
{
    struct pen_ray_packet *packet = &b->packet;
    uint64_t made = 0;
    packet->light = input->scene->lights[light].position;
    packet->to_point = input->scene->lights[light].positional;
    packet->see_through = NULL;
    packet->last_occluder = scratch->last_occluder[light];
    packet->queries = b->query;
    pen_ray_array_begin(&packet->rays);
    for (int g = 0; g < block_groups(b); g++) {
        if (!group_bits(points, g))
            continue;
        const lane_mask can = lanes_ray_array_make(&packet->rays, g * LANES, b->surface[g].p,
                                                   b->arriving[g].to_light);
        made |= (uint64_t)lane_mask_bits(can) << g * LANES;
        b->hard_rays[g] =
            lanes_select(b->arriving[g].arrives, b->hard_rays[g] + 1, b->hard_rays[g]);
    }
    packet->live = points & made;
    const uint64_t blocked = input->trace->shadow_packet(input->scene->accel, packet);
    scratch->last_occluder[light] = packet->last_occluder;
    b->passes = packet->live & ~blocked;
    b->filtered = points & ~made;
    for (uint64_t left = b->filtered; left; left &= left - 1)
        block_set_transmittance(b, __builtin_ctzll(left), no_sample());
}

static ALWAYS_INLINE void block_filter(struct pen_block_scratch *b, int g)
{
    struct arriving_light *arriving = &b->arriving[g];
    const unsigned filtered = group_bits(b->filtered, g);
    if (!filtered) {
        arriving->arrives &= lane_mask_of(group_bits(b->passes, g));
        return;
    }
    const lane_mask set = lane_mask_of(filtered);
    const lanes passes =
        lanes_select(lane_mask_of(group_bits(b->passes, g)), lanes_splat(1), lanes_splat(0));
    const struct lanes3 t = {
        lanes_select(set, lanes_load(b->transmittance[0] + g * LANES), passes),
        lanes_select(set, lanes_load(b->transmittance[1] + g * LANES), passes),
        lanes_select(set, lanes_load(b->transmittance[2] + g * LANES), passes)};
    arriving->arrives &= lane_mask_not(lanes_black(t));
    arriving->term = lanes3_mul(arriving->term, t);
}

static ALWAYS_INLINE void block_start_at_points(struct pen_block_scratch *b)
{
    struct pen_ray_packet *packet = &b->packet;
    int first = 0;
    pen_ray_packet_start(packet);
    for (int g = 0; g < block_groups(b); g++) {
        const struct pen_origin_surface **origin = &packet->origin[g * LANES];
#pragma GCC unroll 8
        for (int i = 0; i < LANES; i++)
            origin[i] = &b->surface[g].origin[i];
        lanes_store(packet->bound + g * LANES, b->surface[g].bound);
    }
    for (int k = 0; k < b->parts_met; k++) {
        const int count = __builtin_popcountll(b->part[k].paths);
        pen_ray_packet_start_on(packet, b->part[k].prim, UINT64_MAX >> (64 - count) << first);
        first += count;
    }
}

/* Marks the wave's points to which lights may contribute; returns true if there are any. */
static ALWAYS_INLINE bool block_begin_lights(const struct pen_kernel_input *input,
                                             struct pen_block_scratch *b)
{
    for (int g = 0; g < block_groups(b); g++)
        b->hard_rays[g] = lanes_splat(0);
    if (!block_emitted(input, b))
        return false;
    block_start_at_points(b);
    return true;
}

/* Adds a light to points. If the light casts shadows, they are known. */
static ALWAYS_INLINE void block_add_shadowed(struct pen_block_scratch *b, uint64_t points,
                                             bool shadows)
{
    for (int g = 0; g < block_groups(b); g++) {
        if (!group_bits(points, g))
            continue;
        if (shadows)
            block_filter(b, g);
        block_add_light(b, g);
    }
}

static ALWAYS_INLINE void block_light_hard(const struct pen_kernel_input *input,
                                           struct pen_kernel_scratch *scratch,
                                           struct pen_block_scratch *b, uint32_t light)
{
    const bool shadows = input->scene->lights[light].shadows;
    const uint64_t points = block_unshadowed(input, b, light);
    if (shadows && points)
        block_hard_shadows(input, scratch, b, light, points);
    block_add_shadowed(b, points, shadows);
}

/* Records the radiance and the shadow rays of a group's points. */
static ALWAYS_INLINE void block_record_points(struct pen_block_scratch *b, int g)
{
    struct pen_vec3 radiance[LANES];
    double hard_rays[LANES];
    const struct path *path[LANES];
    const int first = g * LANES, count = block_group_paths(b, g, path);
    lanes3_store(radiance, b->radiance[g]);
    lanes_store(hard_rays, b->hard_rays[g]);
    for (int i = 0; i < count; i++) {
        const struct block_path *at = b->wave[first + i];
        b->record[at->record].radiance = pen_mul(path[i]->weight, radiance[i]);
        b->counts[at->pixel].shadow += (uint64_t)hard_rays[i];
    }
}

#endif
