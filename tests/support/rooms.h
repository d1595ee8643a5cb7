/* SPDX-License-Identifier: MIT */
/* Closed rooms of flat primitives, and places on their surfaces where rays arrive: for rays that
 * are aimed on purpose at edges and corners. */
#ifndef TESTS_SUPPORT_ROOMS_H
#define TESTS_SUPPORT_ROOMS_H

#include "support/world.h"

/* Convex ones come first. Their faces have one outward side or the other, by chance. */
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

/* Makes a room about 2 across, often turned, `far` from the origin; returns a point inside it that
 * sees all walls. */
struct pen_vec3 world_room(struct world *w, struct random *r, enum world_room room, double far);

/* A corner of the room, a point of an edge, or one that is exactly on it if its ends allow. */
struct pen_vec3 world_aim(const struct world *w, struct random *r);

/* Where a ray has arrived. */
struct stand {
    struct pen_hit hit;
    struct pen_vec3 p, n; /* n: unit, on the side that the ray came from */
    struct pen_origin_surface origin;
};

/* The point of a hit of a ray that starts on `origin`, as shading computes it. */
struct stand world_stand(const struct world *w, const struct pen_ray *ray,
                         const struct pen_origin_surface *origin, struct pen_hit hit);

/* A direction on the side of the surface that the ray came from (through: on the other side), and
 * the origin surface of a ray in that direction. */
struct pen_vec3 stand_turn(const struct stand *s, struct random *r, bool through,
                           struct pen_origin_surface *origin);

#endif
