/* SPDX-License-Identifier: MIT */
/* Kernels: the radiance of pixels, by the equations of shading-model.md. The kernel body is one
 * inlined function taking a constant effect mask; each compiled instance contains only the
 * effects of its mask, and pen_kernel_select picks the smallest instance that covers what a
 * scene calls for. All instances and all compiled variants give the same bits. */
#ifndef PEN_SHADE_KERNEL_H
#define PEN_SHADE_KERNEL_H

#include <stdint.h>

#include "scene/scene.h"

/* Rays by kind, as shading-model.md counts them. */
struct pen_ray_counts {
    uint64_t primary, shadow, reflection, transmission;
    uint64_t dropped_samples; /* non-finite pixel samples, left out of the mean; expected 0 */
};

/* What a kernel reads; shared by all threads, immutable. */
struct pen_kernel_input {
    const struct pen_scene *scene;
    const struct pen_settings *settings;
    struct pen_pinhole pinhole;
    unsigned effects;
    const struct pen_trace_ops *trace;
};

/* Memory of one thread: the stack of pending secondary rays and the last occluders. */
struct pen_kernel_scratch;

struct pen_kernel_scratch *pen_kernel_scratch_new(const struct pen_kernel_input *input);
void pen_kernel_scratch_free(struct pen_kernel_scratch *scratch);

/* One pixel: the mean of its samples, linear RGB in double, and its rays added to *counts.
 * The result is a pure function of (scene, settings, x, y). */
typedef void pen_kernel_fn(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                           int x, int y, double rgb[3], struct pen_ray_counts *counts);

struct pen_kernel {
    const char *name; /* e.g. "hard+mirror/avx2": shown in statistics */
    unsigned effects; /* the instance's mask */
    pen_kernel_fn *pixel;
};

/* The instances one by one, for tests and reports; NULL behind the last. The instances for an
 * instruction set run on processors that have it (pen_cpu_isa). */
const struct pen_kernel *pen_kernel_at(int index, enum pen_isa isa);

/* The smallest instance covering the effects, for an instruction set. Never NULL. */
const struct pen_kernel *pen_kernel_select(unsigned effects, enum pen_isa isa);

#endif
