/* SPDX-License-Identifier: MIT */
/* The beam of a ray packet: a volume that encloses all its rays, in binary32.
 *
 * The rays' directions have the same largest axis z and the same sign along it; x and y are the
 * other two axes. At depth w >= 0 along z, in that sign, from its origin (ox, oy, oz) a ray is at x
 * = ox + w sx, with |sx| <= 1. So at depths w0 to w1 from the nearest origin, all rays are between
 * the least and the largest ox + w sx. Shadow rays to a point are enclosed as if they began at
 * their common end, which makes a narrower beam. They are also inside the box of all their origins
 * and the end.
 *
 * Why the beam enters every box that a ray meets. Let M be the largest size of a coordinate of an
 * origin, of the light, and of a box. All numbers in a test are at most 4 M. Each is off by at most
 * eight roundings of 2^-24, conversion included. The point at which a ray meets a primitive is
 * within its box up to 2^-24 of the ray's length there, at most 4 M (accel/README.md). The
 * additions of the self-intersection rule lie within `grow` of the ray's origin. Together that is
 * below 9 4 M 2^-24 + grow < 2^-18 M + grow, the beam's margin. */
#ifndef PEN_ACCEL_INTERNAL_BEAM_H
#define PEN_ACCEL_INTERNAL_BEAM_H

#include "accel/internal/floats8.h"
#include "accel/internal/rounding.h"
#include "accel/internal/structure.h"

struct beam {
    int axis[3];             /* x, y and z */
    bool forward;            /* the rays go towards larger z */
    float lo[3], hi[3];      /* the bounds of their origins, or the light, by x, y, z */
    float least[2], most[2]; /* slopes of x and y by depth */
    float margin;
    bool bounded;               /* the rays are inside the following box */
    float box_lo[3], box_hi[3]; /* by axis of space */
};

/* The depths of boxes, and the beam's range of x or y at these depths. */
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

/* The node's boxes that some ray may enter, as bits. */
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

/* A lower bound of the depth, counted from its own origin, at which a ray meets a primitive in the
 * box. */
static inline float beam_near(const struct beam *beam, const struct pen_float_box *box)
{
    const int z = beam->axis[2];
    const float w = beam->forward ? box->lo[z] - beam->hi[2] : beam->lo[2] - box->hi[z];
    return (w > 0 ? w : 0) - 2 * beam->margin;
}

/* The number of beams that are tested at once, one for each part of the rays. Members of struct
 * beam that are not here are common to all parts. */
enum { BEAMS = 8 };

struct beams {
    float lo[3][BEAMS], hi[3][BEAMS], least[2][BEAMS], most[2][BEAMS];
    float box_lo[3][BEAMS], box_hi[3][BEAMS]; /* by x, y, z */
};

/* The beams that may enter a box. */
static inline unsigned beams_enter(const struct beams *b, const struct beam *all,
                                   const struct pen_float_box *box)
{
    const float8 zero = {0, 0, 0, 0, 0, 0, 0, 0};
    const float8 z_lo = *(const float8 *)b->lo[2], z_hi = *(const float8 *)b->hi[2];
    const float lo = box->lo[all->axis[2]], hi = box->hi[all->axis[2]];
    float8 near = all->forward ? lo - z_hi : z_lo - hi, far = all->forward ? hi - z_lo : z_hi - lo;
    mask8 in = far >= -all->margin;
    near = MAX8(near, zero);
    far = MAX8(far, zero);
    for (int i = 0; i < 2; i++) {
        const float8 least = *(const float8 *)b->least[i], most = *(const float8 *)b->most[i];
        const float8 up = MAX8(most * near, most * far), down = -MAX8(-least * near, -least * far);
        in &= box->lo[all->axis[i]] - *(const float8 *)b->hi[i] <= up + all->margin;
        in &= box->hi[all->axis[i]] - *(const float8 *)b->lo[i] >= down - all->margin;
    }
    for (int i = 0; all->bounded && i < 3; i++) {
        in &= box->lo[all->axis[i]] <= *(const float8 *)b->box_hi[i];
        in &= box->hi[all->axis[i]] >= *(const float8 *)b->box_lo[i];
    }
    return mask8_bits(&in);
}

#endif
