/* SPDX-License-Identifier: MIT */
/* Disk packets: the shadow rays from one point to the points of a disk, tested together.
 *
 * The tree is traversed once for all rays. The result is candidates: primitives that some ray may
 * meet. A few multiplications per ray and candidate then classify most rays as certainly blocked by
 * it or certainly not. Where rounding could change the answer, nothing is decided: such a ray is
 * tested alone (scalar fallback). So a packet gives the answers of pen_trace_ops.shadow ray by ray,
 * bit for bit. src/accel/README.md describes the steps.
 *
 * Whether a ray meets a flat primitive: for an edge from p to q, the sign of d.((p - o) x (q - o))
 * is the side of the edge on which the ray passes (Pluecker's side relation). All rays have one
 * origin and d = c + a u + b v, so this is a linear function of (a, b). The products d.n and
 * (sphere's centre - o).d are linear too; d.n decides whether the ray reaches the primitive's plane
 * before the light. Each value is compared with a band that is much wider than its own rounding and
 * that of the test it replaces. */
#ifndef PEN_ACCEL_DISK_PACKET_H
#define PEN_ACCEL_DISK_PACKET_H

#include "geom/prims.h"

struct pen_accel;
struct pen_shadow;

enum {
    PEN_DISK_RAYS = 64,
    PEN_DISK_CANDIDATES = 48,
    PEN_DISK_LINES = 32,
    PEN_DISK_TRANSMISSIVE = 16,
    PEN_DISK_SEQUENCE = 8
};

/* The line e + a u + b v = 0 in the disk. A value above band is certainly positive, one below -band
 * certainly negative. */
struct pen_disk_line {
    double e, u, v, band;
};

enum pen_disk_candidate_kind {
    PEN_DISK_CANDIDATE_LINES,        /* hit if all lines are positive, missed if one is negative */
    PEN_DISK_CANDIDATE_OUTLINE,      /* a flat primitive with any outline; see outline_candidate */
    PEN_DISK_CANDIDATE_SPHERE_AHEAD, /* the origin is outside; the whole sphere is before the disk
                                      */
    PEN_DISK_CANDIDATE_SPHERE,       /* a sphere anywhere */
    PEN_DISK_CANDIDATE_CYLINDER,     /* a cylinder anywhere */
    PEN_DISK_CANDIDATE_FALLBACK      /* every ray is tested alone */
};

/* A primitive that some ray of the packet may meet. */
struct pen_disk_candidate {
    uint32_t prim;
    uint8_t kind, lines;
    bool opaque;
    bool by_reference; /* the origin may be on it: pen_prim_intersect tests fallback rays */
    bool plane_only;   /* the lines prove only misses: if all are positive, nothing is certain */
    bool is_origin;    /* the rays start on it, which is no intersection */
    struct pen_disk_line line[PEN_DISK_LINES];
    /* The plane of a flat primitive is at t = height / d.n. `facing` gives d.n; its band is that of
     * a length along n. */
    struct pen_disk_line facing;
    double height;
    /* Results of the last pen_trace_ops.disk_test: the rays that must be tested alone; if the
     * primitive transmits light, also the rays that intersect it once and twice. */
    uint64_t fallback, once, twice;
};

struct pen_disk_packet {
    /* In: rays from o along d = (c + a u) + b v with a^2 + b^2 <= 1. u and v have equal length and
     * are perpendicular to c and to each other. All rays start on one surface and go to its
     * viewer's side. */
    struct pen_vec3 o, c, u, v;
    const struct pen_origin_surface *origin;
    bool to_point;              /* as in struct pen_shadow, with tmax 1; else tmax is infinite */
    const uint8_t *see_through; /* as in struct pen_shadow */
    uint32_t last_occluder;     /* in and out: tested first */
    /* Set by disk_begin. */
    double depth;              /* |c| */
    double cone_cos, cone_sin; /* of the half-angle of the cone that the rays fill */
    struct pen_vec3 axis;      /* c / |c| */
    double reach, delta, grow; /* >= |d|; bounds of errors of lengths: see disk_candidate.c */
    int candidate_count, transmissive_count;
    uint8_t transmissive[PEN_DISK_TRANSMISSIVE]; /* numbers of candidates that transmit light */
    struct pen_disk_candidate candidate[PEN_DISK_CANDIDATES];
    /* Set by disk_test: the rays with more than two transmissive intersections, and for each the
     * numbers of the candidates that it intersects, in order. */
    uint64_t in_sequence;
    uint8_t sequence[PEN_DISK_RAYS][PEN_DISK_SEQUENCE], sequence_count[PEN_DISK_RAYS];
};

/* What is true for all rays of a packet. */
enum pen_disk_visibility {
    PEN_DISK_ALL_VISIBLE,  /* no primitive blocks any ray */
    PEN_DISK_ALL_OCCLUDED, /* one opaque primitive blocks them all */
    PEN_DISK_MIXED,        /* disk_test decides for each ray */
    PEN_DISK_NOT_POSSIBLE  /* trace them one by one: too many candidates, or no wide tree */
};

/* The direction of the ray to (a, b). Every caller uses this function, so the operations, their
 * order and their bits are the same. */
static inline struct pen_vec3 pen_disk_packet_direction(const struct pen_disk_packet *packet,
                                                        double a, double b)
{
    return pen_along(pen_along(packet->c, packet->u, a), packet->v, b);
}

#endif
