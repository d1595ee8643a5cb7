/* SPDX-License-Identifier: MIT */
/* Traversal of a tree of wide nodes that has blocks of meshes. Each plane of a box costs one fma.
 */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_MESH_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_MESH_H

#include "accel/internal/mesh_query.h"
#include "accel/internal/traverse_wide.h"

/* A ray for boxes. Depth x is t = (x + moved) / scale. A plane is at depth plane * inv + near, at
 * least, and plane * inv + far at most. */
struct mesh_box {
    float8 inv[3], near[3], far[3];
    size_t near_row[3], far_row[3]; /* in a node: the first number of these planes */
    double scale, moved;
    float start; /* of the query */
    bool blind;  /* the origin is too far away: all boxes are entered, and depths do not count */
};

/* Sets the planes for an origin and a direction. `off`: how far boxes have to be grown. */
static inline void mesh_box_planes(struct mesh_box *box, const double o[3], const double d[3],
                                   double off)
{
    const float4 direction = {(float)d[0], (float)d[1], (float)d[2], 1};
    const float4 at = {mesh_coordinate(o[0]), mesh_coordinate(o[1]), mesh_coordinate(o[2]), 0};
    const mask4 sign = (mask4)direction & INT32_MIN;
    const float4 least = {0x1p-60f, 0x1p-60f, 0x1p-60f, 1},
                 given = (float4)((mask4)direction ^ sign);
    const mask4 small = given < least;
    const float4 size = 1.0f / (float4)(((mask4)least & small) | ((mask4)given & ~small));
    const float4 inv = (float4)((mask4)size ^ sign), back = -(at * inv),
                 margin = mesh_bound(off) * size, near = back - margin, far = back + margin;
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) {
        const size_t negative = sign[axis] < 0;
        box->inv[axis] = SPLAT8(inv[axis]);
        box->near[axis] = SPLAT8(near[axis]);
        box->far[axis] = SPLAT8(far[axis]);
        box->near_row[axis] = ((size_t)axis + 3 * negative) * PEN_WIDE;
        box->far_row[axis] = ((size_t)axis + 3 - 3 * negative) * PEN_WIDE;
    }
}

/* Makes a ray for boxes; false if it does not come near the tree. */
static inline bool mesh_box_make(struct mesh_box *box, const struct trace *trace, double start)
{
    double o[3], d[3];
    const double extent = trace->accel->extent;
    box->scale = mesh_direction(trace->ray, d);
    box->moved = 0;
    o[0] = trace->ray->o.x;
    o[1] = trace->ray->o.y;
    o[2] = trace->ray->o.z;
    double far = mesh_largest(o);
    const double rest = 0x1p-48 * (far + extent) + trace->grow;
    if (far > 4 * extent && rest < extent) {
        bool misses;
        box->moved = move_near(o, d, extent, rest, &misses);
        if (misses)
            return false;
        far = mesh_largest(o);
    }
    box->blind = far > MESH_FAR;
    mesh_box_planes(box, o, d, box->blind ? MESH_OFF_MAX : 0x1p-20 * (far + extent) + rest);
    box->start = box->blind ? -FLT_MAX : pen_float_down(start * box->scale - box->moved);
    return true;
}

static inline unsigned mesh_enter_node(const struct pen_node *node, const struct mesh_box *box,
                                       float limit, float near[PEN_WIDE])
{
    float8 t0 = SPLAT8(box->start), t1 = SPLAT8(limit);
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) {
        raise8f(&t0, (const float *)node->plane + box->near_row[axis], &box->inv[axis],
                &box->near[axis]);
        lower8f(&t1, (const float *)node->plane + box->far_row[axis], &box->inv[axis],
                &box->far[axis]);
    }
    *(float8 *)near = t0;
    const mask8 in = t0 <= t1;
    return mask8_bits(&in);
}

static inline float mesh_limit(const struct trace *trace, const struct mesh_box *box, bool any)
{
    const double end = any ? trace->shadow->tmax : mesh_query_end(trace);
    return box->blind ? FLT_MAX : pen_float_up(end * box->scale - box->moved);
}

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
        mesh_query_narrow(trace, any);
        if (*item & PEN_ITEM_LAST)
            return false;
    }
}

/* As test_leaf. */
static inline bool mesh_test_leaf(struct trace *trace, uint32_t leaf, bool starts_inside, bool any)
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

/* As traverse_nearest. */
static inline void mesh_traverse_nearest(struct trace *trace, const struct mesh_box *box)
{
    struct pending stack[STACK], at = {box->start, 0};
    int top = 0;
    float limit = mesh_limit(trace, box, false);
    for (;;) {
        if (at.child & PEN_CHILD_LEAF) {
            const bool inside = at.near <= box->start || box->blind;
            mesh_test_leaf(trace, at.child & ~PEN_CHILD_LEAF, inside, false);
            limit = mesh_limit(trace, box, false);
        } else {
            const struct pen_node *node = &trace->accel->nodes[at.child];
            float near[PEN_WIDE];
            if (COUNTING)
                count_boxes(trace, node->child, PEN_WIDE);
            const unsigned mask = mesh_enter_node(node, box, limit, near);
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
        } while (stack[top].near > limit);
        at = stack[top];
    }
}

/* As traverse_any. */
static inline bool mesh_traverse_any(struct trace *trace, const struct mesh_box *box)
{
    uint32_t stack[STACK];
    int top = 0;
    const float limit = mesh_limit(trace, box, true);
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &trace->accel->nodes[stack[--top]];
        float near[PEN_WIDE];
        if (COUNTING)
            count_boxes(trace, node->child, PEN_WIDE);
        for (unsigned mask = mesh_enter_node(node, box, limit, near); mask; mask &= mask - 1) {
            const int lane = __builtin_ctz(mask);
            const uint32_t child = node->child[lane];
            const bool inside = near[lane] <= box->start || box->blind;
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

/* Searches a tree with blocks of meshes from t = `start` on. */
static __attribute__((noinline)) bool mesh_search(struct trace *trace, double start, bool any)
{
    struct mesh_query q;
    struct mesh_box box;
    struct box_ray other;
    mesh_query_begin(&q, trace);
    if (!mesh_box_make(&box, trace, start))
        return false;
    if (trace->accel->mixed) {
        box_ray_make(&other, trace->ray, start, trace->grow);
        trace->box = &other;
    }
    if (any)
        return mesh_traverse_any(trace, &box);
    mesh_traverse_nearest(trace, &box);
    mesh_query_finish(trace);
    return false;
}

#endif
