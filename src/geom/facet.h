/* SPDX-License-Identifier: MIT */
/* Facets: the planes of triangles and polygons. The winding rule of geom/triangle.h decides whether
 * a ray passes inside the outline. The facet decides where the ray meets the plane, by the exact
 * position of one vertex and a normal in double-double. So t is off by a few units of its last
 * place, and a distance from the plane has a relative error. Neither depends on the size of the
 * primitive or the place of its vertices. */
#ifndef PEN_GEOM_FACET_H
#define PEN_GEOM_FACET_H

#include "geom/ray.h"

/* A point in ray space: the ray is the z axis and its origin is 0. z is not yet divided by d[kz].
 */
struct pen_sheared {
    double x, y, z;
};

static inline struct pen_sheared pen_shear(const struct pen_ray *ray, const struct pen_vec3 *v)
{
    struct pen_vec3 f = pen_sub(pen_permuted(ray, v), ray->permuted_o);
    return (struct pen_sheared){f.x - ray->sx * f.z, f.y - ray->sy * f.z, f.z};
}

/* Twice the area of (ray, P, Q) seen along the ray; its sign is exact. */
static inline double pen_edge(struct pen_sheared p, struct pen_sheared q)
{
    return pen_dop(p.x, q.y, p.y, q.x);
}

/* What edge PQ, with s = pen_edge(p, q), adds to the winding number: +1, -1 or 0. */
static inline int pen_edge_counts(struct pen_sheared p, struct pen_sheared q, double s)
{
    return (p.y <= 0 && q.y > 0 && s > 0) - (p.y > 0 && q.y <= 0 && s < 0);
}

/* The plane g.x = c, each number in two doubles. */
struct pen_facet {
    struct pen_vec3 g, g_low; /* the largest component is in [1/2, 1] */
    double c, c_low;
    struct pen_vec3 n; /* the unit normal */
    /* A line whose sine is below about this value may meet the facet far outside an outline that
     * it is seen to pass inside. INFINITY: the outline is not in a plane. */
    double grazing;
};

#define PEN_FACET_GRAZING (1 / 0x1p10)

/* How far the facet is above p, times |g|. The error is some u of the result plus 2^-100 |g| (|p| +
 * |c|). */
static inline double pen_facet_above(const struct pen_facet *facet, struct pen_vec3 p)
{
    return pen_dot2_plus(facet->c, pen_neg(facet->g), p, facet->c_low - pen_dot(facet->g_low, p));
}

/* The t at which the ray's line meets the facet; not finite if it is parallel. The error is at most
 * 4u of t; where a sum cancels to less than 2^-48 of its terms, 2^-100 of these terms.
 * *grazing: the angle is small, below about 2^-10. Then a line that is seen to pass inside an
 * outline, within the rounding of ray space, may meet the facet far outside the outline. */
static inline double pen_facet_root(const struct pen_facet *facet, const struct pen_ray *ray,
                                    bool *grazing)
{
    const struct pen_facet permuted = {pen_permuted(ray, &facet->g),
                                       pen_permuted(ray, &facet->g_low),
                                       facet->c,
                                       facet->c_low,
                                       facet->n,
                                       facet->grazing};
    double gd =
        pen_dot2_plus(0, permuted.g, ray->permuted_d, pen_dot(permuted.g_low, ray->permuted_d));
    *grazing = fabs(gd) < facet->grazing * fabs(ray->permuted_d.z);
    return pen_facet_above(&permuted, ray->permuted_o) / gd;
}

/* The same in single sums: within 2^-30 of t. NaN if grazing, or if that error is not certain. */
static inline double pen_facet_root_roughly(const struct pen_facet *facet,
                                            const struct pen_ray *ray)
{
    struct pen_vec3 g = pen_permuted(ray, &facet->g);
    double above = facet->c - pen_dot(g, ray->permuted_o), gd = pen_dot(g, ray->permuted_d);
    bool sure = fabs(above) >= 0x1p-16 * (fabs(facet->c) + pen_norm1(ray->permuted_o)) &&
                fabs(gd) >= 2 * facet->grazing * fabs(ray->permuted_d.z);
    return sure ? above / gd : NAN;
}

/* The t at which a grazing line that passes inside the outline meets its facet. Two depths bound
 * it: of the edges before and behind the line, as the line is seen, up to their rounding. `t` is
 * clamped to them, unless that moves it from behind the origin to before it. For a line that runs
 * along the facet, the result is the mean of these depths. */
double pen_outline_grazed(const struct pen_vec3 *v, uint32_t count, const struct pen_ray *ray,
                          double t);

/* The t at which a line that passes inside the outline meets its facet. */
static inline double pen_outline_root(const struct pen_facet *facet, const struct pen_vec3 *v,
                                      uint32_t count, const struct pen_ray *ray)
{
    bool grazing;
    double t = pen_facet_root(facet, ray, &grazing);
    if (!grazing)
        return t;
    return pen_outline_grazed(v, count, ray, facet->grazing < INFINITY ? t : INFINITY);
}

/* Projects p onto the facet's plane, to u |p|_1. */
static inline struct pen_vec3 pen_facet_project(const struct pen_facet *facet, struct pen_vec3 p)
{
    return pen_along(p, facet->g, pen_facet_above(facet, p) / pen_dot(facet->g, facet->g));
}

#endif
