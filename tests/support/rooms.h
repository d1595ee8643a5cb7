/* SPDX-License-Identifier: MIT */
/* Closed rooms of flat primitives, from which no ray may escape, and places on their surfaces, for
 * rays that are aimed at edges and corners. */
#ifndef TESTS_SUPPORT_ROOMS_H
#define TESTS_SUPPORT_ROOMS_H

#include "support/world.h"

/* The shapes of rooms; convex ones come first. The orientation of each face is random. */
enum world_room {
    ROOM_BOX,       /* six quads */
    ROOM_TRIANGLES, /* the same, of twelve triangles */
    ROOM_PANE,      /* the same as the first, and a pane across it, the last primitive */
    ROOM_CONVEX_COUNT,
    ROOM_L = ROOM_CONVEX_COUNT, /* six quads between two concave polygons */
    ROOM_FOLDED,                /* a box with a dent or a bulge in every face */
    ROOM_BUMPY,                 /* a ball of triangles */
    ROOM_COUNT
};

/* Makes a room of a size of about 2, often rotated, at a distance of `far` from the origin. Returns
 * a point inside from which all walls are visible. */
struct pen_vec3 world_room(struct world *w, struct random *r, enum world_room room, double far);

/* Returns a random corner of the room, a point of an edge, or a point exactly on an edge, if the
 * ends of the edge allow such a point. */
struct pen_vec3 world_aim(const struct world *w, struct random *r);

/* The place where a ray has arrived. */
struct stand {
    struct pen_hit hit;
    struct pen_vec3 p, n; /* n: unit, on the side that the ray came from */
    struct pen_origin_surface origin;
};

/* Returns the place where a ray that starts on `origin` hits, as shading computes it. */
struct stand world_stand(const struct world *w, const struct pen_ray *ray,
                         const struct pen_origin_surface *origin, struct pen_hit hit);

/* Returns a direction on the side of the surface from which the ray came, or on the other side with
 * `through`. Also sets the origin surface of a ray in that direction. */
struct pen_vec3 stand_turn(const struct stand *s, struct random *r, bool through,
                           struct pen_origin_surface *origin);

#endif
