/* SPDX-License-Identifier: MIT */
/* What a render and its layers and forecasts share: what kernels read, for one view; how many
 * threads take part; and the pixels of a block. */
#ifndef PEN_RENDER_INTERNAL_KERNEL_INPUT_H
#define PEN_RENDER_INTERNAL_KERNEL_INPUT_H

#include "base/thread_pool.h"
#include "math/rect.h"
#include "shade/kernel.h"

/* Computed in default arithmetic whatever the calling thread's state. */
struct pen_kernel_input pen_kernel_input_of(const struct pen_scene *scene, int view,
                                            const struct pen_settings *settings);

/* The threads of the pool that the settings let take part. */
int pen_render_threads(const struct pen_thread_pool *pool, const struct pen_settings *settings);

/* Renders a block of pixels, row by row: together where the kernel's queries have packets, else one
 * by one. Adds to *rays. */
void pen_render_block(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                      struct pen_kernel_scratch *scratch, struct pen_rect block, double (*rgb)[3],
                      struct pen_ray_counts *rays);

#endif
