/* SPDX-License-Identifier: MIT */
/* The working memory of a block of pixels (block_body.h): its paths, which are taken from a pool
 * and wait on stacks, and its records.
 *
 * A *record* keeps the radiance that one surface sends to its pixel. When no path is left, each
 * pixel adds up its records in the order in which the pixel kernel traverses its tree: a surface,
 * the tree behind it, the tree that it reflects.
 *
 * Memory is bounded: BLOCK_PATHS paths and BLOCK_RECORDS records, PIXEL_RECORDS of them for one
 * pixel. So a tree that the limit on surfaces truncates does not fit. A pixel sample without room
 * is *deferred* to the pixel kernel, and the block discards its data. */
#ifndef PEN_SHADE_INTERNAL_BLOCK_SCRATCH_H
#define PEN_SHADE_INTERNAL_BLOCK_SCRATCH_H

#include "shade/internal/surface.h"
#include "shade/internal/unshadowed_light.h"

enum {
    BLOCK_PIXELS = PEN_BLOCK_SIDE * PEN_BLOCK_SIDE,
    BLOCK_RECORDS = 64 * BLOCK_PIXELS,
    BLOCK_PATHS = 1024,
    WAVE_GROUPS = PEN_RAY_PACKET_MAX / LANES,
    PIXEL_RECORDS = 1024, /* less than pen_tree_surfaces_max */
    NO_RECORD = -1
};
_Static_assert((int)BLOCK_PIXELS <= (int)PEN_RAY_PACKET_MAX,
               "the camera rays of a block are one wave");

/* The radiance that one surface, or the background, sends to its pixel, and the records of the
 * paths from it. */
struct block_record {
    struct pen_vec3 radiance; /* times the path's weight */
    int32_t transmitted, reflected;
};

/* A path of a pixel that is being traced or waits on a stack. */
struct block_path {
    struct path path;
    int32_t record;
    uint8_t pixel;
};

/* The paths of a wave, a bit each, that meet the same part of a primitive. */
struct block_part {
    uint64_t paths;
    uint32_t prim;
    uint8_t part;
};

/* A stack of paths, by their place in the pool. */
struct block_stack {
    int count;
    uint16_t path[BLOCK_PATHS];
};

/* Points of the image and the lens, one for each pixel of a block. */
struct block_points {
    double x[BLOCK_PIXELS], y[BLOCK_PIXELS];
    double lens_x[BLOCK_PIXELS], lens_y[BLOCK_PIXELS]; /* set if there is a lens */
};

/* The working memory of a block, owned by pen_kernel_scratch. Its size depends on the instruction
 * set's vectors, so only the block kernels know it. */
struct pen_block_scratch {
    /* By groups of LANES points of the wave: */
    struct surface surface[WAVE_GROUPS];
    struct arriving_light arriving[WAVE_GROUPS];
    lane_mask lit[WAVE_GROUPS];   /* points to which lights contribute */
    lanes hard_rays[WAVE_GROUPS]; /* shadow rays cast to hard lights, from each point */
    struct lanes3 radiance[WAVE_GROUPS];
    /* By paths of the wave; after tracing, only of paths that meet a surface: */
    int count;
    struct block_path *wave[PEN_RAY_PACKET_MAX];
    int parts_met;
    struct block_part part[PEN_RAY_PACKET_MAX];
    double transmittance[3][PEN_RAY_PACKET_MAX];
    uint64_t passes,
        filtered; /* points that the light reaches; points with a set transmittance[] */
    struct pen_ray_packet packet;
    struct pen_shadow query[PEN_RAY_PACKET_MAX];
    /* By pixel: */
    int x[BLOCK_PIXELS], y[BLOCK_PIXELS];
    uint32_t pixel_sample[BLOCK_PIXELS], ray[BLOCK_PIXELS]; /* as in the scratch memory */
    uint64_t deferred; /* bits of pixels that the pixel kernel renders */
    struct pen_ray_counts counts[BLOCK_PIXELS];
    int surfaces[BLOCK_PIXELS]; /* number of records of each pixel */
    struct block_stack transmitted, reflected, unused;
    int used; /* paths of the pool in use, from its beginning */
    struct block_path pool[BLOCK_PATHS];
    int record_count;
    struct block_record record[BLOCK_RECORDS];
};

/* Takes a new record for a pixel; NO_RECORD if there is no room. */
static ALWAYS_INLINE int32_t block_record_new(struct pen_block_scratch *b, int pixel)
{
    if (b->record_count == BLOCK_RECORDS || b->surfaces[pixel]++ == PIXEL_RECORDS)
        return NO_RECORD;
    b->record[b->record_count] = (struct block_record){{0, 0, 0}, NO_RECORD, NO_RECORD};
    return b->record_count++;
}

static ALWAYS_INLINE void stack_push(struct block_stack *stack, const struct pen_block_scratch *b,
                                     const struct block_path *path)
{
    stack->path[stack->count++] = (uint16_t)(path - b->pool);
}

/* Takes a path from the pool; NULL if there is none. */
static ALWAYS_INLINE struct block_path *block_path_new(struct pen_block_scratch *b)
{
    if (b->unused.count > 0)
        return &b->pool[b->unused.path[--b->unused.count]];
    return b->used < BLOCK_PATHS ? &b->pool[b->used++] : NULL;
}

/* Takes the next wave from a stack, without the paths of deferred pixels. */
static ALWAYS_INLINE void block_take(struct pen_block_scratch *b, struct block_stack *stack)
{
    b->count = 0;
    while (stack->count > 0 && b->count < PEN_RAY_PACKET_MAX) {
        struct block_path *next = &b->pool[stack->path[--stack->count]];
        if (b->deferred >> next->pixel & 1)
            stack_push(&b->unused, b, next);
        else
            b->wave[b->count++] = next;
    }
}

/* Defers the pixel of a path to the pixel kernel. */
static ALWAYS_INLINE void block_defer(struct pen_block_scratch *b, const struct block_path *path)
{
    b->deferred |= UINT64_C(1) << path->pixel;
}

/* Whether the scene has an effect that this kernel leaves out. Samples that meet it are deferred.
 */
static ALWAYS_INLINE bool leaves_out(const struct pen_kernel_input *input, unsigned effect,
                                     const unsigned fx)
{
    return !(fx & effect) && input->full && (input->effects & effect);
}

static ALWAYS_INLINE int block_groups(const struct pen_block_scratch *b)
{
    return (b->count + LANES - 1) / LANES;
}

/* Gets the paths of one group of the wave. Returns their number. */
static ALWAYS_INLINE int block_group_paths(const struct pen_block_scratch *b, int group,
                                           const struct path **path)
{
    const int first = group * LANES, left = b->count - first, count = left < LANES ? left : LANES;
    for (int i = 0; i < count; i++)
        path[i] = &b->wave[first + i]->path;
    return count;
}

/* The bits of one group, out of those of the wave's points. */
static ALWAYS_INLINE unsigned group_bits(uint64_t points, int group)
{
    return (unsigned)(points >> (group * LANES)) & LANES_ALL;
}

/* Puts a path of the pool on a stack with a new record, whose number goes to *link. Defers the
 * pixel if there is no room. */
static ALWAYS_INLINE void block_push(struct pen_block_scratch *b, struct block_stack *stack,
                                     struct block_path *path, int32_t *link)
{
    const int32_t record = block_record_new(b, path->pixel);
    if (record == NO_RECORD) {
        block_defer(b, path);
        stack_push(&b->unused, b, path);
        return;
    }
    *link = path->record = record;
    stack_push(stack, b, path);
}

/* Adds up a tree of records in the pixel kernel's order: depth first, the transmitted path before
 * the reflected one. */
static inline struct pen_vec3 block_sum(const struct pen_block_scratch *b, int32_t record,
                                        struct pen_vec3 sum)
{
    while (record != NO_RECORD) {
        const struct block_record *r = &b->record[record];
        sum = pen_add(sum, r->radiance);
        if (r->transmitted != NO_RECORD && r->reflected != NO_RECORD)
            sum = block_sum(b, r->transmitted, sum);
        else if (r->transmitted != NO_RECORD) {
            record = r->transmitted;
            continue;
        }
        record = r->reflected;
    }
    return sum;
}

#endif
