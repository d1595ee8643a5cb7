/* SPDX-License-Identifier: MIT */
/* Frames: two unit vectors that make an orthonormal frame with a given one. No axis is special:
 * errors stay within a few roundings for every direction. The frame is a continuous function of the
 * vector except where z changes its sign. */
#ifndef PEN_MATH_FRAME_H
#define PEN_MATH_FRAME_H

#include "math/exact.h"

struct pen_across {
    struct pen_vec3 u, v; /* u x v is the vector they were made for */
};

/* The vectors across n, which is a unit vector up to some roundings. They have length 1 and are at
 * right angles to each other and to n, to within 4 times 2^-53. The length of n is corrected first;
 * without that, the frame's error would be twice as large.
 * Source: Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin, "Building an orthonormal
 * basis, revisited", JCGT 6(1), 2017. */
static inline struct pen_across pen_across(struct pen_vec3 n)
{
    n = pen_along(n, n, 0.5 * (1 - pen_dot2(n, n)));
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    return (struct pen_across){
        {1 + sign * (n.x * n.x) * a, sign * b, -sign * n.x},
        {b, sign + n.y * n.y * a, -n.y},
    };
}

#endif
