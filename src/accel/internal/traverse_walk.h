/* SPDX-License-Identifier: MIT */
/* The walk through wide nodes and the two queries; see traverse.h. The including file also says
 * whether tests are counted: `enum { COUNTING = 0 };` or 1. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_WALK_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_WALK_H

#include "accel/internal/traverse_lists.h"
#include "accel/internal/traverse_pairs.h"

/* Each node on the way down leaves at most seven others behind. */
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

/* Visits what the ray may meet, nearest boxes first. A box is entered when its near distance is
 * <= the best t, so that ties are decided by number. */
static inline void walk_nearest(struct trace *w, const struct box_ray *box)
{
    struct pending stack[STACK];
    int top = 0;
    uint32_t child = 0;
    float limit = pen_float_up(w->best.t * box->scale), entry = box->tmin;
    for (;;) {
        if (child & PEN_CHILD_LEAF) {
            test_leaf(w, child & ~PEN_CHILD_LEAF, entry <= box->tmin, false);
            limit = pen_float_up(w->best.t * box->scale);
        } else {
            const struct pen_node *node = &w->accel->nodes[child];
            float near[PEN_WIDE];
            if (COUNTING)
                count_boxes(w, node->child, PEN_WIDE);
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

/* Visits what the ray may meet, in any order; true if something ended the query. */
static inline bool walk_any(struct trace *w, const struct box_ray *box)
{
    uint32_t stack[STACK];
    int top = 0;
    float limit = pen_float_up(w->shadow->tmax * box->scale);
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &w->accel->nodes[stack[--top]];
        float near[PEN_WIDE];
        if (COUNTING)
            count_boxes(w, node->child, PEN_WIDE);
        unsigned mask = enter_node(node, box, limit, near);
        for (; mask; mask &= mask - 1) {
            int lane = __builtin_ctz(mask);
            uint32_t child = node->child[lane];
            if (!(child & PEN_CHILD_LEAF))
                stack[top++] = child;
            else if (test_leaf(w, child & ~PEN_CHILD_LEAF, near[lane] <= box->tmin, true))
                return true;
        }
    }
    return false;
}

/* The other shapes, kept out of the way of the wide one. */
static __attribute__((noinline)) bool walk_other(struct trace *w, const struct box_ray *box,
                                                 bool any)
{
    return w->accel->shape == PEN_SHAPE_PAIRS ? walk_pairs(w, box, any) : walk_lists(w, box, any);
}

static inline bool search(struct trace *w, double tmin, bool any)
{
    const struct pen_accel *accel = w->accel;
    if (test_leaf(w, accel->infinite, true, any) ||
        (accel->list && test_leaf(w, accel->list, true, any)))
        return true;
    if (accel->shape == PEN_SHAPE_NONE)
        return false;
    struct box_ray box;
    box_ray_make(&box, w->ray, tmin, w->grow);
    if (accel->shape != PEN_SHAPE_WIDE)
        return walk_other(w, &box, any);
    if (any)
        return walk_any(w, &box);
    walk_nearest(w, &box);
    return false;
}

static inline struct trace begin(const struct pen_accel *accel, const struct pen_ray *ray,
                                 const struct pen_origin_surface *origin)
{
    struct trace w = {.accel = accel, .ray = ray, .origin = origin};
    w.leaving = origin->prim != PEN_NO_PRIM;
    w.slack = origin->bound + 8 * PEN_U * accel->scale;
    w.grow = 2 * PEN_NEARBY * w.slack;
    w.near_sq = w.grow * w.grow * ray->inv_dd;
    return w;
}

static bool nearest(const struct pen_accel *accel, const struct pen_ray *ray,
                    const struct pen_origin_surface *origin, const struct pen_t_interval *interval,
                    struct pen_hit *hit)
{
    struct trace w = begin(accel, ray, origin);
    w.after = interval->after;
    w.best = (struct pen_hit){interval->tmax, PEN_NO_PRIM, UINT8_MAX};
    search(&w, interval->after.t, false);
    if (w.best.prim == PEN_NO_PRIM)
        return false;
    *hit = w.best;
    return true;
}

static inline struct trace begin_shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                                        const struct pen_origin_surface *origin,
                                        struct pen_shadow *query)
{
    struct trace w = begin(accel, ray, origin);
    w.shadow = query;
    if (query->to_point) {
        w.light_bound = pen_shadow_light_bound(ray);
        w.light = pen_along(ray->o, ray->d, query->tmax);
    }
    query->count = 0;
    query->overflow = false;
    return w;
}

static bool shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                   const struct pen_origin_surface *origin, struct pen_shadow *query)
{
    struct trace w = begin_shadow(accel, ray, origin, query);
    uint32_t last = query->last_occluder;
    /* What the thread met before must not change what is counted. */
    if (!COUNTING && last < accel->prims->count &&
        !(query->see_through && query->see_through[last]) && test_prim(&w, last, true))
        return true;
    query->last_occluder = PEN_NO_PRIM;
    return search(&w, 0, true);
}

#endif
