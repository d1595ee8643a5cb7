/* SPDX-License-Identifier: MIT */
/* The block kernels of the list, and the table of all kernels, pen_kernels_<instruction set>.
 * Compiled once for each instruction set, PEN_ISA (base/cpu.h). */
#include "shade/internal/block_body.h"
#include "shade/internal/kernel_list.h"

#define BLOCK_FUNCTIONS(identifier, name, mask)                                                    \
    static void block_##identifier(const struct pen_kernel_input *input,                           \
                                   struct pen_kernel_scratch *scratch, struct pen_rect rect,       \
                                   double(*rgb)[3], struct pen_ray_counts *counts)                 \
    {                                                                                              \
        kernel_block(input, scratch, rect, rgb, counts, pen_sample_##identifier, mask);            \
    }                                                                                              \
    static void samples_##identifier(const struct pen_kernel_input *input,                         \
                                     struct pen_kernel_scratch *scratch,                           \
                                     const struct pen_camera_sample *samples, int count,           \
                                     struct pen_vec3 *radiance, struct pen_ray_counts *counts)     \
    {                                                                                              \
        kernel_samples(input, scratch, samples, count, radiance, counts, pen_sample_##identifier,  \
                       mask);                                                                      \
    }
PEN_KERNEL_LIST(BLOCK_FUNCTIONS)

#define NAME_OF_ISA(isa) NAME_OF_TOKEN(isa)
#define NAME_OF_TOKEN(token) #token
#define TABLE_OF_ISA(isa) TABLE_OF_TOKEN(isa)
#define TABLE_OF_TOKEN(token) pen_kernels_##token

#define TABLE_ROW(identifier, kernel_name, mask)                                                   \
    {.name = kernel_name "/" NAME_OF_ISA(PEN_ISA),                                                 \
     .effects = mask,                                                                              \
     .pixel = pen_pixel_##identifier,                                                              \
     .sample = pen_sample_##identifier,                                                            \
     .block = block_##identifier,                                                                  \
     .samples = (mask)&PEN_FX_ANTI_ALIASING ? samples_##identifier : NULL,                         \
     .block_bytes = sizeof(struct pen_block_scratch)},
const struct pen_kernel TABLE_OF_ISA(PEN_ISA)[PEN_KERNEL_COUNT] = {PEN_KERNEL_LIST(TABLE_ROW)};
