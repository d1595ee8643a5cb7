/* SPDX-License-Identifier: MIT */
/* The kernel `soft` stripped by hand: lights with hard and soft shadows. */
#ifndef TESTS_EFFECTS_STRIPPED_KERNEL_SOFT_H
#define TESTS_EFFECTS_STRIPPED_KERNEL_SOFT_H

#include "effects/stripped/soft.h"
#include "effects/stripped/stripped.h"

static ALWAYS_INLINE void block_soft_shadows(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_block_scratch *b, uint64_t points)
{
    b->filtered = points;
    for (; points; points &= points - 1) {
        const int i = __builtin_ctzll(points), pixel = b->wave[i]->pixel, g = i / LANES;
        scratch->key.x = (uint32_t)b->x[pixel];
        scratch->key.y = (uint32_t)b->y[pixel];
        scratch->key.node = b->wave[i]->path.node;
        block_set_transmittance(b, i,
                                samples_mean(input, scratch, &b->surface[g], i % LANES,
                                             &b->arriving[g], &b->counts[pixel]));
    }
}

static ALWAYS_INLINE void block_light_soft(const struct pen_kernel_input *input,
                                           struct pen_kernel_scratch *scratch,
                                           struct pen_block_scratch *b, uint32_t light)
{
    const struct pen_light *l = &input->scene->lights[light];
    const uint64_t points = block_unshadowed(input, b, light);
    if (l->shadows && points) {
        if (l->soft)
            block_soft_shadows(input, scratch, b, points);
        else
            block_hard_shadows(input, scratch, b, light, points);
    }
    block_add_shadowed(b, points, l->shadows);
}

void stripped_soft(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   struct pen_rect rect, double (*rgb)[3], struct pen_ray_counts *counts)
{
    struct pen_block_scratch *b = scratch->block;
    scratch->key =
        (struct pen_sample_key){.seed = input->settings->seed, .purpose = PEN_PURPOSE_LIGHT};
    const int pixels = block_begin(input, b, rect, counts);
    block_trace(input, b);
    block_surfaces(input, b);
    const uint32_t lights = block_begin_lights(input, b) ? input->scene->light_count : 0;
    for (uint32_t light = 0; light < lights; light++)
        block_light_soft(input, scratch, b, light);
    for (int g = 0; g < block_groups(b); g++)
        block_record_points(b, g);
    block_end(input, scratch, rect, pixels, rgb, counts, pen_sample_soft);
}

#endif
