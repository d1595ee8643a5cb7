/* SPDX-License-Identifier: MIT */
/* Acceleration structures: a builder makes a frozen structure over the finite primitives; infinite
 * ones stay in a short list beside it. Every kind gives the same intersections, bit for bit:
 * boxes are float, rounded outward, and tested so that no intersection is ever missed (Ize, JCGT
 * 2(2), 2013, and directed rounding of origins); a box is entered when its near distance is
 * <= the best t; the order of intersections is that of geom/ray.h.
 *
 * Threads: a built tree is immutable and may be used by any number of threads. */
#ifndef PEN_ACCEL_ACCEL_H
#define PEN_ACCEL_ACCEL_H

#include "accel/shadow_packet.h"
#include "base/arena.h"
#include "base/cpu.h"
#include "base/status.h"
#include "geom/prims.h"

enum pen_accelerator {
    PEN_ACCEL_AUTO,   /* surface-area heuristic: a tree of up to eight children to a node */
    PEN_ACCEL_NONE,   /* every primitive, in order */
    PEN_ACCEL_CBR,    /* a box for each primitive, in one list */
    PEN_ACCEL_MANUAL, /* the same, and a box and a list for each group of the document */
    PEN_ACCEL_MEDIAN  /* median split: a binary tree of single primitives, or
                       * of up to four triangles */
};
enum { PEN_ACCEL_COUNT = PEN_ACCEL_MEDIAN + 1 };

struct pen_accel; /* lives in the arena it was built in */

struct pen_accel_stats {
    enum pen_accelerator kind;
    uint32_t nodes;  /* with children that have boxes; of cbr and manual one for each list */
    uint32_t leaves; /* each a box's content; none has one, without a box */
    uint32_t depth;  /* boxes around the innermost primitive */
    uint64_t bytes;  /* beside the primitives themselves */
    /* Expected cost of a ray in units of one primitive test, by the surface-area heuristic, the
     * same for all kinds: the primitives of the leaves it enters, 0.15 for each box of the nodes it
     * enters, and 1 for each infinite primitive. It enters the first node, and what is in a box
     * with the probability area(box) / area(box around all finite primitives), those of a random
     * line through the latter; that a ray begins, ends or is blocked is left out. */
    double sah_cost;
    double build_ms;
};

/* Builds. Units: local frame. Owns: the structure borrows `prims`, which must outlive it. Cost:
 * n log n or better for every kind; nothing is deeper than 64 boxes. PEN_ACCEL_MANUAL is built as
 * if there were no groups. Fails: PEN_NO_MEMORY. */
struct pen_accel *pen_accel_build(const struct pen_prims *prims, enum pen_accelerator kind,
                                  struct pen_arena *arena, struct pen_status *st);

/* Groups of primitives: those with numbers from begin to end - 1. A group comes before those inside
 * it, and two either nest or have nothing in common. */
struct pen_group_range {
    uint32_t begin, end;
};

struct pen_groups {
    const struct pen_group_range *group;
    uint32_t count;
};

/* Builds PEN_ACCEL_MANUAL. Owns: nothing of `groups` is kept. Else as pen_accel_build. */
struct pen_accel *pen_accel_build_manual(const struct pen_prims *prims,
                                         const struct pen_groups *groups, struct pen_arena *arena,
                                         struct pen_status *st);

const struct pen_accel_stats *pen_accel_get_stats(const struct pen_accel *accel);

/* Which intersections a query looks for: after `after` in the order of intersections, and t <=
 * tmax. For a fresh ray `after` is pen_after_start, which means t > 0. */
struct pen_t_interval {
    struct pen_hit after;
    double tmax;
};

extern const struct pen_hit pen_after_start;

enum { PEN_SHADOW_MAX = 32 };

/* A shadow query: intersections with 0 < t < tmax (strictly). With `to_point` set the ray ends in a
 * light at t = 1 = tmax, and a surface that contains the light within rounding is not crossed.
 * see_through[prim] != 0 marks primitives that let light pass; NULL means none does. */
struct pen_shadow {
    double tmax;
    bool to_point;
    const uint8_t *see_through;
    uint32_t last_occluder; /* in and out: tried first; PEN_NO_PRIM at start */
    /* Results, valid when the query returned false (not blocked): see-through intersections in
     * order. With more than PEN_SHADOW_MAX, `overflow` is set and the caller walks the ray with
     * `nearest` instead. */
    bool overflow;
    int count;
    struct pen_hit hit[PEN_SHADOW_MAX];
};

/* How far o + d may be from the light that a shadow ray was aimed at: d = light - o was rounded,
 * so a far origin counts as much as a far light. */
static inline double pen_shadow_light_bound(const struct pen_ray *ray)
{
    return 16 * PEN_U * (pen_norm1(ray->o) + pen_norm1(ray->d));
}

/* The traversals, one table per compiled variant; all variants give the same bits. */
struct pen_trace_ops {
    const char *name;
    /* First intersection in the span; false if there is none. */
    bool (*nearest)(const struct pen_accel *accel, const struct pen_ray *ray,
                    const struct pen_origin_surface *origin, const struct pen_t_interval *interval,
                    struct pen_hit *hit);
    /* Whether an opaque surface is crossed. */
    bool (*shadow)(const struct pen_accel *accel, const struct pen_ray *ray,
                   const struct pen_origin_surface *origin, struct pen_shadow *query);
    /* The three steps of a packet (accel/packet.h); NULL where rays are counted one by one.
     * packet_begin: what becomes of all its rays. If PEN_PACKET_MIXED, packet_test: of n <=
     * PEN_PACKET_RAYS of them, given by (a, b), a bit set for each that is blocked, and in
     * *fallback one for each of which that is not known, or not how often it crosses which
     * primitives: then packet_ray does for ray i what `shadow` does, but for last_occluder. The
     * other rays cross what the candidates named in `tint` say, no more than twice in all, so that
     * the order does not matter. */
    enum pen_packet_visibility (*packet_begin)(const struct pen_accel *accel,
                                               struct pen_shadow_packet *packet);
    uint64_t (*packet_test)(struct pen_shadow_packet *packet, const double a[PEN_PACKET_RAYS],
                            const double b[PEN_PACKET_RAYS], int n, uint64_t *fallback);
    bool (*packet_ray)(const struct pen_accel *accel, const struct pen_shadow_packet *packet,
                       const struct pen_ray *ray, int i, struct pen_shadow *query);
};

/* The table for an instruction set; falls back to the baseline where a build lacks it. */
const struct pen_trace_ops *pen_trace_ops_get(enum pen_isa isa);

/* Tests of queries. A box test compares one box with one ray; the boxes of a node that is looked
 * into count all, since they are tested together. A primitive test looks for the intersections of
 * one primitive; those of a block (up to four of one kind, side by side in a leaf) count all,
 * whichever of them ends the query. */
struct pen_test_counts {
    uint64_t boxes, primitives;
};

/* Counting queries are compiled apart, so that the others cost nothing for it. They give the same
 * answers, but do not try `last_occluder`, so that what a ray costs does not depend on the rays
 * before it: counts are a pure function of (accelerator, ray), equal in all variants, and their
 * sums are the same for any division of the work. They take an accelerator made by
 * pen_accel_count_new only. */
const struct pen_trace_ops *pen_trace_count_ops_get(enum pen_isa isa);

/* The same accelerator, as one thread sees it: its queries add to *counts.
 * Owns: free with pen_accel_count_free; borrows both. Fails: NULL when out of memory. */
struct pen_accel *pen_accel_count_new(const struct pen_accel *accel,
                                      struct pen_test_counts *counts);
void pen_accel_count_free(struct pen_accel *view);

#endif
