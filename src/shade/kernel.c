/* SPDX-License-Identifier: MIT */
/* Which instance of the kernel renders a scene: the one with the fewest effects among those that
 * cover what the scene calls for. The last instance of the table has every effect, so there always
 * is one. */
#include "shade/kernel.h"

#include "shade/internal/instances.h"

enum { INSTANCES = 13 };

static const struct pen_kernel base_table[INSTANCES] = {
    {"lit/base", FX_LIT, pen_kernel_lit},
    {"hard/base", FX_HARD, pen_kernel_hard},
    {"hard+mirror/base", FX_HARD_MIRROR, pen_kernel_hard_mirror},
    {"hard+glass/base", FX_HARD_GLASS, pen_kernel_hard_glass},
    {"hard+glass+mirror/base", FX_HARD_GLASS_MIRROR, pen_kernel_hard_glass_mirror},
    {"hard+smooth/base", FX_HARD_SMOOTH, pen_kernel_hard_smooth},
    {"hard+all/base", FX_HARD_ALL, pen_kernel_hard_all},
    {"soft/base", FX_SOFT, pen_kernel_soft},
    {"soft+mirror/base", FX_SOFT_MIRROR, pen_kernel_soft_mirror},
    {"soft+glass/base", FX_SOFT_GLASS, pen_kernel_soft_glass},
    {"soft+glass+mirror/base", FX_SOFT_GLASS_MIRROR, pen_kernel_soft_glass_mirror},
    {"soft+smooth/base", FX_SOFT_SMOOTH, pen_kernel_soft_smooth},
    {"all/base", FX_ALL, pen_kernel_all},
};

static const struct pen_kernel avx2_table[INSTANCES] = {
    {"lit/avx2", FX_LIT, pen_kernel_lit_avx2},
    {"hard/avx2", FX_HARD, pen_kernel_hard_avx2},
    {"hard+mirror/avx2", FX_HARD_MIRROR, pen_kernel_hard_mirror_avx2},
    {"hard+glass/avx2", FX_HARD_GLASS, pen_kernel_hard_glass_avx2},
    {"hard+glass+mirror/avx2", FX_HARD_GLASS_MIRROR, pen_kernel_hard_glass_mirror_avx2},
    {"hard+smooth/avx2", FX_HARD_SMOOTH, pen_kernel_hard_smooth_avx2},
    {"hard+all/avx2", FX_HARD_ALL, pen_kernel_hard_all_avx2},
    {"soft/avx2", FX_SOFT, pen_kernel_soft_avx2},
    {"soft+mirror/avx2", FX_SOFT_MIRROR, pen_kernel_soft_mirror_avx2},
    {"soft+glass/avx2", FX_SOFT_GLASS, pen_kernel_soft_glass_avx2},
    {"soft+glass+mirror/avx2", FX_SOFT_GLASS_MIRROR, pen_kernel_soft_glass_mirror_avx2},
    {"soft+smooth/avx2", FX_SOFT_SMOOTH, pen_kernel_soft_smooth_avx2},
    {"all/avx2", FX_ALL, pen_kernel_all_avx2},
};

static const struct pen_kernel *table_of(enum pen_isa isa)
{
    return isa == PEN_ISA_AVX2 ? avx2_table : base_table;
}

const struct pen_kernel *pen_kernel_at(int index, enum pen_isa isa)
{
    return index >= 0 && index < INSTANCES ? &table_of(isa)[index] : NULL;
}

const struct pen_kernel *pen_kernel_select(unsigned effects, enum pen_isa isa)
{
    const struct pen_kernel *table = table_of(isa), *best = &table[INSTANCES - 1];
    for (int i = 0; i < INSTANCES; i++)
        if ((effects & ~table[i].effects) == 0 &&
            __builtin_popcount(table[i].effects) < __builtin_popcount(best->effects))
            best = &table[i];
    return best;
}
