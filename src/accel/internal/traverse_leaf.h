/* SPDX-License-Identifier: MIT */
/* What all walks do: test a leaf, and count tests where COUNTING says so; see traverse_walk.h. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_LEAF_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_LEAF_H

#include "accel/internal/prim_test.h"

/* The boxes of a node count together, as they are tested. */
static inline void count_boxes(const struct trace *w, const uint32_t *child, int lanes)
{
    for (int lane = 0; lane < lanes; lane++)
        w->accel->counts->boxes += child[lane] != PEN_CHILD_LEAF;
}

/* So do the primitives of a block, whichever of them ends the query. */
static inline void count_prims(const struct trace *w, uint32_t item)
{
    const uint32_t *prim = block_prims(w->accel, item);
    w->accel->counts->primitives += PEN_ITEM_KIND(item) == PEN_BLOCK_SINGLE;
    for (int lane = 0; prim && lane < PEN_LANES; lane++)
        w->accel->counts->primitives += prim[lane] != PEN_NO_PRIM;
}

/* Tests a leaf, or a list of items beside the nodes; true if a crossing ended the query. The ray
 * starts in the leaf's box if it enters it no later than the query begins. */
static inline bool test_leaf(struct trace *w, uint32_t first, bool starts_inside, bool any)
{
    w->reaches_origin = w->from_surface && starts_inside;
    for (const uint32_t *item = &w->accel->items[first];; item++) {
        if (COUNTING)
            count_prims(w, *item);
        if (test_item(w, *item, any))
            return true;
        if (*item & PEN_ITEM_LAST)
            return false;
    }
}

/* The box t beyond which intersections are of no use. */
static inline float walk_limit(const struct trace *w, const struct box_ray *box, bool any)
{
    return pen_float_up((any ? w->shadow->tmax : w->best.t) * box->scale);
}

#endif
