/* SPDX-License-Identifier: MIT */
/* Queries in plain C, for any processor: the reference for the other variants. */
#include "ops.h"
#include "traverse.h"

static inline unsigned enter_node(const struct pen_node *node, const struct box_ray *box,
                                  float limit, float near[PEN_WIDE])
{
    unsigned mask = 0;
    for (int lane = 0; lane < PEN_WIDE; lane++) {
        float t0 = box->tmin, t1 = limit;
        for (int axis = 0; axis < 3; axis++) {
            float lo = node->lo[axis][lane], hi = node->hi[axis][lane];
            float a = ((box->sign[axis] ? hi : lo) - box->near_o[axis]) * box->near_inv[axis];
            float b = ((box->sign[axis] ? lo : hi) - box->far_o[axis]) * box->far_inv[axis];
            t0 = a > t0 ? a : t0; /* NaN, from 0 times infinity, leaves the axis out */
            t1 = b < t1 ? b : t1;
        }
        near[lane] = t0;
        mask |= (unsigned)(t0 <= t1) << lane;
    }
    return mask;
}

static inline bool test_item(struct trace *w, uint32_t item, bool any)
{
    return test_each(w, item, any);
}

#include "traverse_walk.h"

const struct pen_trace_ops pen_trace_base = {"base", nearest, shadow};
