/* SPDX-License-Identifier: MIT */
/* Finds the bodies that some ray of a fan may meet. A box is left out if it is off the box around
 * all rays, or beyond one of four planes through the origin that hold the cone between them; both
 * are widened by the fan's delta and by what floats round. */
#ifndef PEN_ACCEL_INTERNAL_FAN_WALK_H
#define PEN_ACCEL_INTERNAL_FAN_WALK_H

#include "accel/internal/fan_prepare.h"
#include "accel/internal/traverse.h"

/* A plane through the origin: boxes with n.x > off for all their points are beyond it. */
struct fan_plane {
    float n[3], off;
    int row[3]; /* of struct pen_node's planes: the end of the box that is least along n */
};

struct fan_box {
    float lo[3], hi[3];
    struct fan_plane plane[4];
};

static inline void fan_box_axis(struct fan_box *box, int axis, const struct pen_fan *fan)
{
    double o = pen_component(fan->o, axis), c = pen_component(fan->c, axis);
    double u = pen_component(fan->u, axis), v = pen_component(fan->v, axis);
    double half = sqrt(u * u + v * v), low = c - half, high = c + half;
    if (!fan->to_point) {
        low = low < 0 ? -INFINITY : 0;
        high = high > 0 ? INFINITY : 0;
    }
    double margin = fan->delta + 0x1p-40 * (fabs(o) + fan->reach);
    box->lo[axis] = pen_float_down(o + (low < 0 ? low : 0) - margin);
    box->hi[axis] = pen_float_up(o + (high > 0 ? high : 0) + margin);
}

static inline struct fan_plane fan_plane_of(const struct pen_fan *fan, struct pen_vec3 across)
{
    struct pen_vec3 n = pen_along(pen_scale(across, fan->slope_cos), fan->l, -fan->slope_sin);
    struct fan_plane plane;
    for (int axis = 0; axis < 3; axis++) {
        plane.n[axis] = pen_float_near(pen_component(n, axis));
        plane.row[axis] = axis + (plane.n[axis] < 0 ? 3 : 0);
    }
    plane.off = pen_float_up(pen_dot(n, fan->o) + fan->delta + 0x1p-22 * pen_norm1(fan->o));
    return plane;
}

static inline void fan_box_make(struct fan_box *box, const struct pen_fan *fan)
{
    double radius = pen_length(fan->u), inv = radius > 0 ? 1 / radius : 0;
    struct pen_vec3 u = pen_scale(fan->u, inv), v = pen_scale(fan->v, inv);
    for (int axis = 0; axis < 3; axis++)
        fan_box_axis(box, axis, fan);
    box->plane[0] = fan_plane_of(fan, u);
    box->plane[1] = fan_plane_of(fan, pen_neg(u));
    box->plane[2] = fan_plane_of(fan, v);
    box->plane[3] = fan_plane_of(fan, pen_neg(v));
}

/* The node's boxes that the fan may enter. */
static inline unsigned fan_enter(const struct pen_node *node, const struct fan_box *box)
{
    mask8 in = {-1, -1, -1, -1, -1, -1, -1, -1};
    for (int axis = 0; axis < 3; axis++) {
        const float8 *lo = (const float8 *)node->plane[axis];
        const float8 *hi = (const float8 *)node->plane[axis + 3];
        in &= (*lo <= box->hi[axis]) & (*hi >= box->lo[axis]);
    }
    for (int i = 0; i < 4; i++) {
        const struct fan_plane *plane = &box->plane[i];
        float8 x = *(const float8 *)node->plane[plane->row[0]];
        float8 y = *(const float8 *)node->plane[plane->row[1]];
        float8 z = *(const float8 *)node->plane[plane->row[2]];
        float8 least = plane->n[0] * x + plane->n[1] * y + plane->n[2] * z;
        in &= least - 0x1p-20f * (ABS8(x) + ABS8(y) + ABS8(z)) <= plane->off;
    }
    return mask8_bits(&in);
}

/* Adds a body's gate. False if that ends the search. */
static inline bool fan_add(const struct pen_accel *accel, struct pen_fan *fan, uint32_t prim,
                           enum pen_fan_fate *fate)
{
    enum pen_gate_say say = pen_gate_make(fan, accel->prims, prim, &fan->gate[fan->gates]);
    if (say == PEN_GATE_NEVER)
        return true;
    if (say == PEN_GATE_ALWAYS) {
        fan->last_occluder = prim;
        *fate = PEN_FAN_SHUT;
        return false;
    }
    if (!fan->gate[fan->gates].opaque && fan->tints < PEN_FAN_TINTS)
        fan->tint[fan->tints++] = (uint8_t)fan->gates;
    else if (!fan->gate[fan->gates].opaque)
        fan->gate[fan->gates].kind = PEN_GATE_ASK;
    if (++fan->gates < PEN_FAN_GATES)
        return true;
    *fate = PEN_FAN_NONE;
    return false;
}

static inline bool fan_add_leaf(const struct pen_accel *accel, struct pen_fan *fan, uint32_t first,
                                enum pen_fan_fate *fate)
{
    for (const uint32_t *item = &accel->items[first];; item++) {
        const uint32_t *prim = block_prims(accel, *item);
        for (int lane = 0; prim && lane < PEN_LANES && prim[lane] != PEN_NO_PRIM; lane++) {
            if (!fan_add(accel, fan, prim[lane], fate))
                return false;
        }
        if (*item & PEN_ITEM_LAST)
            return true;
    }
}

static inline void fan_search(const struct pen_accel *accel, struct pen_fan *fan,
                              enum pen_fan_fate *fate)
{
    uint32_t stack[(PEN_WIDE - 1) * PEN_MAX_DEPTH + 1];
    int top = 0;
    struct fan_box box;
    fan_box_make(&box, fan);
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &accel->nodes[stack[--top]];
        for (unsigned mask = fan_enter(node, &box); mask; mask &= mask - 1) {
            uint32_t child = node->child[__builtin_ctz(mask)];
            if (!(child & PEN_CHILD_LEAF))
                stack[top++] = child;
            else if (!fan_add_leaf(accel, fan, child & ~PEN_CHILD_LEAF, fate))
                return;
        }
    }
}

/* Whether the body that shut the last fan shuts this one too. */
static inline bool fan_shut_again(const struct pen_accel *accel, struct pen_fan *fan)
{
    uint32_t last = fan->last_occluder;
    if (last >= accel->prims->count)
        return false;
    fan->last_occluder = PEN_NO_PRIM;
    if (pen_gate_make(fan, accel->prims, last, &fan->gate[0]) != PEN_GATE_ALWAYS)
        return false;
    fan->last_occluder = last;
    return true;
}

static enum pen_fan_fate fan_begin(const struct pen_accel *accel, struct pen_fan *fan)
{
    enum pen_fan_fate fate = PEN_FAN_OPEN;
    if (accel->stats.kind != PEN_ACCEL_AUTO || !pen_fan_prepare(fan, accel->scale))
        return PEN_FAN_NONE;
    if (fan_shut_again(accel, fan))
        return PEN_FAN_SHUT;
    if (fan_add_leaf(accel, fan, accel->infinite, &fate) &&
        (!accel->list || fan_add_leaf(accel, fan, accel->list, &fate)) &&
        accel->shape == PEN_SHAPE_WIDE)
        fan_search(accel, fan, &fate);
    return fate == PEN_FAN_OPEN && fan->gates > 0 ? PEN_FAN_MIXED : fate;
}

#endif
