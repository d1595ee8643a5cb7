/* SPDX-License-Identifier: MIT */
/* Common to constructors: vectors scaled to one, boxes grown. */
#include "geom/internal/make.h"

#include <stdint.h>
#include <string.h>

#include "geom/ray.h"
#include "math/frame.h"

struct pen_vec3 pen_scale_to_one(struct pen_vec3 v)
{
    if (pen_largest3(v) < 0x1p-900)
        v = pen_scale(v, 0x1p600); /* out of the subnormals, so that the exponent bits are valid */
    double m = pen_largest3(v);
    uint64_t bits;
    memcpy(&bits, &m, sizeof bits);
    int exponent = (int)(bits >> 52) - 1022; /* m = f 2^exponent, f in [1/2, 1) */
    int half = exponent / 2;                 /* 2^-exponent itself may be out of range */
    uint64_t first = (uint64_t)(1023 - half) << 52;
    uint64_t second = (uint64_t)(1023 - (exponent - half)) << 52;
    double a, b;
    memcpy(&a, &first, sizeof a);
    memcpy(&b, &second, sizeof b);
    return pen_scale(pen_scale(v, a), b);
}

struct pen_vec3 pen_unit_of(struct pen_vec3 v)
{
    struct pen_vec3 s = pen_scale_to_one(v);
    double length = pen_length(s);
    return pen_vec3(s.x / length, s.y / length, s.z / length);
}

struct pen_vec3 pen_across_points(const struct pen_vec3 *v, uint32_t count)
{
    struct pen_vec3 longest = {0, 0, 0};
    for (uint32_t i = 1; i < count; i++) {
        struct pen_vec3 edge = pen_sub(v[i], v[0]);
        if (pen_largest3(edge) > pen_largest3(longest))
            longest = edge;
    }
    if (!(pen_largest3(longest) > 0 && isfinite(pen_largest3(longest))))
        return pen_vec3(0, 0, 0);
    return pen_across(pen_unit_of(longest)).u;
}

struct pen_box pen_box_of_points(const struct pen_vec3 *v, uint32_t count)
{
    struct pen_box b = pen_box_empty();
    for (uint32_t i = 0; i < count; i++)
        b = pen_box_add_point(b, v[i]);
    return b;
}

struct pen_box pen_box_grow(struct pen_box b, double size)
{
    double m = pen_largest3(b.lo) > pen_largest3(b.hi) ? pen_largest3(b.lo) : pen_largest3(b.hi);
    double pad = 32 * PEN_U * (m + size);
    struct pen_vec3 p = pen_vec3(pad, pad, pad);
    return (struct pen_box){pen_sub(b.lo, p), pen_add(b.hi, p)};
}
