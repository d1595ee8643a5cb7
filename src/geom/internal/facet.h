/* SPDX-License-Identifier: MIT */
/* Construction of facets. */
#ifndef PEN_GEOM_INTERNAL_FACET_H
#define PEN_GEOM_INTERNAL_FACET_H

#include "geom/facet.h"
#include "geom/internal/double_double.h"
#include "geom/internal/make.h"
#include "math/exact_sum.h"
#include "math/scale.h"

/* Makes a normal of an outline exact enough. If no component is above `least`, replaces it by the
 * normal from exact sums; if that is zero, by `otherwise`. Returns false if that is zero too. */
static inline bool pen_exact_enough(struct dd3 *normal, double least, const struct pen_vec3 *v,
                                    uint32_t count, struct pen_vec3 otherwise)
{
    if (pen_largest3(dd_round3(*normal)) > least)
        return true;
    struct pen_vec3 low, high = pen_exact_normal_low(v, count, &low);
    *normal = (struct dd3){{high.x, low.x}, {high.y, low.y}, {high.z, low.z}};
    if (pen_largest3(high) == 0)
        *normal = dd_of3(otherwise);
    return pen_largest3(dd_round3(*normal)) > 0;
}

static inline struct dd dd_scale2(struct dd a, int e)
{
    return (struct dd){pen_scale2(a.hi, e), pen_scale2(a.lo, e)};
}

/* Sets *to to `normal` over a power of two, so that its largest component, of this size, is in
 * [1/2, 1). */
static inline void pen_normal_scale(struct dd3 *to, struct dd3 normal, double largest)
{
    const int e = -pen_exponent(largest);
    if (e >= -1000 && e <= 1000) {
        const double by = pen_scale2(1, e);
        *to = (struct dd3){{normal.x.hi * by, normal.x.lo * by},
                           {normal.y.hi * by, normal.y.lo * by},
                           {normal.z.hi * by, normal.z.lo * by}};
    } else {
        *to = (struct dd3){dd_scale2(normal.x, e), dd_scale2(normal.y, e), dd_scale2(normal.z, e)};
    }
}

/* The facet through q with this normal, which is finite and not zero, without its unit normal. A
 * normal along an axis gets length 1: then facets in one plane across an axis meet a ray at the
 * same t, with any outlines. All others are scaled by powers of two, which is exact. */
static inline struct pen_facet pen_facet_plane(struct pen_vec3 q, struct dd3 normal)
{
    const struct pen_vec3 high = dd_round3(normal), none = {0, 0, 0};
    struct dd3 g;
    pen_normal_scale(&g, normal, pen_largest3(high));
    if ((high.x != 0) + (high.y != 0) + (high.z != 0) == 1)
        g = dd_of3(pen_vec3((high.x > 0) - (high.x < 0), (high.y > 0) - (high.y < 0),
                            (high.z > 0) - (high.z < 0)));
    struct dd c = dd_dot(g, dd_of3(q));
    return (struct pen_facet){dd_round3(g),     pen_vec3(g.x.lo, g.y.lo, g.z.lo), c.hi, c.lo, none,
                              PEN_FACET_GRAZING};
}

/* The same with its unit normal. */
static inline struct pen_facet pen_facet_of(struct pen_vec3 q, struct dd3 normal)
{
    struct pen_facet facet = pen_facet_plane(q, normal);
    facet.n = pen_unit_of(dd_round3(normal));
    return facet;
}

/* The normal of a triangle, from its distinguished vertex on. `otherwise` is the normal if the
 * vertices are on one line; zero: such a triangle is refused.
 * Fails: returns false if the normal overflows, or if the triangle is refused. */
static inline bool pen_triangle_normal(const struct pen_vec3 v[3], struct pen_vec3 otherwise,
                                       struct dd3 *normal)
{
    const struct dd3 e = dd_sub3(v[1], v[0]), f = dd_sub3(v[2], v[0]);
    *normal = dd_cross(e, f);
    if (!is_finite3(dd_round3(*normal)))
        return false;
    /* The error of the normal is a few 2^-104 of the product of the edges; below this limit it
     * would be visible. */
    const double least = 0x1p-40 * pen_largest3(dd_round3(e)) * pen_largest3(dd_round3(f));
    return pen_exact_enough(normal, least, v, 3, otherwise);
}

/* The bounds of a primitive with this outline whose surface is within `off` of its vertices' plane.
 * A line that passes outside the outline, within the rounding of ray space, may count as inside. If
 * it is not grazing, it meets the facet within 2^-40 of the extent outside the outline. */
static inline struct pen_box pen_outline_bounds(const struct pen_vec3 *v, uint32_t count,
                                                double off)
{
    struct pen_box b = pen_box_of_points(v, count);
    double pad = off + 0x1p-40 * pen_largest3(pen_sub(b.hi, b.lo));
    struct pen_vec3 p = pen_vec3(pad, pad, pad);
    return (struct pen_box){pen_sub(b.lo, p), pen_add(b.hi, p)};
}

#endif
