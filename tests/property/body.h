/* SPDX-License-Identifier: MIT */
/* Closed bodies around the origin, of size about 1: rooms seen from inside, solids seen from
 * outside. Each is star-shaped: a ray from the origin stays inside up to the surface. So places
 * inside and outside are known without the renderer. A pose puts a body into a scene. */
#ifndef TESTS_PROPERTY_BODY_H
#define TESTS_PROPERTY_BODY_H

#include "property/row.h"
#include "support/kit.h"

/* In this order: flat bodies; bodies whose walls reach beyond their edges; round bodies; bodies
 * closed by surfaces of several kinds. */
enum body_kind {
    BODY_BOX,
    BODY_SPLIT_BOX, /* of triangles */
    BODY_PRISM,     /* 3 to 24 walls */
    BODY_SPLIT_PRISM,
    BODY_FRUSTUM,
    BODY_PYRAMID,
    BODY_TETRAHEDRON,
    BODY_DENTED, /* a box whose walls are pyramids of four triangles, inward or outward */
    BODY_STAR,   /* 32 triangles, radii at random */
    BODY_LAST_FLAT = BODY_STAR,
    BODY_CROSSING, /* a box of quads that cross each other */
    BODY_PLANES,
    BODY_THICK, /* each wall is a box */
    BODY_LAST_CROSSING = BODY_THICK,
    BODY_SPHERE,
    BODY_CYLINDER,
    BODY_CONE,
    BODY_CUT_CONE,
    BODY_LAST_ROUND = BODY_CUT_CONE,
    BODY_SHEETS,    /* an open cylinder between two sheets */
    BODY_OPEN_CONE, /* an open cone, cut or not, between sheets */
    BODY_TUBE,      /* an infinite cylinder between two planes */
    BODY_LIDS,      /* an open cylinder between flat cylinders of the same radius, or wider ones */
    BODY_LAST_MIXED = BODY_LIDS
};

enum { BODY_VERTICES = 64, BODY_FACES = 64, BODY_CORNERS = 24 };

struct body {
    enum body_kind kind;
    int vertices, faces;
    vec3 v[BODY_VERTICES];
    int corners[BODY_FACES], corner[BODY_FACES][BODY_CORNERS]; /* counter-clockwise from outside */
    vec3 half;                                                 /* of a box around it */
    double r, top, h; /* round: radius at z = -h, at z = h */
    double over;      /* how far walls reach beyond their edges, or how thick they are */
    double poke;      /* how far open sides reach through their lids */
    double thin;      /* its least half width */
};

/* Where a body stands in a scene: o + size (x p.x + y p.y + z p.z). */
struct body_pose {
    vec3 o, x, y, z;
    double size;
    bool group; /* the scene has a group with that transform, around the body as it is */
};

/* A body drawn at random; `thin` scales it along z. */
void body_make(struct body *b, enum body_kind kind, struct random *r, double thin);

/* Makes walls of several kinds reach through each other, where offsets round them apart. */
void body_overlap(struct body *b);

/* Draws a pose: turned at random, about z, or not at all. The offset is in sizes. */
struct body_pose body_pose(struct random *r, double size, double offset);
vec3 body_place(const struct body_pose *pose, vec3 p);
struct pen_transform body_transform(const struct body_pose *pose);
vec3 body_turn(const struct body_pose *pose, vec3 d); /* a direction, unit if d is */

/* Returns its vertex i as in the scene. */
vec3 body_vertex(const struct body *b, const struct body_pose *pose, int i);

/* Adds its primitives to the kit, as a group if the pose says so. */
void body_add(const struct body *b, const struct body_pose *pose, struct kit *kit, int material);

/* Returns the distance from the origin to its surface in this direction (unit). */
double body_reach(const struct body *b, vec3 dir);

/* Returns how deep p is inside. For a convex body, a negative value means outside by at least that
 * distance. For other bodies it is a lower bound. */
double body_depth(const struct body *b, vec3 p);

/* Returns a random direction that also finds the ends of thin bodies. */
vec3 body_direction(const struct body *b, struct random *r);

/* Returns a place on a seam or a corner; or a place on the surface, with the normal there. */
vec3 body_seam(const struct body *b, struct random *r);
vec3 body_surface(const struct body *b, struct random *r, vec3 *n);

/* Returns the distance in sizes that must separate inside from outside, because coordinates and
 * transforms are rounded. */
double body_rounding(const struct body_pose *pose);

#endif
