/* SPDX-License-Identifier: MIT */
/* Makes and frees a thread's working memory for kernels. */
#include "shade/internal/block_body.h"

#include <stdlib.h>

static bool fill(struct pen_kernel_scratch *scratch, size_t lights, size_t depth)
{
    scratch->last_occluder = calloc(lights + 1, sizeof *scratch->last_occluder);
    scratch->waiting = calloc(depth, sizeof *scratch->waiting);
    scratch->block = calloc(1, sizeof *scratch->block);
    if (!scratch->last_occluder || !scratch->waiting || !scratch->block)
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
    free(scratch->block);
    free(scratch);
}
