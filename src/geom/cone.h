/* SPDX-License-Identifier: MIT */
/* Cones, pointed or truncated, capped or open. At distance s along the axis from the base, the
 * radius is base_radius + slope s. As for a cylinder, the part of a ray inside is the overlap of
 * two t-intervals: of the side, and of the slab between base and top. The slab is the one of the
 * hull, a cylinder around the cone.
 *
 * The equation of the side describes a double cone. Only one of its two nappes has a positive
 * radius. Between base and top every radius is positive or 0, so the slab cuts the other nappe off.
 *
 * Outward is away from the axis on the side and along the axis on the caps. The normal of the apex,
 * and of points that are the apex within rounding, is the axis, away from the base. It is the mean
 * of the normals around the apex, but no part of the surface has it. So an apex seen from outside
 * is shaded with the normal of the side that faces the viewer (pen_cone_apex_normal). */
#ifndef PEN_GEOM_CONE_H
#define PEN_GEOM_CONE_H

#include "geom/cylinder.h"

struct pen_cone {
    struct pen_cylinder hull; /* same base, axis and height; the larger of the two radii */
    double base_radius, top_radius;
    double slope, slope_low; /* (top_radius - base_radius) / height, in two doubles */
    double width, width_low; /* base_radius |a|, in two doubles */
    double slant;            /* sqrt(1 + slope^2) */
};

/* Makes a cone. Equal radii are allowed, because a group's scale may round two radii to one value.
 * Fails: returns false if an argument is not finite, the axis is zero, r or h is outside 2^-400 ...
 * 2^400, top_r is neither 0 nor in that range, or |slope| is neither 0 nor in 2^-200 ... 2^200. */
bool pen_cone_make(struct pen_cone *c, struct pen_vec3 base, struct pen_vec3 axis, double r,
                   double top_r, double h, bool caps);

/* Sets *n to the normal of the side at the apex that faces the viewer; any such normal if the
 * viewer is on the axis. Returns false if p is not the apex within rounding, or is not seen from
 * outside along d. */
bool pen_cone_apex_normal(const struct pen_cone *c, struct pen_vec3 p, struct pen_vec3 d,
                          struct pen_vec3 *n);

/* The t-interval of the ray's line inside the cone; false if there is none. Ends at the caps of an
 * open cone are no intersections; the caller drops them. */
bool pen_cone_interval(const struct pen_cone *c, const struct pen_ray *ray,
                       struct pen_interval *in);

#endif
