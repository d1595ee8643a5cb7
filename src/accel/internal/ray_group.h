/* SPDX-License-Identifier: MIT */
/* A group of a ray packet: its rays whose directions have the same largest axis and sign, as arrays
 * for LANES rays at a time, and the query in progress. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_H

#include "accel/internal/beam.h"
#include "accel/internal/traverse_query.h"
#include "accel/ray_packet.h"
#include "math/lanes.h"
#include "math/scale.h"

/* A group has parts of GROUP_PART rays, each with its own beam. */
enum {
    GROUP_PART = 8,
    GROUP_PARTS = PEN_RAY_PACKET_MAX / GROUP_PART,
    GROUP_PART_BITS = (1 << GROUP_PART) - 1
};
_Static_assert((int)GROUP_PARTS == (int)BEAMS, "as many parts as beams are tested at once");

/* The four corners of a range of slopes, repeated to fill the lanes. */
enum { GROUP_CORNERS = LANES > 4 ? LANES : 4 };

/* Arrays and bits are by ray of the packet. Entries of rays outside the group are undefined. Axes
 * of vectors are in the rays' own order, pen_permuted. */
struct ray_group {
    struct pen_ray_packet *packet;
    const struct pen_ray_array *rays; /* the packet's */
    const struct pen_accel *accel;
    uint64_t all;  /* the group's rays */
    uint64_t live; /* the rays that are not decided */
    uint64_t blocked;
    int ray_count, end; /* number of rays; one more than the last ray's number */
    int axis[3];        /* kx, ky, kz */
    bool any;           /* shadow rays; else nearest intersections */
    bool from_surface;  /* some ray starts on a surface */
    bool to_point;
    struct pen_vec3 light; /* the end of rays to a point */
    double extent;         /* the largest coordinate of origins, the light and finite boxes */
    double light_bound;    /* a primitive farther from the light does not contain it */
    double grow;           /* the reach of the self-intersection rule */
    struct pen_box origins;
    /* For tests of outlines, see ray_group_outline.h: the point C, whether r x S vanishes, the
     * corners of the range of slopes, and r x S. edge_distance is 0 if numbers may underflow. */
    struct pen_vec3 middle;
    bool concurrent;
    double edge_distance, most_slack;
    double corner[2][GROUP_CORNERS];
    double moment[3][PEN_RAY_PACKET_MAX];
    struct beam beam;
    struct beams parts;
    unsigned part_bits;                             /* the parts that have rays */
    lane_mask in_group[PEN_RAY_PACKET_MAX / LANES]; /* `all` */
    double after_t[PEN_RAY_PACKET_MAX], tmax[PEN_RAY_PACKET_MAX];
    /* Nearest: the part that is met at tmax, as group_part_number. */
    double met[PEN_RAY_PACKET_MAX];
    /* By the ray's origin surface: pen_origin_surface.bound, struct trace's slack and near_sq. They
     * are 0, 0 and -1 for rays that start in free space. */
    double bound[PEN_RAY_PACKET_MAX], slack[PEN_RAY_PACKET_MAX], near_sq[PEN_RAY_PACKET_MAX];
};

static inline struct lanes3 group_origin(const struct ray_group *g, int i)
{
    const struct pen_ray_array *r = g->rays;
    return (struct lanes3){lanes_load(r->o[0] + i), lanes_load(r->o[1] + i),
                           lanes_load(r->o[2] + i)};
}

static inline struct lanes3 group_direction(const struct ray_group *g, int i)
{
    const struct pen_ray_array *r = g->rays;
    return (struct lanes3){lanes_load(r->d[0] + i), lanes_load(r->d[1] + i),
                           lanes_load(r->d[2] + i)};
}

/* A vector of space in the rays' order of axes. */
static inline struct pen_vec3 group_permuted(const struct ray_group *g, const struct pen_vec3 *v)
{
    const double *c = (const double *)v;
    return pen_vec3(c[g->axis[0]], c[g->axis[1]], c[g->axis[2]]);
}

/* The same in all lanes. */
static inline struct lanes3 group_splat(const struct ray_group *g, struct pen_vec3 v)
{
    return lanes3_splat(group_permuted(g, &v));
}

/* A bit for each live ray, from ray i on. */
static inline unsigned group_live(const struct ray_group *g, int i)
{
    return (unsigned)(g->live >> i) & LANES_ALL;
}

/* The rays that start on the primitive. */
static inline uint64_t group_own(const struct ray_group *g, uint32_t prim)
{
    const struct pen_ray_packet *packet = g->packet;
    for (int k = 0; k < packet->starts_count; k++)
        if (packet->starts[k].prim == prim)
            return packet->starts[k].rays;
    return 0;
}

/* A primitive for a test. */
struct group_prim {
    uint32_t prim;
    uint64_t rays;    /* the other rays certainly miss it */
    uint64_t own;     /* the rays that start on it */
    bool near;        /* the origin of some ray may be on it, or on its border */
    bool see_through; /* a shadow ray passes through it */
    float depth;      /* a lower bound of the depth at which a ray meets it: beam_near */
};

/* A bit for each ray that starts on the primitive, from ray i on. */
static inline unsigned group_starts_on(int i, const struct group_prim *q)
{
    return (unsigned)(q->own >> i) & LANES_ALL;
}

/* Whether some of the rays from i on may still meet a primitive at this depth or beyond. */
static inline bool group_reaches(const struct ray_group *g, int i, double depth)
{
    const lanes most = lanes_load(g->tmax + i) * lanes_abs(lanes_load(g->rays->d[2] + i));
    return lane_mask_bits(lanes_at_most(lanes_splat(depth), lanes_splat(1.0000001) * most));
}

/* A bit for each ray to be tested against the primitive, from ray i on. */
static inline unsigned group_waits(const struct ray_group *g, int i, const struct group_prim *q)
{
    const unsigned live = (unsigned)((g->live & q->rays) >> i) & LANES_ALL;
    return live && q->depth > 0 && !group_reaches(g, i, (double)q->depth) ? 0 : live;
}

/* A part of a primitive as one number, for a lane. */
static inline double group_part_number(uint32_t prim, uint8_t part)
{
    return prim + 0x1p32 * part;
}

/* The nearest intersection of ray i so far. */
static inline struct pen_hit group_hit(const struct ray_group *g, int i)
{
    const uint64_t met = (uint64_t)g->met[i];
    return (struct pen_hit){g->tmax[i], (uint32_t)met, (uint8_t)(met >> 32)};
}

static inline void group_set_hit(struct ray_group *g, int i, struct pen_hit hit)
{
    g->tmax[i] = hit.t;
    g->met[i] = group_part_number(hit.prim, hit.part);
}

/* The query of shadow ray i of a packet. Its first use begins it. */
static inline struct pen_shadow *packet_query(struct pen_ray_packet *packet, int i)
{
    struct pen_shadow *query = &packet->queries[i];
    if (!(packet->recorded >> i & 1)) {
        query->tmax = packet->to_point ? 1 : INFINITY;
        query->to_point = packet->to_point;
        query->see_through = packet->see_through;
        query->last_occluder = PEN_NO_PRIM;
        query->overflow = false;
        query->count = 0;
        packet->recorded |= UINT64_C(1) << i;
    }
    return query;
}

/* The scalar test of one ray. `near`: the ray's origin may be on the primitive's border. */
static __attribute__((noinline)) void group_fall_back(struct ray_group *g, int i, uint32_t prim,
                                                      bool near)
{
    struct pen_ray_packet *packet = g->packet;
    const struct pen_prims *prims = g->accel->prims;
    const bool generic =
        pen_block_of(pen_prim_kind(prims, prim)) == PEN_BLOCK_GENERIC || pen_prim_cut(prims, prim);
    struct pen_ray ray;
    pen_ray_array_get(g->rays, i, &ray);
    struct trace trace;
    trace_begin(&trace, g->accel, &ray, packet->origin[i]);
    trace.reaches_origin = trace.from_surface && near;
    if (g->any) {
        trace.shadow = packet_query(packet, i);
        if (g->to_point) {
            trace.light_bound = pen_ray_end_bound(ray.o, ray.d);
            trace.light = pen_along(ray.o, ray.d, trace.shadow->tmax);
        }
    } else {
        trace.after = packet->after[i];
        trace.best = group_hit(g, i);
    }
    if (generic ? test_reference(&trace, prim, g->any) : test_one(&trace, prim, g->any))
        g->blocked |= UINT64_C(1) << i;
    if (!g->any)
        group_set_hit(g, i, trace.best);
}

/* The scalar tests of a group's lanes, given as bits. */
static inline void group_fall_back_all(struct ray_group *g, int i, unsigned fallback, uint32_t prim,
                                       bool near)
{
    for (; fallback; fallback &= fallback - 1)
        group_fall_back(g, i + __builtin_ctz(fallback), prim, near);
}

/* An intersection in each of some lanes. */
struct group_met {
    unsigned at, base, top; /* the lanes, and those of them on a cap */
    lanes t;
    uint32_t prim;
};

static inline struct pen_hit group_met_hit(const struct group_met *met, int lane)
{
    return (struct pen_hit){lanes_at(met->t, lane), met->prim,
                            met->base >> lane & 1  ? PEN_PART_BASE
                            : met->top >> lane & 1 ? PEN_PART_TOP
                                                   : PEN_PART_SIDE};
}

/* Records intersections through which shadow rays pass. */
static __attribute__((noinline)) void group_record_shadow(struct ray_group *g, int i,
                                                          const struct group_met *met)
{
    for (unsigned at = met->at; at; at &= at - 1) {
        const int lane = __builtin_ctz(at), k = i + lane;
        const struct pen_hit hit = group_met_hit(met, lane);
        if (hit.t > 0 && hit.t < g->tmax[k])
            keep_intersection(packet_query(g->packet, k), hit);
    }
}

/* Records intersections whose t equals that of another one; the primitive and the part decide their
 * order. */
static __attribute__((noinline)) void group_record_ties(struct ray_group *g, int i,
                                                        const struct group_met *met)
{
    for (unsigned at = met->at; at; at &= at - 1) {
        const int lane = __builtin_ctz(at), k = i + lane;
        const struct pen_hit hit = group_met_hit(met, lane);
        if (pen_hit_before(g->packet->after[k], hit) && pen_hit_before(hit, group_hit(g, k)))
            group_set_hit(g, k, hit);
    }
}

/* Records intersections in the queries' intervals that are before the best. */
static inline void group_record_nearest(struct ray_group *g, int i, struct group_met *met)
{
    const lanes best = lanes_load(g->tmax + i), after = lanes_load(g->after_t + i);
    const unsigned ties =
        met->at & lane_mask_bits(lanes_equal(met->t, best) | lanes_equal(met->t, after));
    const lane_mask quick = lane_mask_of(met->at & ~ties);
    lanes part = lanes_splat(group_part_number(met->prim, PEN_PART_SIDE));
    if (met->base)
        part = lanes_select(lane_mask_of(met->base),
                            lanes_splat(group_part_number(met->prim, PEN_PART_BASE)), part);
    if (met->top)
        part = lanes_select(lane_mask_of(met->top & ~met->base),
                            lanes_splat(group_part_number(met->prim, PEN_PART_TOP)), part);
    lanes_store(g->tmax + i, lanes_select(quick, met->t, best));
    lanes_store(g->met + i, lanes_select(quick, part, lanes_load(g->met + i)));
    met->at = ties;
    if (ties)
        group_record_ties(g, i, met);
}

/* The lanes in which t blocks a shadow ray. */
static inline unsigned group_stops(const struct ray_group *g, int i, lanes t)
{
    return lane_mask_bits(lanes_less(lanes_splat(0), t) & lanes_less(t, lanes_load(g->tmax + i)));
}

/* The lanes in which t may be in the query's interval. */
static inline unsigned group_sought(const struct ray_group *g, int i, lanes t)
{
    return lane_mask_bits(lanes_at_most(t, lanes_load(g->tmax + i)) &
                          lanes_at_most(lanes_load(g->after_t + i), t));
}

/* Records intersections in the lanes in which t may be in the query's interval. */
static inline void group_record(struct ray_group *g, int i, struct group_met *met)
{
    met->at &= group_sought(g, i, met->t);
    if (met->at && g->any)
        group_record_shadow(g, i, met);
    else if (met->at)
        group_record_nearest(g, i, met);
}

/* Records intersections at t with the side, in lanes where the scalar test would offer them. */
static inline void group_offer(struct ray_group *g, int i, unsigned at, lanes t,
                               const struct group_prim *q)
{
    if (g->any && !q->see_through) {
        g->blocked |= (uint64_t)(at & group_stops(g, i, t)) << i;
        return;
    }
    struct group_met met = {at, 0, 0, t, q->prim};
    group_record(g, i, &met);
}

/* Where lines enter and leave a solid: the lanes that have such an end, t, and the lanes in which
 * the end is on a cap. */
struct group_ends {
    unsigned at[2], base[2], top[2];
    lanes t[2];
};

/* As group_offer, for both ends. */
static inline void group_offer_ends(struct ray_group *g, int i, const struct group_ends *e,
                                    const struct group_prim *q)
{
    if (g->any && !q->see_through) {
        const unsigned stops =
            (e->at[0] & group_stops(g, i, e->t[0])) | (e->at[1] & group_stops(g, i, e->t[1]));
        g->blocked |= (uint64_t)stops << i;
        return;
    }
    for (int k = 0; k < 2; k++) {
        struct group_met met = {e->at[k], e->base[k], e->top[k], e->t[k], q->prim};
        group_record(g, i, &met);
    }
}

#endif
