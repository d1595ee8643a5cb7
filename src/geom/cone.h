/* SPDX-License-Identifier: MIT */
/* Cones, pointed or truncated, capped or open. At distance s along the axis from the base the
 * radius is base_radius + slope s. As for a cylinder, the part of a ray inside is the overlap of
 * two t-intervals, one of the side and one of the slab between base and top; the slab is that of
 * the hull, a cylinder around the cone.
 *
 * The equation of the side describes a double cone. Only one of its two nappes has a positive
 * radius, and between base and top every radius is positive or 0: the slab cuts the other nappe
 * off.
 *
 * Outward is away from the axis on the side and along the axis on the caps. The normal of the apex,
 * and of points that are the apex within rounding, is the axis, away from the base: the mean of the
 * normals around it. No part of the surface has that normal, so an apex that is seen from outside
 * is shaded with the normal of the side that faces the viewer (pen_cone_apex_normal). */
#ifndef PEN_GEOM_CONE_H
#define PEN_GEOM_CONE_H

#include "geom/cylinder.h"

struct pen_cone {
    struct pen_cylinder hull; /* same base, axis and height; the larger of the two radii */
    double base_radius, top_radius;
    double slope, slope_low; /* (top_radius - base_radius) / height, to twice the precision */
    double width, width_low; /* base_radius |a|, to twice the precision */
    double slant;            /* sqrt(1 + slope^2) */
};

/* Fails: returns false if an argument is not finite, the axis is zero, r or h is not in
 * 2^-400 ... 2^400, top_r is neither 0 nor in that range, or the slope is neither 0 nor, without
 * its sign, in 2^-200 ... 2^200. Equal radii are taken: a group's scale may round them so. */
bool pen_cone_make(struct pen_cone *c, struct pen_vec3 base, struct pen_vec3 axis, double r,
                   double top_r, double h, bool caps);

/* If p is the apex within rounding, and is seen from outside along d, sets *n to the normal of the
 * side there that faces the viewer, which is any side for a viewer on the axis. Else returns false.
 */
bool pen_cone_apex_normal(const struct pen_cone *c, struct pen_vec3 p, struct pen_vec3 d,
                          struct pen_vec3 *n);

/* The t-interval of the ray's line inside; false if there is none. Ends at the caps of an open cone
 * are no intersections: the caller drops them. */
bool pen_cone_interval(const struct pen_cone *c, const struct pen_ray *ray,
                       struct pen_interval *in);

#endif
