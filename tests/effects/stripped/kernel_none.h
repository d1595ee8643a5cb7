/* SPDX-License-Identifier: MIT */
/* The kernel `lit` stripped by hand: lights without shadows. */
#ifndef TESTS_EFFECTS_STRIPPED_NONE_H
#define TESTS_EFFECTS_STRIPPED_NONE_H

#include "effects/stripped/block.h"
#include "effects/stripped/stripped.h"

static ALWAYS_INLINE void record_points(struct pen_block_scratch *b, int g)
{
    struct pen_vec3 radiance[LANES];
    const struct path *path[LANES];
    const int first = g * LANES, count = block_group_paths(b, g, path);
    lanes3_store(radiance, b->radiance[g]);
    for (int i = 0; i < count; i++)
        b->record[b->wave[first + i]->record].radiance = pen_mul(path[i]->weight, radiance[i]);
}

void stripped_none(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   struct pen_rect rect, double (*rgb)[3], struct pen_ray_counts *counts)
{
    struct pen_block_scratch *b = scratch->block;
    const int pixels = block_begin(input, b, rect, counts);
    block_trace(input, b);
    block_surfaces(input, b);
    const uint32_t lights = block_emitted(input, b) ? input->scene->light_count : 0;
    for (uint32_t light = 0; light < lights; light++) {
        const uint64_t points = block_unshadowed(input, b, light);
        for (int g = 0; g < block_groups(b); g++)
            if (group_bits(points, g))
                block_add_light(b, g);
    }
    for (int g = 0; g < block_groups(b); g++)
        record_points(b, g);
    block_end(input, scratch, rect, pixels, rgb, counts, pen_sample_lit);
}

#endif
