/* SPDX-License-Identifier: MIT */
/* Traversal of a binary tree, the nearer child first. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_PAIRS_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_PAIRS_H

#include "accel/internal/traverse_leaf.h"

struct pair_pending {
    float near;
    uint32_t child;
};

static inline bool traverse_pairs(struct trace *trace, const struct box_ray *box, bool any)
{
    struct pair_pending stack[PEN_MAX_DEPTH];
    int top = 0;
    stack[top++] = (struct pair_pending){0, 0};
    float limit = traverse_limit(trace, box, any);
    while (top > 0) {
        struct pair_pending at = stack[--top];
        if (at.near > limit)
            continue;
        if (at.child & PEN_CHILD_LEAF) {
            if (test_leaf(trace, at.child & ~PEN_CHILD_LEAF, at.near <= box->tmin, any))
                return true;
            limit = traverse_limit(trace, box, any);
            continue;
        }
        const struct pen_pair *pair = &trace->accel->pairs[at.child];
        float near[2];
        if (COUNTING)
            count_boxes(trace, pair->child, 2);
        unsigned mask = enter_pair(pair, box, limit, near);
        unsigned first = mask == 3 && near[1] < near[0] ? 1 : 0;
        if (mask >> (1 - first) & 1)
            stack[top++] = (struct pair_pending){near[1 - first], pair->child[1 - first]};
        if (mask >> first & 1)
            stack[top++] = (struct pair_pending){near[first], pair->child[first]};
    }
    return false;
}

#endif
