/* SPDX-License-Identifier: MIT */
/* The kernel `hard+mirror` stripped by hand: lights with hard shadows, and reflected rays. */
#ifndef TESTS_EFFECTS_STRIPPED_MIRROR_H
#define TESTS_EFFECTS_STRIPPED_MIRROR_H

#include "effects/stripped/shadows.h"
#include "effects/stripped/stripped.h"

/* Paths that end are kept, for reflected paths. */
static ALWAYS_INLINE void mirror_trace(const struct pen_kernel_input *input,
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
            stack_push(&b->unused, b, at);
        } else if (is_layered(input, &at->path, packet->hit[i])) {
            block_defer(b, at);
            stack_push(&b->unused, b, at);
        } else {
            block_add_point(b, i, packet->hit[i]);
        }
    }
    block_order_points(b);
}

static ALWAYS_INLINE bool contributes(const struct pen_kernel_input *input, struct pen_vec3 w)
{
    double least = input->settings->min_contribution;
    return (w.x > 0 && w.x >= least) || (w.y > 0 && w.y >= least) || (w.z > 0 && w.z >= least);
}

static ALWAYS_INLINE struct pen_vec3 weight_of(const struct pen_kernel_input *input,
                                               const struct surface *s, int lane,
                                               const struct path *path)
{
    return pen_mul(path->weight, input->scene->materials[s->material[lane]].kr);
}

/* Returns those points of s that reflect their paths. */
static ALWAYS_INLINE unsigned reflecting(const struct pen_kernel_input *input,
                                         const struct surface *s, const struct path *const *path,
                                         int count)
{
    const lane_mask mirrors = lane_mask_not(
        lanes_black(point_colours(s, input->scene, offsetof(struct pen_material, kr))));
    unsigned reflected = 0;
    if (!lane_mask_bits(mirrors))
        return 0;
    const lane_mask sure =
        lanes_less(lanes_splat(PEN_HORIZON_SINE), -s->nv) & lane_mask_not(surface_viewer_grazes(s));
    unsigned left = lane_mask_bits(mirrors & sure) & LANES_ALL >> (LANES - count);
    for (; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        if (contributes(input, weight_of(input, s, i, path[i])))
            reflected |= 1u << i;
    }
    return reflected;
}

static ALWAYS_INLINE unsigned reflect_paths(const struct pen_kernel_input *input,
                                            const struct surface *s, unsigned points,
                                            const struct path *const *path,
                                            struct path *const *reflected)
{
    struct pen_ray *ray[LANES], nowhere;
    for (int i = 0; i < LANES; i++) {
        ray[i] = points >> i & 1 ? &reflected[i]->ray : &nowhere;
        if (!(points >> i & 1))
            continue;
        reflected[i]->origin = surface_origin(s, i, false);
        reflected[i]->after = pen_after_start;
        reflected[i]->weight = weight_of(input, s, i, path[i]);
        reflected[i]->depth = path[i]->depth + 1;
    }
    const struct lanes3 d = lanes3_along(s->v, s->n, -2 * s->nv);
    return points & lane_mask_bits(lanes_ray_make(ray, s->p, d));
}

static ALWAYS_INLINE void block_reflect(const struct pen_kernel_input *input,
                                        struct pen_block_scratch *b, int g, unsigned points,
                                        const struct path *const *path)
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
    points = reflect_paths(input, &b->surface[g], points, path, reflected);
    for (; points; points &= points - 1) {
        const int i = __builtin_ctz(points);
        b->counts[at[i]->pixel].reflection++;
        block_push(b, &b->reflected, made[i], &b->record[at[i]->record].reflected);
    }
}

static ALWAYS_INLINE void block_continue(const struct pen_kernel_input *input,
                                         struct pen_block_scratch *b, int g)
{
    const struct path *path[LANES];
    const int first = g * LANES, count = block_group_paths(b, g, path);
    unsigned deeper = 0;
    for (int i = 0; i < count; i++)
        deeper |= (unsigned)(path[i]->depth + 1 < input->settings->max_depth &&
                             !(b->deferred >> b->wave[first + i]->pixel & 1))
                  << i;
    const unsigned points = deeper & reflecting(input, &b->surface[g], path, count);
    if (points)
        block_reflect(input, b, g, points, path);
    for (int i = 0; i < count; i++)
        stack_push(&b->unused, b, b->wave[first + i]);
}

static ALWAYS_INLINE void block_wave(const struct pen_kernel_input *input,
                                     struct pen_kernel_scratch *scratch,
                                     struct pen_block_scratch *b)
{
    mirror_trace(input, b);
    block_surfaces(input, b);
    const uint32_t lights = block_begin_lights(input, b) ? input->scene->light_count : 0;
    for (uint32_t light = 0; light < lights; light++)
        block_light_hard(input, scratch, b, light);
    for (int g = 0; g < block_groups(b); g++) {
        block_record_points(b, g);
        block_continue(input, b, g);
    }
}

void stripped_mirror(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                     struct pen_rect rect, double (*rgb)[3], struct pen_ray_counts *counts)
{
    struct pen_block_scratch *b = scratch->block;
    b->reflected.count = b->unused.count = 0;
    b->used = BLOCK_PIXELS;
    const int pixels = block_begin(input, b, rect, counts);
    block_wave(input, scratch, b);
    while (b->reflected.count > 0) {
        block_take(b, &b->reflected);
        block_set_packet(b);
        block_wave(input, scratch, b);
    }
    block_end(input, scratch, rect, pixels, rgb, counts, pen_sample_hard_mirror);
}

#endif
