/* SPDX-License-Identifier: MIT */
/* One primitive of any kind and one ray, and changes of the scene that must not change the
 * result. */
#ifndef TESTS_PROPERTY_SHAPE_H
#define TESTS_PROPERTY_SHAPE_H

#include "property/row.h"
#include "support/world.h"

enum shape_kind {
    SHAPE_SPHERE,
    SHAPE_INFINITE_CYLINDER,
    SHAPE_CYLINDER,
    SHAPE_TRIANGLE,
    SHAPE_POLYGON,
    SHAPE_PLANE,
    SHAPE_KINDS
};

/* A primitive: points (centre, base, a point of the plane, corners), a direction, lengths; and a
 * ray. */
struct shape {
    enum shape_kind kind;
    vec3 p[4], a;
    double r, h;
    vec3 o, d;
};

extern const char *const shape_kind_name[SHAPE_KINDS];

/* How many points a kind has. */
int shape_points(enum shape_kind kind);

/* Writes a shape as arguments of a case, and reads it back; false if they are no shape. */
void shape_put(struct row_case *c, const struct shape *s);
bool shape_get(const struct row_case *c, int *at, struct shape *s);

/* Draws a primitive of about unit size within 3 of the origin, and a ray that is aimed at it. If
 * `snapped`, all coordinates but the direction's are multiples of 2^-12. */
struct shape shape_draw(struct random *r, enum shape_kind kind, bool snapped);
vec3 shape_snap(vec3 p, bool snapped);

/* A change of coordinates: the sign of each, a cyclic permutation, a factor, a shift. */
struct shape_map {
    vec3 sign, shift;
    int turn;
    double factor;
};

extern const struct shape_map shape_map_identity;

vec3 shape_map_way(const struct shape_map *m, vec3 v);
vec3 shape_map_point(const struct shape_map *m, vec3 p);
struct shape shape_mapped(const struct shape_map *m, const struct shape *s);

/* Finds the intersections of the shape's own ray; false if the primitive or the ray cannot be
 * made. */
bool shape_cross(const struct shape *s, struct pen_intersections *out);

/* Finds the place and the normal of intersection i of the last call of shape_cross. */
void shape_at(const struct pen_intersections *x, int i, vec3 *point, vec3 *normal);

/* Requires the same intersections, bit for bit, with t multiplied by `factor`. */
void shape_require_equal(struct row_verdict *v, enum shape_kind kind,
                         const struct pen_intersections *a, const struct pen_intersections *b,
                         double factor);

/* Returns true if the outline passes so near the ray that both answers are allowed. */
bool shape_on_border(const struct shape *s);

#endif
