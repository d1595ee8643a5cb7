/* SPDX-License-Identifier: MIT */
/* Rounds of adaptive rendering, block by block. */
#ifndef PEN_RENDER_INTERNAL_REFINE_H
#define PEN_RENDER_INTERNAL_REFINE_H

#include "render/internal/beams.h"
#include "render/render.h"

/* Samples `first` to `end` - 1 of a pixel's sequence, and the sums to add them to. `first` is 0 or
 * half of `end`. */
struct pen_sample_range {
    int x, y;
    uint32_t replicate; /* the number of the sequence */
    uint32_t first, end;
    struct pen_pixel_sums *sums;   /* of the samples before `first` */
    const struct pen_beams *beams; /* NULL: the samples look for no things */
};

/* Traces the samples of some pixels, PEN_KERNEL_SAMPLES at a time across pixels, and adds them to
 * their sums. The halves of the sums are then those of all samples up to `end`. Neighbours in the
 * list should be near one another in the image.
 * Threads: any number, with different scratch memory, sums and counts. */
void pen_trace_samples(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                       struct pen_kernel_scratch *scratch, const struct pen_sample_range *ranges,
                       int count, struct pen_ray_counts *rays);

/* The x of pixel i of a block of PEN_BLOCK_SIDE squared along a Z-order curve. Its y is
 * pen_z_order_x(i / 2). */
int pen_z_order_x(int i);

/* Takes the samples of one round for the wanted pixels of a block; then sets their estimates and
 * their colours in the image. The task has a state.
 * Threads: any number, for different blocks. */
void pen_refine_block(const struct pen_render_task *task, const struct pen_kernel *kernel,
                      const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                      struct pen_rect block, int thread, struct pen_ray_counts *rays);

/* Renders all rounds of a task, as pen_render_run. */
bool pen_render_to_target(struct pen_thread_pool *pool, const struct pen_render_task *task,
                          struct pen_render_stats *stats, struct pen_status *st);

#endif
