/* SPDX-License-Identifier: MIT */
/* Makes and frees a thread's working memory for kernels. */
#include "shade/internal/scratch.h"

#include <stdlib.h>

/* Vectors of the widest instruction set are aligned to their size. */
enum { BLOCK_ALIGN = 64 };

/* The bytes that the block kernels of any instruction set need. */
static size_t block_bytes(void)
{
    size_t bytes = 0;
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct pen_kernel *kernel = pen_kernel_select(0, (enum pen_isa)isa);
        bytes = kernel->block_bytes > bytes ? kernel->block_bytes : bytes;
    }
    return bytes;
}

/* Memory of calloc, since its pages are not touched before they are used, from the first aligned
 * address on. */
static bool block_new(struct pen_kernel_scratch *scratch)
{
    scratch->block_memory = calloc(1, block_bytes() + BLOCK_ALIGN);
    if (!scratch->block_memory)
        return false;
    const size_t past = (uintptr_t)scratch->block_memory % BLOCK_ALIGN;
    scratch->block = (void *)((char *)scratch->block_memory + (BLOCK_ALIGN - past) % BLOCK_ALIGN);
    return true;
}

static bool fill(struct pen_kernel_scratch *scratch, size_t lights, size_t depth)
{
    scratch->last_occluder = calloc(lights + 1, sizeof *scratch->last_occluder);
    scratch->waiting = calloc(depth, sizeof *scratch->waiting);
    if (!scratch->last_occluder || !scratch->waiting || !block_new(scratch))
        return false;
    for (size_t i = 0; i < lights; i++)
        scratch->last_occluder[i] = PEN_NO_PRIM;
    return true;
}

struct pen_kernel_scratch *pen_kernel_scratch_new(const struct pen_kernel_input *input)
{
    int depth = input->settings->max_depth;
    struct pen_kernel_scratch *scratch = calloc(1, sizeof *scratch);
    if (scratch && fill(scratch, input->scene->light_count, depth > 0 ? (size_t)depth : 1)) {
        scratch->surfaces_max = pen_tree_surfaces_max(input->settings);
        return scratch;
    }
    pen_kernel_scratch_free(scratch);
    return NULL;
}

void pen_kernel_scratch_free(struct pen_kernel_scratch *scratch)
{
    if (!scratch)
        return;
    free(scratch->last_occluder);
    free(scratch->waiting);
    free(scratch->block_memory);
    free(scratch);
}
