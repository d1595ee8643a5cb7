/* SPDX-License-Identifier: MIT */
/* Traversal of a tree of wide nodes: nearest boxes first for the nearest intersection, any order
 * for a shadow ray. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_WIDE_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_WIDE_H

#include "accel/internal/traverse_leaf.h"

/* Each level of the tree adds at most seven pending children to the stack. */
enum { STACK = (PEN_WIDE - 1) * PEN_MAX_DEPTH + 1 };

struct pending {
    float near;
    uint32_t child;
};

/* Puts the entered children on the stack, the nearest on top. */
static inline int push_children(struct pending *stack, int top, const struct pen_node *node,
                                unsigned mask, const float near[PEN_WIDE])
{
    int bottom = top;
    for (; mask; mask &= mask - 1) {
        int lane = __builtin_ctz(mask);
        struct pending p = {near[lane], node->child[lane]};
        int at = top++;
        for (; at > bottom && stack[at - 1].near < p.near; at--)
            stack[at] = stack[at - 1];
        stack[at] = p;
    }
    return top;
}

/* Visits the boxes that the ray enters, nearest first. A box is entered if its near distance is <=
 * the best t. So among intersections at equal t, the one with the lowest number wins. */
static inline void traverse_nearest(struct trace *trace, const struct box_ray *box)
{
    struct pending stack[STACK];
    int top = 0;
    uint32_t child = 0;
    float limit = pen_float_up(trace->best.t * box->scale), entry = box->tmin;
    for (;;) {
        if (child & PEN_CHILD_LEAF) {
            test_leaf(trace, child & ~PEN_CHILD_LEAF, entry <= box->tmin, false);
            limit = pen_float_up(trace->best.t * box->scale);
        } else {
            const struct pen_node *node = &trace->accel->nodes[child];
            float near[PEN_WIDE];
            if (COUNTING)
                count_boxes(trace, node->child, PEN_WIDE);
            unsigned mask = enter_node(node, box, limit, near);
            if (mask && !(mask & (mask - 1))) {
                child = node->child[__builtin_ctz(mask)];
                entry = near[__builtin_ctz(mask)];
                continue;
            }
            top = push_children(stack, top, node, mask, near);
        }
        do {
            if (top == 0)
                return;
            top--;
        } while (stack[top].near > limit);
        child = stack[top].child;
        entry = stack[top].near;
    }
}

/* Visits the boxes that the ray enters, in any order; returns true if an intersection ended the
 * query. */
static inline bool traverse_any(struct trace *trace, const struct box_ray *box)
{
    uint32_t stack[STACK];
    int top = 0;
    float limit = pen_float_up(trace->shadow->tmax * box->scale);
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &trace->accel->nodes[stack[--top]];
        float near[PEN_WIDE];
        if (COUNTING)
            count_boxes(trace, node->child, PEN_WIDE);
        unsigned mask = enter_node(node, box, limit, near);
        for (; mask; mask &= mask - 1) {
            int lane = __builtin_ctz(mask);
            uint32_t child = node->child[lane];
            if (!(child & PEN_CHILD_LEAF))
                stack[top++] = child;
            else if (test_leaf(trace, child & ~PEN_CHILD_LEAF, near[lane] <= box->tmin, true))
                return true;
        }
    }
    return false;
}

#endif
