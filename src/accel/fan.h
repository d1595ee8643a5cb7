/* SPDX-License-Identifier: MIT */
/* Fans: the shadow rays from one point to the points of a disk, taken together. What no ray of the
 * fan can meet is left out once for all of them, and of what is left most rays are seen to meet it,
 * or to miss it, at the expense of a few multiplications. Nothing is decided where rounding could
 * change the answer: such a ray is tested as if it were alone. So a fan gives the answers that
 * pen_trace_ops.shadow gives ray by ray, bit for bit.
 *
 * How a ray is seen to meet a flat body: for an edge from p to q, d.((p - o) x (q - o)) says by its
 * sign on which side of the edge the ray passes (Pluecker's side relation), and since all rays have
 * one origin and d = c + a u + b v, that is a linear function of (a, b). So are d.n, which tells
 * whether the body's plane is met before the light, and (sphere's centre - o).d. Each is compared
 * with a band that is much wider than any rounding of it, or of the test that it stands for. */
#ifndef PEN_ACCEL_FAN_H
#define PEN_ACCEL_FAN_H

#include "geom/prims.h"

struct pen_accel;
struct pen_shadow;

enum { PEN_FAN_RAYS = 64, PEN_FAN_GATES = 48, PEN_FAN_LINES = 32, PEN_FAN_TINTS = 16 };

/* (e + a u + b v) against +-band: above it surely positive, below it surely negative. */
struct pen_fan_line {
    double e, u, v, band;
};

enum pen_gate_kind {
    PEN_GATE_LINES,    /* met where all lines are positive, missed where one is negative */
    PEN_GATE_OUTLINE,  /* a flat body of any outline */
    PEN_GATE_SPHERE,   /* from outside, and not beyond the disk; lines hold what fan.c says */
    PEN_GATE_BALL,     /* a sphere anywhere */
    PEN_GATE_CYLINDER, /* anywhere */
    PEN_GATE_ASK       /* nothing is sure */
};

/* A body that some ray of the fan may meet. */
struct pen_gate {
    uint32_t prim;
    uint8_t kind, lines;
    bool opaque;
    bool near;  /* the origin may be on it: the leave rule is asked */
    bool vague; /* where all lines are positive nothing is sure */
    bool own;   /* the rays leave it: where they do is no crossing */
    struct pen_fan_line line[PEN_FAN_LINES];
    /* Of the rays of the last pen_trace_ops.fan_look, those that must be tested alone, and of a
     * body that lets light pass, those that cross it once, and twice. */
    uint64_t ask, once, twice;
};

struct pen_fan {
    /* In: rays from o along d = (c + a u) + b v with a^2 + b^2 <= 1, u and v across c and each
     * other and of equal length; all leave one surface, and go to its viewer's side. */
    struct pen_vec3 o, c, u, v;
    const struct pen_leave *leave;
    bool to_point;              /* as in struct pen_shadow, with tmax 1; else tmax is infinite */
    const uint8_t *see_through; /* as in struct pen_shadow */
    uint32_t last_occluder;     /* in and out: tried first */
    /* Made by fan_begin. */
    double depth;                /* |c| */
    double slope_cos, slope_sin; /* of the cone's half-angle */
    struct pen_vec3 l;           /* c / |c| */
    double reach, delta, grow;   /* >= |d|; what lengths are off by; see fan.c */
    int gates, tints;
    uint8_t tint[PEN_FAN_TINTS]; /* gates of bodies that let light pass, if no more than that */
    struct pen_gate gate[PEN_FAN_GATES];
};

/* What becomes of all rays of a fan. */
enum pen_fan_fate {
    PEN_FAN_OPEN,  /* they arrive */
    PEN_FAN_SHUT,  /* an opaque body blocks them */
    PEN_FAN_MIXED, /* fan_look tells */
    PEN_FAN_NONE   /* they must be cast one by one: too many bodies, or no tree for it */
};

/* The direction of the ray to (a, b): the same operations, in this order, wherever it is made. */
static inline struct pen_vec3 pen_fan_way(const struct pen_fan *fan, double a, double b)
{
    return pen_along(pen_along(fan->c, fan->u, a), fan->v, b);
}

#endif
