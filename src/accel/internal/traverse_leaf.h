/* SPDX-License-Identifier: MIT */
/* Common to all traversals: testing a leaf, and counting tests if COUNTING is 1; see
 * traverse_query.h. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_LEAF_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_LEAF_H

#include "accel/internal/prim_test.h"

/* Counts all boxes of a node, because they are tested at once. */
static inline void count_boxes(const struct trace *trace, const uint32_t *child, int count)
{
    for (int i = 0; i < count; i++)
        trace->accel->counts->boxes += child[i] != PEN_CHILD_LEAF;
}

/* Counts the primitives of an item. All of a block count, even if one of them ends the query. */
static inline void count_prims(const struct trace *trace, uint32_t item)
{
    const uint32_t *prim = block_prims(trace->accel, item);
    trace->accel->counts->primitives += PEN_ITEM_KIND(item) == PEN_BLOCK_SINGLE;
    for (int lane = 0; prim && lane < PEN_LANES; lane++)
        trace->accel->counts->primitives += prim[lane] != PEN_NO_PRIM;
}

/* Tests the items of a leaf, or of a list beside the nodes; returns true if an intersection ended
 * the query. `starts_inside`: the ray enters the leaf's box no later than the query begins, so the
 * box contains the origin. */
static inline bool test_leaf(struct trace *trace, uint32_t first, bool starts_inside, bool any)
{
    trace->reaches_origin = trace->from_surface && starts_inside;
    for (const uint32_t *item = &trace->accel->items[first];; item++) {
        if (COUNTING)
            count_prims(trace, *item);
        if (test_item(trace, *item, any))
            return true;
        if (*item & PEN_ITEM_LAST)
            return false;
    }
}

/* The largest t, as a box's t, at which intersections count. */
static inline float traverse_limit(const struct trace *trace, const struct box_ray *box, bool any)
{
    return pen_float_up((any ? trace->shadow->tmax : trace->best.t) * box->scale);
}

#endif
