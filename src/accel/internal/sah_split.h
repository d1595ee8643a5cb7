/* SPDX-License-Identifier: MIT */
/* The splits of the surface-area heuristic: build_sah.c builds a tree of them. */
#ifndef PEN_ACCEL_INTERNAL_SAH_SPLIT_H
#define PEN_ACCEL_INTERNAL_SAH_SPLIT_H

#include "accel/internal/tree_layout.h"

/* Three coordinates in the compiler's own vector type, for any processor. The last lane is
 * undefined. */
typedef float pen_float4 __attribute__((vector_size(16), aligned(4), may_alias));

struct pen_bounds {
    pen_float4 lo, hi;
};

/* A range of ref[], not yet a node or a leaf. */
struct pen_range {
    uint32_t begin, end;
    struct pen_bounds box;      /* of the primitives */
    struct pen_bounds centroid; /* of lo + hi */
    uint32_t lanes[PEN_COST_CLASS_COUNT];
    bool leaf; /* splitting does not reduce the cost */
};

static inline float pen_half_area(const struct pen_bounds *b)
{
    pen_float4 d = b->hi - b->lo;
    return d[0] >= 0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0;
}

/* The ranges of a layout that are being split. */
struct pen_splitter {
    struct pen_tree_layout *layout;
    struct pen_ref *other; /* as large as ref[], to divide ranges of meshes */
    bool shared;           /* all threads of the pool split a large range together */
};

/* Measures a range. */
struct pen_range pen_range_measure(const struct pen_ref *ref, uint32_t begin, uint32_t end);

/* Splits a range in two, of which *r becomes the left one. `depth` is that of the node. If a leaf
 * is cheaper, marks the range as a leaf and returns false. */
bool pen_range_split(const struct pen_splitter *splitter, struct pen_range *r, uint32_t depth,
                     struct pen_range *right);

#endif
