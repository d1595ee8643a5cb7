/* SPDX-License-Identifier: MIT */
/* The kernel `hard` stripped by hand: lights with hard shadows. */
#ifndef TESTS_EFFECTS_STRIPPED_HARD_H
#define TESTS_EFFECTS_STRIPPED_HARD_H

#include "effects/stripped/shadows.h"
#include "effects/stripped/stripped.h"

void stripped_hard(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   struct pen_rect rect, double (*rgb)[3], struct pen_ray_counts *counts)
{
    struct pen_block_scratch *b = scratch->block;
    const int pixels = block_begin(input, b, rect, counts);
    block_trace(input, b);
    block_surfaces(input, b);
    const uint32_t lights = block_begin_lights(input, b) ? input->scene->light_count : 0;
    for (uint32_t light = 0; light < lights; light++)
        block_light_hard(input, scratch, b, light);
    for (int g = 0; g < block_groups(b); g++)
        block_record_points(b, g);
    block_end(input, scratch, rect, pixels, rgb, counts, pen_sample_hard);
}

#endif
