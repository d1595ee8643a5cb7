/* SPDX-License-Identifier: MIT */
/* Cases of one flat primitive and one ray. */
#ifndef TESTS_PROPERTY_FLAT_H
#define TESTS_PROPERTY_FLAT_H

#include "geom/prims.h"
#include "property/oracle.h"
#include "property/row.h"

/* Reads a case: a count (fixed), the corners v (at most 12), o and d. Returns the count, or 0. */
int flat_case(const struct row_case *c, vec3 *v, struct oracle_ray *line);
void flat_put(struct row_case *c, const vec3 *v, int count, vec3 o, vec3 d);

/* Returns true if the ray's line crosses the triangle or polygon of these corners. *made: the
 * primitive could be made. */
bool flat_cross(const vec3 *v, int count, const struct pen_ray *ray, double *t, bool *made);

/* A plane whose points at integer coordinates i, j are exact: multiples of 1/256. */
struct lattice {
    vec3 at, e, f;
};

struct lattice flat_lattice(struct random *r);
vec3 flat_lattice_point(const struct lattice *l, double i, double j);

#endif
