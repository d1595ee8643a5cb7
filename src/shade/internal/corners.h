/* SPDX-License-Identifier: MIT */
/* Corners: a path that meets one face of a wedge within rounding of the other brings no light and
 * is not mirrored there (surface_hardly_left), so the wedge would be dark along its edge. Such a
 * pixel sample is rendered again by the pixel kernel: the ray to the first surface that the path
 * met in the wedge is moved a little along that surface, away from the edge. README.md, Corners,
 * derives how far. */
#ifndef PEN_SHADE_INTERNAL_CORNERS_H
#define PEN_SHADE_INTERNAL_CORNERS_H

#include "geom/ray.h"

enum {
    CORNERS_MAX = 8,  /* of a pixel sample */
    CORNER_TRIES = 24 /* how often a sample is begun again for one of them */
};

/* Where the hits of a path are near one another: the first of them, and the last. */
struct corner_link {
    struct pen_vec3 p, n, left; /* n: the first surface's normal; left: the last one's, towards the
                                   side on which the path goes on. All of unit length */
    double bound;               /* of p */
    uint32_t first; /* number of the first surface in the pixel sample, from 1 on; 0: the
                       path has met none, or goes straight on */
};

/* A first surface to which the ray is moved. */
struct corner {
    uint32_t first; /* number of the surface in the pixel sample */
    int tries;
    struct pen_vec3 p, n; /* where the ray meets it, and the unit normal there */
    double bound;         /* of p */
    struct pen_vec3 away; /* along the surface, a sum of unit vectors away from edges */
    double step;          /* how far */
};

struct corners {
    struct corner at[CORNERS_MAX]; /* by number of the surface, ascending */
    int count;
    uint32_t surfaces;           /* of the pixel sample so far */
    bool again;                  /* the sample is to be begun again */
    struct corner_link link;     /* of the path that is traced */
    struct corner_link *waiting; /* of those on the stack */
};

/* A hit of a path that begins at its link's last surface. */
struct corner_hit {
    struct pen_vec3 p, n; /* n is turned towards the viewer */
    double bound;
    bool hardly_left;
};

/* By how much the ray to the next surface of the sample is moved; NULL where it is not. */
struct corner *pen_corner_at(struct corners *corners);

/* The moved ray meets another surface first, at p, where its normal towards the viewer is n: moves
 * it farther. False if it is to be left where it is. */
bool pen_corner_avoid(struct corner *corner, struct pen_vec3 p, struct pen_vec3 n);

/* Goes on with the link at the next surface of the sample. Returns whether the sample is to be
 * begun again, with a ray that is moved farther. */
bool pen_corner_met(struct corners *corners, const struct corner_hit *hit);

#endif
