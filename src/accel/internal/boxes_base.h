/* SPDX-License-Identifier: MIT */
/* Tests of boxes in plain C, one by one; see prim_test.h. Every float has the same bits as in
 * boxes_avx2.h, so both variants enter the same boxes and count the same tests. */
#ifndef PEN_ACCEL_INTERNAL_BOXES_BASE_H
#define PEN_ACCEL_INTERNAL_BOXES_BASE_H

#include "accel/internal/prim_test.h"

struct box_ray {
    float near_o[3], far_o[3];
    float near_inv[3], far_inv[3];
    bool negative[3]; /* d is negative or -0: the near plane is the high end */
    float tmin;       /* >= 0 */
    double scale;
};

/* A margin that exceeds the distance of a float from any number that rounds to it, and from its
 * neighbours. */
static inline float float_margin(float f)
{
    return (float)((double)fabsf(f) * 0x1p-23 + (double)FLT_MIN);
}

/* The nearest float; infinite if x is out of range. */
static inline float float_any(double x)
{
    return fabs(x) < 0x1.ffffffp127 ? (float)x : signbit(x) ? -INFINITY : INFINITY;
}

static inline void box_axis(struct box_ray *box, int axis, double o, double d, double grow)
{
    double inv = box->scale / d;
    bool negative = signbit(d);
    float low = pen_float_near(o - grow), high = pen_float_near(o + grow);
    low -= float_margin(low);
    high += float_margin(high);
    box->negative[axis] = negative;
    box->near_o[axis] = negative ? low : high;
    box->far_o[axis] = negative ? high : low;
    box->near_inv[axis] = pen_float_near(inv * (1 - 0x1p-22));
    box->far_inv[axis] = float_any(inv * (1 + 0x1p-22));
}

static inline void box_ray_make(struct box_ray *box, const struct pen_ray *ray, double tmin,
                                double grow)
{
    box->scale = box_scale(ray);
    box_axis(box, 0, ray->o.x, ray->d.x, grow);
    box_axis(box, 1, ray->o.y, ray->d.y, grow);
    box_axis(box, 2, ray->o.z, ray->d.z, grow);
    box->tmin = pen_float_down(tmin * box->scale);
}

/* Whether the ray enters this one of the `width` boxes that `plane` holds side by side. */
static inline bool enter_box(const float *plane, int width, const struct box_ray *box, float limit,
                             float *near)
{
    float t0 = box->tmin, t1 = limit;
    for (int axis = 0; axis < 3; axis++) {
        float first = plane[width * (axis + (box->negative[axis] ? 3 : 0))];
        float last = plane[width * (axis + (box->negative[axis] ? 0 : 3))];
        float a = (first - box->near_o[axis]) * box->near_inv[axis];
        float b = (last - box->far_o[axis]) * box->far_inv[axis];
        t0 = a > t0 ? a : t0; /* an axis with a NaN, from 0 times infinity, does not count */
        t1 = b < t1 ? b : t1;
    }
    *near = t0;
    return t0 <= t1;
}

static inline unsigned enter_node(const struct pen_node *node, const struct box_ray *box,
                                  float limit, float near[PEN_WIDE])
{
    unsigned mask = 0;
    for (int lane = 0; lane < PEN_WIDE; lane++)
        mask |= (unsigned)enter_box((const float *)node->plane + lane, PEN_WIDE, box, limit,
                                    &near[lane])
                << lane;
    return mask;
}

static inline unsigned enter_pair(const struct pen_pair *pair, const struct box_ray *box,
                                  float limit, float near[2])
{
    unsigned first = enter_box((const float *)pair->plane, 2, box, limit, &near[0]);
    return first | (unsigned)enter_box((const float *)pair->plane + 1, 2, box, limit, &near[1])
                       << 1;
}

static inline bool test_item(struct trace *trace, uint32_t item, bool any)
{
    return test_each(trace, item, any);
}

#endif
