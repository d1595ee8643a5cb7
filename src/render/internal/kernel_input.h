/* SPDX-License-Identifier: MIT */
/* Common to a render and its layers and forecasts: the kernel input of one view, the number of
 * threads, and the pixels of a block. */
#ifndef PEN_RENDER_INTERNAL_KERNEL_INPUT_H
#define PEN_RENDER_INTERNAL_KERNEL_INPUT_H

#include "base/thread_pool.h"
#include "math/rect.h"
#include "shade/kernel.h"

/* Makes the kernel input, in default arithmetic, for any floating-point state of the calling
 * thread. */
struct pen_kernel_input pen_kernel_input_of(const struct pen_scene *scene, int view,
                                            const struct pen_settings *settings);

/* The number of threads of the pool that the settings allow. */
int pen_render_threads(const struct pen_thread_pool *pool, const struct pen_settings *settings);

/* Renders a block of pixels, row by row: together if the kernel's queries have packets, else one by
 * one. Adds to *rays. */
void pen_render_block(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                      struct pen_kernel_scratch *scratch, struct pen_rect block, double (*rgb)[3],
                      struct pen_ray_counts *rays);

#endif
