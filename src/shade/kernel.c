/* SPDX-License-Identifier: MIT */
/* The kernel for a scene: the one with the fewest effects among those that cover the scene's
 * effects. The last kernel of the list has every effect, so there is always one. */
#include "shade/kernel.h"

#include "shade/internal/kernel_list.h"

static const struct pen_kernel *table_of(enum pen_isa isa)
{
#define TABLE_ROW(UPPER, lower, ...) [PEN_ISA_##UPPER] = pen_kernels_##lower,
    static const struct pen_kernel *const table[PEN_ISA_COUNT] = {PEN_ISA_LIST(TABLE_ROW)};
#undef TABLE_ROW
    return table[isa];
}

const struct pen_kernel *pen_kernel_at(int index, enum pen_isa isa)
{
    return index >= 0 && index < PEN_KERNEL_COUNT ? &table_of(isa)[index] : NULL;
}

const struct pen_kernel *pen_kernel_select(unsigned effects, enum pen_isa isa)
{
    const struct pen_kernel *table = table_of(isa), *best = &table[PEN_KERNEL_COUNT - 1];
    for (int i = 0; i < PEN_KERNEL_COUNT; i++)
        if ((effects & ~table[i].effects) == 0 &&
            __builtin_popcount(table[i].effects) < __builtin_popcount(best->effects))
            best = &table[i];
    return best;
}
