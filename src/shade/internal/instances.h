/* SPDX-License-Identifier: MIT */
/* The instances of the kernel: their masks and their functions. The masks are the sets of effects
 * that scenes really call for; kernel.c has the table. */
#ifndef PEN_SHADE_INTERNAL_INSTANCES_H
#define PEN_SHADE_INTERNAL_INSTANCES_H

#include "shade/kernel.h"

enum {
    FX_LIT = PEN_FX_AMBIENT | PEN_FX_SPECULAR,
    FX_HARD = FX_LIT | PEN_FX_HARD_SHADOWS,
    FX_HARD_MIRROR = FX_HARD | PEN_FX_MIRROR,
    FX_HARD_GLASS = FX_HARD | PEN_FX_SHADOW_TRANSMITTANCE | PEN_FX_TRANSMISSION,
    FX_HARD_GLASS_MIRROR = FX_HARD_GLASS | PEN_FX_MIRROR,
    FX_HARD_SMOOTH = FX_HARD | PEN_FX_ANTI_ALIASING,
    FX_SOFT = FX_HARD | PEN_FX_SOFT_SHADOWS,
    FX_SOFT_MIRROR = FX_SOFT | PEN_FX_MIRROR,
    FX_SOFT_GLASS = FX_SOFT | PEN_FX_SHADOW_TRANSMITTANCE | PEN_FX_TRANSMISSION,
    FX_SOFT_GLASS_MIRROR = FX_SOFT_GLASS | PEN_FX_MIRROR,
    FX_SOFT_SMOOTH = FX_SOFT | PEN_FX_ANTI_ALIASING,
    FX_HARD_ALL = FX_HARD_GLASS_MIRROR | PEN_FX_ANTI_ALIASING,
    FX_ALL = FX_HARD_ALL | PEN_FX_SOFT_SHADOWS
};

pen_kernel_fn pen_kernel_lit;
pen_kernel_fn pen_kernel_hard;
pen_kernel_fn pen_kernel_hard_mirror;
pen_kernel_fn pen_kernel_hard_glass;
pen_kernel_fn pen_kernel_hard_glass_mirror;
pen_kernel_fn pen_kernel_hard_smooth;
pen_kernel_fn pen_kernel_hard_all;
pen_kernel_fn pen_kernel_soft;
pen_kernel_fn pen_kernel_soft_mirror;
pen_kernel_fn pen_kernel_soft_glass;
pen_kernel_fn pen_kernel_soft_glass_mirror;
pen_kernel_fn pen_kernel_soft_smooth;
pen_kernel_fn pen_kernel_all;

pen_kernel_fn pen_kernel_lit_avx2;
pen_kernel_fn pen_kernel_hard_avx2;
pen_kernel_fn pen_kernel_hard_mirror_avx2;
pen_kernel_fn pen_kernel_hard_glass_avx2;
pen_kernel_fn pen_kernel_hard_glass_mirror_avx2;
pen_kernel_fn pen_kernel_hard_smooth_avx2;
pen_kernel_fn pen_kernel_hard_all_avx2;
pen_kernel_fn pen_kernel_soft_avx2;
pen_kernel_fn pen_kernel_soft_mirror_avx2;
pen_kernel_fn pen_kernel_soft_glass_avx2;
pen_kernel_fn pen_kernel_soft_glass_mirror_avx2;
pen_kernel_fn pen_kernel_soft_smooth_avx2;
pen_kernel_fn pen_kernel_all_avx2;

#endif
