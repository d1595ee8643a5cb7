/* SPDX-License-Identifier: MIT */
/* One wave of a block (block_body.h). Up to 64 paths are traced as one packet. Then the shadow rays
 * of all their points are traced, light by light in document order. Then their transmitted and
 * reflected paths are put on two stacks. A pixel sample is deferred to the pixel kernel if it meets
 * coincident surfaces or a surface that blurs, if its point is not finite, or if there is no room.
 */
#ifndef PEN_SHADE_INTERNAL_BLOCK_WAVE_H
#define PEN_SHADE_INTERNAL_BLOCK_WAVE_H

#include "shade/internal/background.h"
#include "shade/internal/block_scratch.h"
#include "shade/internal/blur.h"
#include "shade/internal/secondary_rays.h"
#include "shade/internal/soft_shadow.h"

/* Whether the path's next hit is one of several layers: see path_nearest. */
static ALWAYS_INLINE bool is_layered(const struct pen_kernel_input *input, const struct path *path,
                                     struct pen_hit hit)
{
    const uint32_t *first = input->scene->layer_first;
    return first && first[hit.prim] != first[hit.prim + 1] && hit.t > PEN_LAST_LAYER_T &&
           pen_layers_met(input, path, hit);
}

/* Adds a path of the wave to those that meet the same part of a primitive. */
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

/* Keeps only the paths of the wave that meet a surface. Paths that meet the same part of a
 * primitive become neighbours, because surfaces of one part are computed in lanes. */
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

/* The paths of the wave, a bit each. */
static ALWAYS_INLINE uint64_t block_all_paths(const struct pen_block_scratch *b)
{
    return b->count < 64 ? (UINT64_C(1) << b->count) - 1 : UINT64_MAX;
}

/* Makes the packet of the wave's paths. */
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

/* Returns a finished path to the pool, if the kernel has paths other than camera rays. */
static ALWAYS_INLINE void block_end_path(struct pen_block_scratch *b, const struct block_path *at,
                                         const unsigned fx)
{
    if (fx & FX_SECONDARY)
        stack_push(&b->unused, b, at);
}

/* Traces the wave, whose packet is set. Paths that meet a surface remain in it. */
static ALWAYS_INLINE void block_trace(const struct pen_kernel_input *input,
                                      struct pen_block_scratch *b, const unsigned fx)
{
    const struct pen_scene *scene = input->scene;
    struct pen_ray_packet *packet = &b->packet;
    const bool no_sky = leaves_out(input, PEN_FX_SKY, fx);
    const bool no_patterns = leaves_out(input, PEN_FX_PATTERNS, fx);
    const uint64_t met = input->trace->nearest_packet(scene->accel, packet);
    b->parts_met = 0;
    for (int i = 0; i < b->count; i++) {
        struct block_path *at = b->wave[i];
        if (!(met >> i & 1) && !no_sky) {
            b->record[at->record].radiance =
                pen_mul(at->path.weight, background_seen(scene, &at->path.ray, fx));
            block_end_path(b, at, fx);
        } else if (!(met >> i & 1) ||
                   (no_patterns && prim_is_patterned(scene, packet->hit[i].prim)) ||
                   is_layered(input, &at->path, packet->hit[i]) ||
                   (refracts(scene, fx) && is_layer_of_solid(scene, packet->hit[i]))) {
            block_defer(b, at);
            block_end_path(b, at, fx);
        } else {
            block_add_point(b, i, packet->hit[i]);
        }
    }
    block_order_points(b);
}

/* Whether a path's next rays are blurred. No wave is made for their number. */
static ALWAYS_INLINE bool block_blurs(const struct pen_kernel_input *input, const struct surface *s,
                                      int lane, const struct path *path, const unsigned fx)
{
    if (!blurs(input, fx) || path->depth + 1 >= input->settings->max_depth)
        return false;
    const struct pen_blur blur = blur_at(input, s, lane, fx);
    return blur.reflection > 0 || blur.transmission > 0;
}

/* Computes the surfaces of the wave. */
static ALWAYS_INLINE void block_surfaces(const struct pen_kernel_input *input,
                                         struct pen_block_scratch *b, const unsigned fx)
{
    for (int g = 0; g < block_groups(b); g++) {
        const struct path *path[LANES];
        const int first = g * LANES, count = block_group_paths(b, g, path);
        surface_at(&b->surface[g], input->scene, path, count, fx);
        unsigned finite = lane_mask_bits(b->surface[g].finite);
        if (fx & FX_SECONDARY)
            finite &= ~lane_mask_bits(b->surface[g].corner);
        for (int i = 0; i < count; i++)
            if (!(finite >> i & 1) || block_blurs(input, &b->surface[g], i, path[i], fx))
                block_defer(b, b->wave[first + i]);
    }
}

static ALWAYS_INLINE void block_set_transmittance(struct pen_block_scratch *b, int point,
                                                  struct pen_vec3 t)
{
    b->transmittance[0][point] = t.x;
    b->transmittance[1][point] = t.y;
    b->transmittance[2][point] = t.z;
}

/* The transmittance of a shadow ray of the packet whose query has results. */
static ALWAYS_INLINE struct pen_vec3 block_shadow_colour(const struct pen_kernel_input *input,
                                                         struct pen_block_scratch *b, int i,
                                                         const unsigned fx)
{
    const struct pen_vec3 white = {1, 1, 1};
    struct pen_ray ray;
    if ((fx & PEN_FX_PATTERNS) || b->query[i].overflow)
        pen_ray_array_get(&b->packet.rays, i, &ray);
    return shadow_colour(input, &ray, b->packet.origin[i], &b->query[i], white, fx);
}

/* Traces shadow rays from points of the wave to one hard light. */
static ALWAYS_INLINE void block_hard_shadows(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_block_scratch *b, uint32_t light,
                                             uint64_t points, const unsigned fx)
{
    struct pen_ray_packet *packet = &b->packet;
    uint64_t made = 0;
    packet->light = input->scene->lights[light].position;
    packet->to_point = input->scene->lights[light].positional;
    packet->see_through = fx & PEN_FX_SHADOW_TRANSMITTANCE ? input->scene->see_through : NULL;
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
    b->filtered = (b->passes & packet->recorded) | (points & ~made);
    for (uint64_t left = b->filtered; left; left &= left - 1) {
        const int i = __builtin_ctzll(left);
        const bool traced = made >> i & 1; /* if not, the light is farther than rays reach */
        block_set_transmittance(b, i, traced ? block_shadow_colour(input, b, i, fx) : no_sample());
    }
}

/* The same for a light with a radius, point by point. */
static ALWAYS_INLINE void block_soft_shadows(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_block_scratch *b, uint64_t points,
                                             const unsigned fx)
{
    b->filtered = points;
    for (; points; points &= points - 1) {
        const int i = __builtin_ctzll(points), pixel = b->wave[i]->pixel, g = i / LANES;
        scratch->key.x = (uint32_t)b->x[pixel];
        scratch->key.y = (uint32_t)b->y[pixel];
        if (fx & PEN_FX_ANTI_ALIASING) {
            scratch->key.pixel_sample = b->pixel_sample[pixel];
            scratch->ray = b->ray[pixel];
        }
        scratch->key.node = b->wave[i]->path.node;
        block_set_transmittance(b, i,
                                soft_transmittance(input, scratch, &b->surface[g], i % LANES,
                                                   &b->arriving[g], &b->counts[pixel], fx));
    }
}

/* Multiplies the light that arrives at a group of points by its transmittance. Where that is not
 * set, it is 1 if the light reaches the point, else 0. */
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

/* Adds the contribution of one light at the wave's points. */
static ALWAYS_INLINE void block_light(const struct pen_kernel_input *input,
                                      struct pen_kernel_scratch *scratch,
                                      struct pen_block_scratch *b, uint32_t light,
                                      const unsigned fx)
{
    const struct pen_light *l = &input->scene->lights[light];
    const bool shadows = (fx & PEN_FX_HARD_SHADOWS) && l->shadows;
    uint64_t points = 0;
    for (int g = 0; g < block_groups(b); g++) {
        light_unshadowed(&b->arriving[g], l, &b->surface[g], b->lit[g], fx);
        b->arriving[g].light = light;
        points |= (uint64_t)lane_mask_bits(b->arriving[g].arrives) << (g * LANES);
    }
    if (shadows && points) {
        if ((fx & PEN_FX_SOFT_SHADOWS) && l->soft)
            block_soft_shadows(input, scratch, b, points, fx);
        else
            block_hard_shadows(input, scratch, b, light, points, fx);
    }
    for (int g = 0; g < block_groups(b); g++) {
        if (!group_bits(points, g))
            continue;
        if (shadows)
            block_filter(b, g);
        b->radiance[g] =
            lanes3_select(b->arriving[g].arrives, lanes3_add(b->radiance[g], b->arriving[g].term),
                          b->radiance[g]);
    }
}

/* Sets the starts of shadow rays: the wave's points, which are ordered by primitive and part. */
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

/* Computes the radiance of the wave's points, as shade_surface of the pixel kernel. */
static ALWAYS_INLINE void block_shade(const struct pen_kernel_input *input,
                                      struct pen_kernel_scratch *scratch,
                                      struct pen_block_scratch *b, const unsigned fx)
{
    bool any = false;
    for (int g = 0; g < block_groups(b); g++) {
        const bool primary =
            b->wave[g * LANES]->path.depth == 0; /* all of the wave have the same depth */
        b->radiance[g] = light_emitted(input->scene, &b->surface[g], primary, fx);
        b->lit[g] = surface_lit(&b->surface[g]);
        if (fx & PEN_FX_HARD_SHADOWS)
            b->hard_rays[g] = lanes_splat(0);
        any |= lane_mask_bits(b->lit[g]) != 0;
    }
    if ((fx & PEN_FX_HARD_SHADOWS) && any) {
        block_start_at_points(b);
    }
    for (uint32_t light = 0; light < input->scene->light_count && any; light++)
        block_light(input, scratch, b, light, fx);
}

static ALWAYS_INLINE struct media *block_media(const struct pen_kernel_scratch *scratch,
                                               const struct block_path *path)
{
    return media_at(scratch, media_of_pool(scratch) + (size_t)(path - scratch->block->pool));
}

/* Computes the reflection and refraction of a group of points; `deeper`: those whose paths
 * continue. */
static ALWAYS_INLINE void block_refract(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch,
                                        struct pen_block_scratch *b, int g, unsigned deeper,
                                        struct refraction *bend, const unsigned fx)
{
    const struct surface *s = &b->surface[g];
    refraction_begin(bend, s, input->scene, fx);
    for (unsigned left = refracts(input->scene, fx) ? deeper : 0; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        const struct block_path *at = b->wave[g * LANES + i];
        if (!is_black(bend->kt[i]))
            refraction_cross(bend, input->scene, s, i, block_media(scratch, at),
                             &b->counts[at->pixel]);
    }
    refraction_end(bend, s, input->scene, fx);
}

/* Puts the reflected paths of a group of points on their stack. Defers pixels without room for one.
 */
static ALWAYS_INLINE void block_reflect(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch,
                                        struct pen_block_scratch *b, int g,
                                        const struct refraction *bend, unsigned points,
                                        const struct path *const *path, const unsigned fx)
{
    struct block_path *const *at = &b->wave[g * LANES];
    struct block_path *made[LANES];
    struct path *reflected[LANES];
    for (int i = 0; i < LANES; i++) {
        if (!(points >> i & 1))
            continue;
        made[i] = block_path_new(b);
        if (!made[i]) {
            block_defer(b, at[i]);
            points &= ~(1u << i);
            continue;
        }
        made[i]->pixel = at[i]->pixel;
        reflected[i] = &made[i]->path;
    }
    points = paths_reflect(input, &b->surface[g], bend, points, path, reflected, fx);
    for (; points; points &= points - 1) {
        const int i = __builtin_ctz(points);
        if (refracts(input->scene, fx))
            media_copy(block_media(scratch, made[i]), block_media(scratch, at[i]));
        b->counts[at[i]->pixel].reflection++;
        block_push(b, &b->reflected, made[i], &b->record[at[i]->record].reflected);
    }
}

/* Continues a path through the surface, or ends it. */
static ALWAYS_INLINE void block_transmit(const struct pen_kernel_input *input,
                                         struct pen_kernel_scratch *scratch,
                                         struct pen_block_scratch *b, struct block_path *at,
                                         const struct surface *s, const struct refraction *bend,
                                         int lane, bool deeper, const unsigned fx)
{
    if (deeper && !(b->deferred >> at->pixel & 1) &&
        path_transmit(input, &at->path, s, bend, lane, fx)) {
        if (refracts(input->scene, fx))
            refraction_pass(input->scene, s, lane, block_media(scratch, at));
        b->counts[at->pixel].transmission++;
        block_push(b, &b->transmitted, at, &b->record[at->record].transmitted);
    } else {
        block_end_path(b, at, fx);
    }
}

/* Records the radiance of a group of points, and counts their shadow rays. Returns the points whose
 * paths may continue, a bit each. */
static ALWAYS_INLINE unsigned block_record_points(const struct pen_kernel_input *input,
                                                  struct pen_block_scratch *b, int g,
                                                  const unsigned fx)
{
    unsigned deeper = 0;
    const struct path *path[LANES];
    struct pen_vec3 radiance[LANES];
    double hard_rays[LANES];
    const int first = g * LANES, count = block_group_paths(b, g, path);
    lanes3_store(radiance, b->radiance[g]);
    if (fx & PEN_FX_HARD_SHADOWS)
        lanes_store(hard_rays, b->hard_rays[g]);
    for (int i = 0; i < count; i++) {
        const struct block_path *at = b->wave[first + i];
        b->record[at->record].radiance = pen_mul(path[i]->weight, radiance[i]);
        if (fx & PEN_FX_HARD_SHADOWS)
            b->counts[at->pixel].shadow += (uint64_t)hard_rays[i];
        if (fx & FX_SECONDARY)
            deeper |= (unsigned)(path[i]->depth + 1 < input->settings->max_depth &&
                                 !(b->deferred >> at->pixel & 1))
                      << i;
    }
    return deeper;
}

/* Puts the paths of a group of points on the stacks. */
static ALWAYS_INLINE void block_continue(const struct pen_kernel_input *input,
                                         struct pen_kernel_scratch *scratch,
                                         struct pen_block_scratch *b, int g, unsigned deeper,
                                         const unsigned fx)
{
    const struct surface *s = &b->surface[g];
    const struct path *path[LANES];
    const int first = g * LANES, count = block_group_paths(b, g, path);
    struct refraction bend;
    if (fx & PEN_FX_REFRACTION)
        block_refract(input, scratch, b, g, deeper, &bend, fx);
    if (fx & (PEN_FX_MIRROR | PEN_FX_REFRACTION)) {
        const unsigned points = deeper & paths_reflected(input, s, &bend, path, count, fx);
        if (points)
            block_reflect(input, scratch, b, g, &bend, points, path, fx);
    }
    if (fx & PEN_FX_TRANSMISSION) {
        const struct lanes3 kt =
            surface_colours(s, input->scene, offsetof(struct pen_material, kt), fx);
        deeper &= ~lane_mask_bits(lanes_black(kt));
    } else {
        deeper = 0;
    }
    for (int i = 0; i < count; i++)
        block_transmit(input, scratch, b, b->wave[first + i], s, &bend, i, deeper >> i & 1, fx);
}

/* Renders the surfaces of a wave that has been traced. */
static ALWAYS_INLINE void block_wave(const struct pen_kernel_input *input,
                                     struct pen_kernel_scratch *scratch,
                                     struct pen_block_scratch *b, const unsigned fx)
{
    block_surfaces(input, b, fx);
    block_shade(input, scratch, b, fx);
    for (int g = 0; g < block_groups(b); g++) {
        const unsigned deeper = block_record_points(input, b, g, fx);
        if (fx & FX_SECONDARY)
            block_continue(input, scratch, b, g, deeper, fx);
    }
}

#endif
