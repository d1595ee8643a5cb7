/* SPDX-License-Identifier: MIT */
/* What kernels read, for one view. */
#ifndef PEN_RENDER_INTERNAL_KERNEL_INPUT_H
#define PEN_RENDER_INTERNAL_KERNEL_INPUT_H

#include "shade/kernel.h"

/* Computed in default arithmetic whatever the calling thread's state. */
struct pen_kernel_input pen_kernel_input_of(const struct pen_scene *scene, int view,
                                            const struct pen_settings *settings);

#endif
