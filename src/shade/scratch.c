/* SPDX-License-Identifier: MIT */
/* Makes and frees a thread's working memory for kernels. */
#include "shade/internal/scratch.h"

#include <stdlib.h>

#include "shade/internal/block_scratch.h"
#include "shade/internal/media.h"

/* Extra entries of the stack for blur. A surface puts its reflected path on the stack, and if it
 * blurs also the transmitted one. An entry for several rays stays there while the first of them is
 * traced. Only the first surface that blurs has such entries, at most two. */
enum { BLURRED_ENTRIES = 2 };

/* Vectors of the widest instruction set are aligned to their size. */
enum { BLOCK_ALIGN = 64 };

/* The number of bytes for the block kernels of any instruction set. */
static size_t block_bytes(void)
{
    size_t bytes = 0;
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        const struct pen_kernel *kernel = pen_kernel_select(0, (enum pen_isa)isa);
        bytes = kernel->block_bytes > bytes ? kernel->block_bytes : bytes;
    }
    return bytes;
}

/* Allocates the memory with calloc, which touches its pages only when they are used. It begins at
 * the first aligned address. */
static bool block_new(struct pen_kernel_scratch *scratch)
{
    scratch->block_memory = calloc(1, block_bytes() + BLOCK_ALIGN);
    if (!scratch->block_memory)
        return false;
    const size_t past = (uintptr_t)scratch->block_memory % BLOCK_ALIGN;
    scratch->block = (void *)((char *)scratch->block_memory + (BLOCK_ALIGN - past) % BLOCK_ALIGN);
    return true;
}

/* The most solids that contain a path: those at its camera ray's start, and those that it has met.
 * It meets as many surfaces as it shades, and a few more at each if surfaces coincide. */
static size_t most_solids(const struct pen_kernel_input *input, size_t depth)
{
    const struct pen_scene *scene = input->scene;
    const size_t each = scene->layer_first ? LAYERS_MAX + 1 : 1;
    const size_t most = input->view->inside.count + input->view->maybe.count + each * depth;
    return most < scene->solids.count ? most : scene->solids.count;
}

static bool media_new(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch)
{
    if (input->scene->solids.count == 0)
        return true;
    scratch->media_stride = 1 + most_solids(input, scratch->depth);
    scratch->media = calloc(media_of_pool(scratch) + BLOCK_PATHS,
                            scratch->media_stride * sizeof *scratch->media);
    return scratch->media != NULL;
}

static bool fill(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch)
{
    const size_t lights = input->scene->light_count;
    scratch->last_occluder = calloc(lights + 1, sizeof *scratch->last_occluder);
    scratch->waiting = calloc(scratch->depth, sizeof *scratch->waiting);
    if (pen_effects_blur(input->effects))
        scratch->blurred = calloc(scratch->depth, sizeof *scratch->blurred);
    if (pen_effects_blur(input->effects) && !scratch->blurred)
        return false;
    if (!scratch->last_occluder || !scratch->waiting || !block_new(scratch) ||
        !media_new(input, scratch))
        return false;
    for (size_t i = 0; i < lights; i++)
        scratch->last_occluder[i] = PEN_NO_PRIM;
    return true;
}

struct pen_kernel_scratch *pen_kernel_scratch_new(const struct pen_kernel_input *input)
{
    const int depth = input->settings->max_depth;
    struct pen_kernel_scratch *scratch = calloc(1, sizeof *scratch);
    if (!scratch)
        return NULL;
    const bool blurs = pen_effects_blur(input->effects);
    scratch->depth = (depth > 0 ? (size_t)depth : 1) + (blurs ? BLURRED_ENTRIES : 0);
    scratch->surfaces_max = pen_tree_surfaces_max(input->settings, blurs);
    if (fill(input, scratch))
        return scratch;
    pen_kernel_scratch_free(scratch);
    return NULL;
}

void pen_kernel_scratch_free(struct pen_kernel_scratch *scratch)
{
    if (!scratch)
        return;
    free(scratch->last_occluder);
    free(scratch->waiting);
    free(scratch->blurred);
    free(scratch->media);
    free(scratch->block_memory);
    free(scratch);
}
