/* SPDX-License-Identifier: MIT */
/* Traversal of lists. Every box of a list is tested, eight at a time. The children whose boxes the
 * ray enters are visited in document order, a group with all its contents before the next child. A
 * box that is beyond an intersection found since its test is skipped. So the result is as if boxes
 * were tested one by one. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_LISTS_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_LISTS_H

#include "accel/internal/traverse_leaf.h"

/* The position of the traversal in one list. */
struct list_level {
    uint32_t node;
    unsigned mask; /* children still to be visited */
    float near[PEN_WIDE];
};

static inline void list_enter(const struct trace *trace, const struct box_ray *box, float limit,
                              uint32_t number, struct list_level *level)
{
    const struct pen_node *node = &trace->accel->nodes[number];
    if (COUNTING)
        count_boxes(trace, node->child, PEN_WIDE);
    level->node = number;
    level->mask = enter_node(node, box, limit, level->near);
}

static inline bool traverse_lists(struct trace *trace, const struct box_ray *box, bool any)
{
    struct list_level stack[PEN_MAX_DEPTH];
    float limit = traverse_limit(trace, box, any);
    int top = 0;
    list_enter(trace, box, limit, 0, &stack[0]);
    while (top >= 0) {
        struct list_level *level = &stack[top];
        const struct pen_node *node = &trace->accel->nodes[level->node];
        if (level->mask == 0) {
            if (node->child[0] & PEN_CHILD_MORE)
                list_enter(trace, box, limit, level->node + 1, level);
            else
                top--;
            continue;
        }
        int lane = __builtin_ctz(level->mask);
        uint32_t child = node->child[lane] & ~PEN_CHILD_MORE;
        level->mask &= level->mask - 1;
        if (level->near[lane] > limit)
            continue;
        if (!(child & PEN_CHILD_LEAF)) {
            list_enter(trace, box, limit, child, &stack[++top]);
            continue;
        }
        if (test_leaf(trace, child & ~PEN_CHILD_LEAF, level->near[lane] <= box->tmin, any))
            return true;
        limit = traverse_limit(trace, box, any);
    }
    return false;
}

#endif
