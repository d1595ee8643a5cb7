/* SPDX-License-Identifier: MIT */
/* The exact orientation of three points in the plane. */
#ifndef PEN_MATH_ORIENT2D_H
#define PEN_MATH_ORIENT2D_H

struct pen_point2 {
    double x, y;
};

/* 1 if a, b, c run counter-clockwise, -1 if clockwise, 0 if they are on one line. Exact for
 * coordinates that are 0 or have magnitudes in 2^-480 .. 2^480. */
int pen_orient2d(struct pen_point2 a, struct pen_point2 b, struct pen_point2 c);

/* The order in which a sweep line passes points: by x, then by y. */
static inline int pen_point2_compare(struct pen_point2 a, struct pen_point2 b)
{
    if (a.x != b.x)
        return a.x < b.x ? -1 : 1;
    return a.y < b.y ? -1 : a.y > b.y;
}

#endif
