/* SPDX-License-Identifier: MIT */
/* The pixel kernels of the list, for all instruction sets. */
#include "shade/internal/kernel_body.h"
#include "shade/internal/kernel_list.h"

#define PIXEL_FUNCTIONS(identifier, name, mask)                                                    \
    void pen_pixel_##identifier(const struct pen_kernel_input *input,                              \
                                struct pen_kernel_scratch *scratch, int x, int y, double rgb[3],   \
                                struct pen_ray_counts *counts)                                     \
    {                                                                                              \
        kernel_pixel(input, scratch, x, y, rgb, counts, pen_sample_##identifier, mask);            \
    }                                                                                              \
    struct pen_vec3 pen_sample_##identifier(                                                       \
        const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,                  \
        struct pen_camera_point at, struct pen_ray_counts *counts)                                 \
    {                                                                                              \
        return trace_paths(input, scratch, at, counts, mask);                                      \
    }
PEN_KERNEL_LIST(PIXEL_FUNCTIONS)
