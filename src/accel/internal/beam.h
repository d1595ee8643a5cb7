/* SPDX-License-Identifier: MIT */
/* The beam of a ray packet: what encloses all its rays, in binary32.
 *
 * The rays' directions have the same largest axis z and the same sign along it; x and y are the
 * other two. At a depth w >= 0 along z, in that sign, from its origin (ox, oy, oz) a ray is at
 * x = ox + w sx, with |sx| <= 1. So all rays at depths w0 to w1 from the nearest origin are between
 * the least ox + w sx and the largest. Shadow rays to a point are enclosed as if they began in
 * their common end, which makes a narrower beam, and by the box of all their origins and the end.
 *
 * Why no box that a ray meets is left out. Let M be the largest size of a coordinate of an origin,
 * of the light, and of a box. All numbers in a test are at most 4 M; each is off by at most eight
 * roundings of 2^-24, conversion included; the point at which a ray meets what the box contains is
 * within the box up to 2^-24 of the ray's length there, at most 4 M (accel/README.md); and what the
 * self-intersection rule adds lies within `grow` of the ray's origin. Together that is below
 * 9 4 M 2^-24 + grow < 2^-18 M + grow, the beam's margin. */
#ifndef PEN_ACCEL_INTERNAL_BEAM_H
#define PEN_ACCEL_INTERNAL_BEAM_H

#include "accel/internal/lanes.h"
#include "accel/internal/rounding.h"
#include "accel/internal/structure.h"

struct beam {
    int axis[3];             /* x, y and z */
    bool forward;            /* the rays go up along z */
    float lo[3], hi[3];      /* their origins, or the light, by x, y, z */
    float least[2], most[2]; /* slopes of x and y by depth */
    float margin;
    bool bounded;               /* the rays are inside the box */
    float box_lo[3], box_hi[3]; /* by axis of space */
};

/* The depths of boxes, and the range of x or y that the beam has there. */
struct beam_depth8 {
    float8 near, far;
};

#define MAX8(a, b) ((float8)(((mask8)(a) & ((a) > (b))) | ((mask8)(b) & ~((a) > (b)))))

static inline struct beam_depth8 beam_depth8(const struct beam *beam, const struct pen_node *node)
{
    const float8 lo = *(const float8 *)node->plane[beam->axis[2]];
    const float8 hi = *(const float8 *)node->plane[beam->axis[2] + 3];
    if (beam->forward)
        return (struct beam_depth8){lo - beam->hi[2], hi - beam->lo[2]};
    return (struct beam_depth8){beam->lo[2] - hi, beam->hi[2] - lo};
}

/* The node's boxes that some ray may enter. */
static inline unsigned beam_enter_node(const struct beam *beam, const struct pen_node *node)
{
    const float8 zero = {0, 0, 0, 0, 0, 0, 0, 0};
    struct beam_depth8 w = beam_depth8(beam, node);
    mask8 in = w.far >= -beam->margin;
    w.near = MAX8(w.near, zero);
    w.far = MAX8(w.far, zero);
    for (int i = 0; i < 2; i++) {
        const float8 lo = *(const float8 *)node->plane[beam->axis[i]];
        const float8 hi = *(const float8 *)node->plane[beam->axis[i] + 3];
        const float8 up = beam->most[i] * (beam->most[i] >= 0 ? w.far : w.near);
        const float8 down = beam->least[i] * (beam->least[i] >= 0 ? w.near : w.far);
        in &= lo - beam->hi[i] <= up + beam->margin;
        in &= hi - beam->lo[i] >= down - beam->margin;
    }
    for (int axis = 0; beam->bounded && axis < 3; axis++) {
        in &= *(const float8 *)node->plane[axis] <= beam->box_hi[axis];
        in &= *(const float8 *)node->plane[axis + 3] >= beam->box_lo[axis];
    }
    return mask8_bits(&in);
}

/* Whether some ray may enter a box. No ray meets what is in the box at a smaller depth than *near,
 * counted from its own origin. */
static inline bool beam_enters(const struct beam *beam, const struct pen_float_box *box,
                               float *near)
{
    const int z = beam->axis[2];
    float w0 = beam->forward ? box->lo[z] - beam->hi[2] : beam->lo[2] - box->hi[z];
    float w1 = beam->forward ? box->hi[z] - beam->lo[2] : beam->hi[2] - box->lo[z];
    if (w1 < -beam->margin)
        return false;
    w0 = w0 > 0 ? w0 : 0;
    w1 = w1 > 0 ? w1 : 0;
    *near = w0 - 2 * beam->margin;
    for (int i = 0; i < 2; i++) {
        float up = beam->most[i] * (beam->most[i] >= 0 ? w1 : w0);
        float down = beam->least[i] * (beam->least[i] >= 0 ? w0 : w1);
        if (box->lo[beam->axis[i]] - beam->hi[i] > up + beam->margin ||
            box->hi[beam->axis[i]] - beam->lo[i] < down - beam->margin)
            return false;
    }
    for (int axis = 0; beam->bounded && axis < 3; axis++)
        if (box->lo[axis] > beam->box_hi[axis] || box->hi[axis] < beam->box_lo[axis])
            return false;
    return true;
}

#endif
