/* SPDX-License-Identifier: MIT */
/* Cases of one flat primitive and one ray. */
#ifndef TESTS_PROPERTY_FLAT_H
#define TESTS_PROPERTY_FLAT_H

#include "geom/prims.h"
#include "property/oracle.h"
#include "property/row.h"

/* A case is a count (fixed), so many corners, o and d. Reads it: v[12]; returns the count, or 0. */
int flat_case(const struct row_case *c, vec3 *v, struct oracle_ray *line);
void flat_put(struct row_case *c, const vec3 *v, int count, vec3 o, vec3 d);

/* Whether the ray's line crosses the triangle or polygon of these corners; *made: whether there is
 * such a primitive. */
bool flat_cross(const vec3 *v, int count, const struct pen_ray *ray, double *t, bool *made);

/* A plane whose lattice coordinates i, j give points that are exact: multiples of 1/256. */
struct lattice {
    vec3 at, e, f;
};

struct lattice flat_lattice(struct random *r);
vec3 flat_lattice_point(const struct lattice *l, double i, double j);

#endif
