/* SPDX-License-Identifier: MIT */
/* A group of a ray packet: its rays whose directions have the same largest axis and sign, as arrays
 * that are read LANES at a time, and the query in progress. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_H

#include "accel/internal/beam.h"
#include "accel/internal/traverse_query.h"
#include "accel/ray_packet.h"
#include "math/lanes.h"
#include "math/scale.h"

/* A group has parts of so many rays, each with a beam of its own. */
enum {
    GROUP_PART = 8,
    GROUP_PARTS = PEN_RAY_PACKET_MAX / GROUP_PART,
    GROUP_PART_BITS = (1 << GROUP_PART) - 1
};
_Static_assert((int)GROUP_PARTS == (int)BEAMS, "as many parts as beams are tested at once");

/* The four corners of a range of slopes, again and again where there are more lanes. */
enum { GROUP_CORNERS = LANES > 4 ? LANES : 4 };

/* Arrays and bits are by ray of the packet; rays that are not the group's have any numbers. Axes of
 * vectors are in the rays' own order, pen_permuted. */
struct ray_group {
    struct pen_ray_packet *packet;
    const struct pen_ray_array *rays; /* the packet's */
    const struct pen_accel *accel;
    uint64_t all;  /* the group's rays */
    uint64_t live; /* those that are not decided */
    uint64_t blocked;
    int ray_count, end; /* how many rays there are; one more than the last one's number */
    int axis[3];        /* kx, ky, kz */
    bool any;           /* shadow rays; else nearest intersections */
    bool from_surface;  /* some ray starts on a surface */
    bool to_point;
    struct pen_vec3 light; /* where rays to a point end */
    double extent;         /* no coordinate of origins, the light and finite boxes is larger */
    double light_bound;    /* what is farther from the light does not contain it */
    double grow;           /* the self-intersection rule reaches no farther than this */
    struct pen_box origins;
    /* For tests of outlines, see ray_group_outline.h: the point C, r x S, whether that vanishes,
     * and the corners of the range of slopes. edge_distance is 0 if numbers may underflow. */
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
    /* Of the ray's origin surface: pen_origin_surface.bound, struct trace's slack and near_sq; 0
     * and -1 for rays that start in free space. */
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

/* Of the rays from i on, a bit for each that is live. */
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

/* What a test knows of its primitive. */
struct group_prim {
    uint32_t prim;
    uint64_t rays;    /* the others surely miss it */
    uint64_t own;     /* those that start on it */
    bool near;        /* the origin of some ray may be on it, or on its border */
    bool see_through; /* a shadow ray passes through it */
    float depth;      /* no ray meets it at a smaller depth: beam_enters */
};

/* Of the rays from i on, those that start on the primitive. */
static inline unsigned group_starts_on(int i, const struct group_prim *q)
{
    return (unsigned)(q->own >> i) & LANES_ALL;
}

/* Of the rays from i on, whether some may still meet what lies at this depth or beyond. */
static inline bool group_reaches(const struct ray_group *g, int i, double depth)
{
    const lanes most = lanes_load(g->tmax + i) * lanes_abs(lanes_load(g->rays->d[2] + i));
    return lane_mask_bits(lanes_at_most(lanes_splat(depth), lanes_splat(1.0000001) * most));
}

/* Of the rays from i on, those that are to be tested against the primitive. */
static inline unsigned group_waits(const struct ray_group *g, int i, const struct group_prim *q)
{
    const unsigned live = (unsigned)((g->live & q->rays) >> i) & LANES_ALL;
    return live && q->depth > 0 && !group_reaches(g, i, (double)q->depth) ? 0 : live;
}

/* The query of shadow ray i of a packet, begun if it is its first use. */
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

/* The scalar test of one ray. `near`: its origin may be on the primitive's border. */
static __attribute__((noinline)) void group_fall_back(struct ray_group *g, int i, uint32_t prim,
                                                      bool near)
{
    struct pen_ray_packet *packet = g->packet;
    const struct pen_prims *prims = g->accel->prims;
    const bool generic =
        pen_block_of(prims->ref[prim].kind) == PEN_BLOCK_GENERIC || pen_prim_cut(prims, prim);
    struct pen_ray ray;
    pen_ray_array_get(g->rays, i, &ray);
    struct trace trace = trace_begin(g->accel, &ray, packet->origin[i]);
    trace.reaches_origin = trace.from_surface && near;
    if (g->any) {
        trace.shadow = packet_query(packet, i);
        if (g->to_point) {
            trace.light_bound = pen_ray_end_bound(ray.o, ray.d);
            trace.light = pen_along(ray.o, ray.d, trace.shadow->tmax);
        }
    } else {
        trace.after = packet->after[i];
        trace.best = packet->hit[i];
    }
    if (generic ? test_reference(&trace, prim, g->any) : test_one(&trace, prim, g->any))
        g->blocked |= UINT64_C(1) << i;
    if (!g->any) {
        packet->hit[i] = trace.best;
        g->tmax[i] = trace.best.t;
    }
}

/* The scalar tests of a group's lanes, a bit each. */
static inline void group_fall_back_all(struct ray_group *g, int i, unsigned fallback, uint32_t prim,
                                       bool near)
{
    for (; fallback; fallback &= fallback - 1)
        group_fall_back(g, i + __builtin_ctz(fallback), prim, near);
}

/* Records an intersection of each lane, if it is in the query's interval and before the best. */
static __attribute__((noinline)) void group_record(struct ray_group *g, int i, unsigned at, lanes t,
                                                   uint32_t prim, unsigned base, unsigned top)
{
    struct pen_ray_packet *packet = g->packet;
    double each[LANES];
    lanes_store(each, t);
    for (; at; at &= at - 1) {
        const int lane = __builtin_ctz(at), k = i + lane;
        const struct pen_hit hit = {each[lane], prim,
                                    base >> lane & 1  ? PEN_PART_BASE
                                    : top >> lane & 1 ? PEN_PART_TOP
                                                      : PEN_PART_SIDE};
        if (g->any) {
            if (hit.t > 0 && hit.t < g->tmax[k])
                keep_intersection(packet_query(packet, k), hit);
        } else if (pen_hit_before(packet->after[k], hit) && pen_hit_before(hit, packet->hit[k])) {
            packet->hit[k] = hit;
            g->tmax[k] = hit.t;
        }
    }
}

/* The lanes in which a shadow ray passes t. */
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

/* Records intersections at t with the side, in lanes where the scalar test would offer them. */
static inline void group_offer(struct ray_group *g, int i, unsigned at, lanes t,
                               const struct group_prim *q)
{
    if (g->any && !q->see_through) {
        g->blocked |= (uint64_t)(at & group_stops(g, i, t)) << i;
        return;
    }
    at &= group_sought(g, i, t);
    if (at)
        group_record(g, i, at, t, q->prim, 0, 0);
}

/* Where lines enter and leave a solid: lanes with such an end, t, and the lanes in which it is on a
 * cap. */
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
        const unsigned at = e->at[k] & group_sought(g, i, e->t[k]);
        if (at)
            group_record(g, i, at, e->t[k], q->prim, e->base[k], e->top[k]);
    }
}

#endif
