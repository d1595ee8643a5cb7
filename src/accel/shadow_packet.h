/* SPDX-License-Identifier: MIT */
/* Fans: the shadow rays from one point to the points of a disk, taken together. What no ray of the
 * packet can meet is left out once for all of them, and of what is left most rays are seen to meet
 * it, or to miss it, at the expense of a few multiplications. Nothing is decided where rounding
 * could change the answer: such a ray is tested as if it were alone. So a packet gives the answers
 * that pen_trace_ops.shadow gives ray by ray, bit for bit.
 *
 * How a ray is seen to meet a flat primitive: for an edge from p to q, d.((p - o) x (q - o)) says
 * by its sign on which side of the edge the ray passes (Pluecker's side relation), and since all
 * rays have one origin and d = c + a u + b v, that is a linear function of (a, b). So are d.n,
 * which tells whether the primitive's plane is met before the light, and (sphere's centre - o).d.
 * Each is compared with a band that is much wider than any rounding of it, or of the test that it
 * stands for. */
#ifndef PEN_ACCEL_SHADOW_PACKET_H
#define PEN_ACCEL_SHADOW_PACKET_H

#include "geom/prims.h"

struct pen_accel;
struct pen_shadow;

enum {
    PEN_PACKET_RAYS = 64,
    PEN_PACKET_CANDIDATES = 48,
    PEN_PACKET_LINES = 32,
    PEN_PACKET_TRANSMISSIVE = 16
};

/* (e + a u + b v) against +-band: above it surely positive, below it surely negative. */
struct pen_packet_line {
    double e, u, v, band;
};

enum pen_candidate_kind {
    PEN_CANDIDATE_LINES,   /* met where all lines are positive, missed where one is negative */
    PEN_CANDIDATE_OUTLINE, /* a flat primitive of any outline */
    PEN_CANDIDATE_SPHERE, /* from outside, and not beyond the disk; lines hold what packet.c says */
    PEN_CANDIDATE_BALL,   /* a sphere anywhere */
    PEN_CANDIDATE_CYLINDER, /* anywhere */
    PEN_CANDIDATE_FALLBACK  /* nothing is sure */
};

/* A primitive that some ray of the packet may meet. */
struct pen_candidate {
    uint32_t prim;
    uint8_t kind, lines;
    bool opaque;
    bool near;  /* the origin may be on it: the self-intersection rule is asked */
    bool vague; /* where all lines are positive nothing is sure */
    bool own;   /* the rays leave it: where they do is no crossing */
    struct pen_packet_line line[PEN_PACKET_LINES];
    /* Of the rays of the last pen_trace_ops.packet_test, those that must be tested alone, and of a
     * primitive that lets light pass, those that cross it once, and twice. */
    uint64_t ask, once, twice;
};

struct pen_shadow_packet {
    /* In: rays from o along d = (c + a u) + b v with a^2 + b^2 <= 1, u and v across c and each
     * other and of equal length; all leave one surface, and go to its viewer's side. */
    struct pen_vec3 o, c, u, v;
    const struct pen_origin_surface *origin;
    bool to_point;              /* as in struct pen_shadow, with tmax 1; else tmax is infinite */
    const uint8_t *see_through; /* as in struct pen_shadow */
    uint32_t last_occluder;     /* in and out: tried first */
    /* Made by packet_begin. */
    double depth;                /* |c| */
    double slope_cos, slope_sin; /* of the cone's half-angle */
    struct pen_vec3 l;           /* c / |c| */
    double reach, delta, grow;   /* >= |d|; what lengths are off by; see packet.c */
    int candidate_count, transmissive_count;
    uint8_t transmissive[PEN_PACKET_TRANSMISSIVE]; /* candidates of primitives that let light pass,
                                                      if no more than that */
    struct pen_candidate candidate[PEN_PACKET_CANDIDATES];
};

/* What becomes of all rays of a packet. */
enum pen_packet_visibility {
    PEN_PACKET_ALL_VISIBLE,  /* they arrive */
    PEN_PACKET_ALL_OCCLUDED, /* an opaque primitive blocks them */
    PEN_PACKET_MIXED,        /* packet_test tells */
    PEN_PACKET_NOT_POSSIBLE  /* they must be cast one by one: too many primitives, or no tree for it
                              */
};

/* The direction of the ray to (a, b): the same operations, in this order, wherever it is made. */
static inline struct pen_vec3 pen_packet_direction(const struct pen_shadow_packet *packet, double a,
                                                   double b)
{
    return pen_along(pen_along(packet->c, packet->u, a), packet->v, b);
}

#endif
