/* SPDX-License-Identifier: MIT */
/* The kernel's instance for lights without shadows, on surfaces that neither mirror nor let light
 * pass, compiled for AVX2. */
#include "shade/internal/instances.h"
#include "shade/internal/kernel_body.h"

void pen_kernel_lit_avx2(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                         int x, int y, double rgb[3], struct pen_ray_counts *counts)
{
    kernel_pixel(input, scratch, x, y, rgb, counts, FX_LIT);
}
