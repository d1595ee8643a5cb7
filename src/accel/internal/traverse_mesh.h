/* SPDX-License-Identifier: MIT */
/* Traversal of a tree of wide nodes that has blocks of meshes. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_MESH_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_MESH_H

#include "accel/internal/mesh_query.h"
#include "accel/internal/traverse_wide.h"

/* Tests a leaf that has other primitives too. */
static __attribute__((noinline)) bool mesh_test_items(struct trace *trace, uint32_t first, bool any)
{
    for (const uint32_t *item = &trace->accel->items[first];; item++) {
        const bool mesh = PEN_ITEM_KIND(*item) == PEN_BLOCK_MESH;
        const uint32_t index = PEN_ITEM_INDEX(*item);
        if (COUNTING && !mesh)
            count_prims(trace, *item);
        if (mesh ? mesh_test_blocks(trace, index, index, any) : test_item(trace, *item, any))
            return true;
        if (!any)
            mesh_query_narrow(trace);
        if (*item & PEN_ITEM_LAST)
            return false;
    }
}

/* As test_leaf. */
static inline __attribute__((always_inline)) bool mesh_test_leaf(struct trace *trace, uint32_t leaf,
                                                                 bool starts_inside, bool any)
{
    trace->reaches_origin = trace->from_surface && starts_inside;
    if (!(leaf & PEN_LEAF_BLOCKS))
        return mesh_test_items(trace, leaf, any);
    const uint32_t first = (leaf & ~PEN_LEAF_BLOCKS) / PEN_LEAF_BLOCKS_MAX;
    return mesh_test_blocks(trace, first, first + leaf % PEN_LEAF_BLOCKS_MAX, any);
}

/* Begins to load a child. */
static inline void mesh_prefetch(const struct trace *trace, uint32_t child)
{
    const struct pen_accel *accel = trace->accel;
    const char *at =
        child & PEN_CHILD_LEAF
            ? (const char *)&accel->mesh_blocks[(child & 0x3fffffffu) / PEN_LEAF_BLOCKS_MAX]
            : (const char *)&accel->nodes[child];
    __builtin_prefetch(at);
    __builtin_prefetch(at + 64);
    __builtin_prefetch(at + 128);
}

/* Puts all but the nearest of the entered children on the stack, the nearer ones above; *next is
 * the nearest. */
static inline int mesh_push(struct pending *stack, int top, const struct pen_node *node,
                            unsigned mask, const float near[PEN_WIDE], struct pending *next)
{
    const int bottom = top, first = __builtin_ctz(mask);
    struct pending nearest = {near[first], node->child[first]};
    mask &= mask - 1;
    if (!mask) {
        *next = nearest;
        return top;
    }
    if (!(mask & (mask - 1))) {
        const int lane = __builtin_ctz(mask);
        const struct pending p = {near[lane], node->child[lane]};
        const bool swap = p.near < nearest.near;
        stack[top] = swap ? nearest : p;
        *next = swap ? p : nearest;
        return top + 1;
    }
    for (; mask; mask &= mask - 1) {
        const int lane = __builtin_ctz(mask);
        struct pending p = {near[lane], node->child[lane]};
        if (p.near < nearest.near) {
            const struct pending later = nearest;
            nearest = p;
            p = later;
        }
        int at = top++;
        for (; at > bottom && stack[at - 1].near < p.near; at--)
            stack[at] = stack[at - 1];
        stack[at] = p;
    }
    *next = nearest;
    return top;
}

static inline void mesh_traverse_nearest(struct trace *trace, const struct mesh_query *q)
{
    struct pending stack[STACK], at = {q->box.start, 0};
    int top = 0;
    for (;;) {
        if (at.child & PEN_CHILD_LEAF) {
            const bool inside = at.near <= q->box.start || q->box.blind;
            mesh_test_leaf(trace, at.child & ~PEN_CHILD_LEAF, inside, false);
        } else {
            const struct pen_node *node = &trace->accel->nodes[at.child];
            _Alignas(32) float near[PEN_WIDE];
            if (COUNTING)
                count_boxes(trace, node->child, PEN_WIDE);
            const unsigned mask = mesh_enter_node(node, &q->box, q->limit, near);
            if (mask) {
                top = mesh_push(stack, top, node, mask, near, &at);
                mesh_prefetch(trace, at.child);
                continue;
            }
        }
        do {
            if (top == 0)
                return;
            top--;
        } while (stack[top].near > q->limit);
        at = stack[top];
    }
}

/* In any order: to sort the children takes longer than to visit some in vain. */
static inline bool mesh_traverse_any(struct trace *trace, const struct mesh_query *q)
{
    uint32_t stack[STACK];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &trace->accel->nodes[stack[--top]];
        _Alignas(32) float near[PEN_WIDE];
        if (COUNTING)
            count_boxes(trace, node->child, PEN_WIDE);
        for (unsigned mask = mesh_enter_node(node, &q->box, q->limit, near); mask;
             mask &= mask - 1) {
            const int lane = __builtin_ctz(mask);
            const uint32_t child = node->child[lane];
            const bool inside = near[lane] <= q->box.start || q->box.blind;
            if (!(child & PEN_CHILD_LEAF)) {
                mesh_prefetch(trace, child);
                stack[top++] = child;
            } else if (mesh_test_leaf(trace, child & ~PEN_CHILD_LEAF, inside, true)) {
                return true;
            }
        }
    }
    return false;
}

/* Begins a search from t = `start` on; returns false if the ray does not come near the tree.
 * `other`: room for the ray for other blocks. */
static inline bool mesh_begin(struct mesh_query *q, struct trace *trace, double start, bool any,
                              struct box_ray *other)
{
    if (trace->accel->mixed) {
        box_ray_make(other, trace->ray, start, trace->grow);
        trace->box = other;
    }
    return mesh_query_begin(q, trace, start, any);
}

/* Search a tree with blocks of meshes; as traverse_nearest, traverse_any. */
static __attribute__((noinline)) void mesh_nearest(struct trace *trace)
{
    struct mesh_query q;
    struct box_ray other;
    if (mesh_begin(&q, trace, trace->after.t, false, &other)) {
        mesh_traverse_nearest(trace, &q);
        mesh_query_finish(trace);
    }
    trace->meshes = NULL;
}

static __attribute__((noinline)) bool mesh_any(struct trace *trace)
{
    struct mesh_query q;
    struct box_ray other;
    const bool met = mesh_begin(&q, trace, 0, true, &other) && mesh_traverse_any(trace, &q);
    trace->meshes = NULL;
    return met;
}

#endif
