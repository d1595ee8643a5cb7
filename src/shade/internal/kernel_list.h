/* SPDX-License-Identifier: MIT */
/* The compiled kernels: one line each, a name and the mask of the effects that it computes. The
 * masks are the sets of effects that real scenes use. A lens and a sky cost almost nothing in a
 * scene without them, so they share masks with other effects. A new kernel is a new line.
 *
 * kernel_isa.c compiles the block kernels of the whole list, once for each instruction set of
 * PEN_ISA_LIST (base/cpu.h). pixel_kernels.c compiles the pixel kernels. Token pasting makes these
 * names from a line's first column:
 *   pen_pixel_<identifier>          in pixel_kernels.c: the kernel's pen_kernel_fn
 *   pen_sample_<identifier>         there: its pen_kernel_sample_fn
 *   block_<identifier>              static in kernel_isa.c: its pen_kernel_block_fn
 *   samples_<identifier>            there: its pen_kernel_samples_fn
 *   pen_kernels_<instruction set>   the table of them
 *
 * The last line must be the kernel of all effects, which covers every other set. */
#ifndef PEN_SHADE_INTERNAL_KERNEL_LIST_H
#define PEN_SHADE_INTERNAL_KERNEL_LIST_H

#include "shade/kernel.h"

enum {
    FX_LIT = PEN_FX_AMBIENT | PEN_FX_SPECULAR, /* lights without shadows, on opaque surfaces */
    FX_HARD = FX_LIT | PEN_FX_HARD_SHADOWS,
    FX_SOFT = FX_HARD | PEN_FX_SOFT_SHADOWS,
    FX_GLASS = PEN_FX_SHADOW_TRANSMITTANCE | PEN_FX_TRANSMISSION,
    FX_MIRROR = PEN_FX_MIRROR,
    FX_SMOOTH = PEN_FX_ANTI_ALIASING,
    FX_LENS = FX_SMOOTH | PEN_FX_DEPTH_OF_FIELD,
    FX_ALL = FX_SOFT | FX_GLASS | FX_MIRROR | FX_SMOOTH | PEN_FX_SKY | PEN_FX_DEPTH_OF_FIELD |
             PEN_FX_PATTERNS | PEN_FX_REFRACTION | PEN_FX_GLOSSY | PEN_FX_FROSTED |
             PEN_FX_SMOOTH_NORMALS
};
_Static_assert(FX_ALL == (1 << PEN_FX_COUNT) - 1, "a new effect belongs to the last kernel");

/* X(identifier, name in statistics, mask) */
#define PEN_KERNEL_LIST(X)                                                                         \
    X(lit, "lit", FX_LIT)                                                                          \
    X(hard, "hard", FX_HARD)                                                                       \
    X(hard_mirror, "hard+mirror", FX_HARD | FX_MIRROR)                                             \
    X(hard_glass, "hard+glass", FX_HARD | FX_GLASS)                                                \
    X(hard_glass_mirror, "hard+glass+mirror", FX_HARD | FX_GLASS | FX_MIRROR)                      \
    X(hard_smooth, "hard+smooth", FX_HARD | FX_SMOOTH)                                             \
    X(hard_all, "hard+all", FX_HARD | FX_GLASS | FX_MIRROR | FX_SMOOTH)                            \
    X(hard_sky, "hard+sky", FX_HARD | PEN_FX_SKY)                                                  \
    X(hard_patterns, "hard+patterns", FX_HARD | PEN_FX_PATTERNS)                                   \
    X(hard_patterns_lens, "hard+patterns+lens+sky",                                                \
      FX_HARD | PEN_FX_PATTERNS | FX_LENS | PEN_FX_SKY)                                            \
    X(hard_lens, "hard+lens+sky", FX_HARD | FX_LENS | PEN_FX_SKY)                                  \
    X(hard_glass_mirror_sky, "hard+glass+mirror+sky", FX_HARD | FX_GLASS | FX_MIRROR | PEN_FX_SKY) \
    X(hard_glass_mirror_lens, "hard+glass+mirror+lens", FX_HARD | FX_GLASS | FX_MIRROR | FX_LENS)  \
    X(hard_glass_mirror_patterns, "hard+glass+mirror+patterns+sky",                                \
      FX_HARD | FX_GLASS | FX_MIRROR | PEN_FX_PATTERNS | PEN_FX_SKY)                               \
    X(hard_refraction_sky, "hard+refraction+sky",                                                  \
      FX_HARD | FX_GLASS | FX_MIRROR | PEN_FX_REFRACTION | PEN_FX_SKY)                             \
    X(hard_refraction, "hard+refraction",                                                          \
      FX_HARD | FX_GLASS | FX_MIRROR | PEN_FX_REFRACTION | PEN_FX_SKY | PEN_FX_PATTERNS)           \
    X(hard_mirror_lens, "hard+mirror+lens+sky", FX_HARD | FX_MIRROR | FX_LENS | PEN_FX_SKY)        \
    X(hard_blur, "hard+refraction+blur",                                                           \
      FX_HARD | FX_GLASS | FX_MIRROR | FX_SMOOTH | PEN_FX_REFRACTION | PEN_FX_GLOSSY |             \
          PEN_FX_FROSTED | PEN_FX_SKY | PEN_FX_PATTERNS)                                           \
    X(hard_normals, "hard+smooth+normals", FX_HARD | FX_SMOOTH | PEN_FX_SMOOTH_NORMALS)            \
    X(soft, "soft", FX_SOFT)                                                                       \
    X(soft_mirror, "soft+mirror", FX_SOFT | FX_MIRROR)                                             \
    X(soft_glass, "soft+glass", FX_SOFT | FX_GLASS)                                                \
    X(soft_glass_mirror, "soft+glass+mirror", FX_SOFT | FX_GLASS | FX_MIRROR)                      \
    X(soft_smooth, "soft+smooth", FX_SOFT | FX_SMOOTH)                                             \
    X(soft_all, "soft+all", FX_SOFT | FX_GLASS | FX_MIRROR | FX_SMOOTH)                            \
    X(soft_sky, "soft+sky", FX_SOFT | PEN_FX_SKY)                                                  \
    X(soft_patterns, "soft+patterns", FX_SOFT | PEN_FX_PATTERNS)                                   \
    X(soft_patterns_lens, "soft+patterns+lens+sky",                                                \
      FX_SOFT | PEN_FX_PATTERNS | FX_LENS | PEN_FX_SKY)                                            \
    X(soft_lens, "soft+lens+sky", FX_SOFT | FX_LENS | PEN_FX_SKY)                                  \
    X(soft_glass_mirror_patterns, "soft+glass+mirror+patterns",                                    \
      FX_SOFT | FX_GLASS | FX_MIRROR | PEN_FX_PATTERNS)                                            \
    X(soft_glass_mirror_lens, "soft+glass+mirror+lens", FX_SOFT | FX_GLASS | FX_MIRROR | FX_LENS)  \
    X(all, "all", FX_ALL)

#define PEN_KERNEL_COUNT_ONE(identifier, name, mask) +1
enum { PEN_KERNEL_COUNT = 0 PEN_KERNEL_LIST(PEN_KERNEL_COUNT_ONE) };
#undef PEN_KERNEL_COUNT_ONE

#define PEN_KERNEL_DECLARE(identifier, name, mask)                                                 \
    extern pen_kernel_fn pen_pixel_##identifier;                                                   \
    extern pen_kernel_sample_fn pen_sample_##identifier;
PEN_KERNEL_LIST(PEN_KERNEL_DECLARE)
#undef PEN_KERNEL_DECLARE

/* One table for each instruction set, in the list's order. */
#define PEN_KERNEL_DECLARE(UPPER, lower, ...)                                                      \
    extern const struct pen_kernel pen_kernels_##lower[PEN_KERNEL_COUNT];
PEN_ISA_LIST(PEN_KERNEL_DECLARE)
#undef PEN_KERNEL_DECLARE

#endif
