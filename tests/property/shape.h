/* SPDX-License-Identifier: MIT */
/* One primitive of any kind and one ray, and changes of the scene that must not matter to them. */
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

/* A shape as arguments of a case, and back: false if they are none. */
void shape_put(struct row_case *c, const struct shape *s);
bool shape_get(const struct row_case *c, int *at, struct shape *s);

/* A primitive of about unit size within 3 of the origin, and a ray that is aimed at it. All
 * coordinates but the direction's are multiples of 2^-12 if `snapped`. */
struct shape shape_draw(struct random *r, enum shape_kind kind, bool snapped);
vec3 shape_snap(vec3 p, bool snapped);

/* What is done to coordinates: the sign of each, a cyclic permutation, a factor, a shift. */
struct shape_map {
    vec3 sign, shift;
    int turn;
    double factor;
};

extern const struct shape_map shape_map_identity;

vec3 shape_map_way(const struct shape_map *m, vec3 v);
vec3 shape_map_point(const struct shape_map *m, vec3 p);
struct shape shape_mapped(const struct shape_map *m, const struct shape *s);

/* The intersections of the shape's own ray; false if the primitive or the ray can not be made. */
bool shape_cross(const struct shape *s, struct pen_intersections *out);

/* Where intersection i of what shape_cross was last asked about is, and the normal there. */
void shape_at(const struct pen_intersections *x, int i, vec3 *point, vec3 *normal);

/* The same intersections, t multiplied by `factor`, bit for bit. */
void shape_require_equal(struct row_verdict *v, enum shape_kind kind,
                         const struct pen_intersections *a, const struct pen_intersections *b,
                         double factor);

/* Whether the outline passes the ray so near that either answer may be given. */
bool shape_on_border(const struct shape *s);

#endif
