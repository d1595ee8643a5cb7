/* SPDX-License-Identifier: MIT */
/* Acceleration structures. A builder makes a frozen structure over the finite primitives; infinite
 * ones are in a short list beside it. Every kind of structure gives the same intersections, bit for
 * bit:
 *  - Boxes are floats rounded outward. Their test never hides an intersection (Ize, JCGT 2(2),
 *    2013, and directed rounding of origins).
 *  - A box is entered if its near distance is <= the best t.
 *  - Intersections have the order of geom/ray.h.
 * src/accel/README.md describes the structures.
 *
 * Threads: a built tree is immutable; any number of threads may use it. */
#ifndef PEN_ACCEL_ACCEL_H
#define PEN_ACCEL_ACCEL_H

#include "accel/disk_packet.h"
#include "accel/ray_packet.h"
#include "base/arena.h"
#include "base/cpu.h"
#include "base/status.h"
#include "geom/prims.h"

enum pen_accelerator {
    PEN_ACCEL_AUTO,   /* the choice with the least expected time, of enum pen_auto_choice */
    PEN_ACCEL_NONE,   /* every primitive, in order */
    PEN_ACCEL_CBR,    /* a box for each primitive, in one list */
    PEN_ACCEL_MANUAL, /* as CBR, with a box and a list for each group of the document */
    PEN_ACCEL_MEDIAN /* median split: a binary tree of single primitives, or of up to four triangles
                      */
};
enum { PEN_ACCEL_COUNT = PEN_ACCEL_MEDIAN + 1 };

/* The choices of PEN_ACCEL_AUTO. The tree is built by the surface-area heuristic, with up to eight
 * children per node. */
enum pen_auto_choice {
    PEN_AUTO_NONE,   /* the list of PEN_ACCEL_NONE, ray by ray */
    PEN_AUTO_TREE,   /* the tree, ray by ray */
    PEN_AUTO_PACKETS /* the tree, rays in packets (accel/ray_packet.h) */
};
enum { PEN_AUTO_COUNT = PEN_AUTO_PACKETS + 1 };

/* "none", "tree" or "packets". */
const char *pen_auto_choice_name(enum pen_auto_choice choice);

struct pen_accel; /* lives in the arena in which it was built */

struct pen_accel_stats {
    enum pen_accelerator kind;
    uint32_t nodes;  /* for cbr and manual: lists */
    uint32_t leaves; /* for none: 1, which has no box */
    uint32_t depth;  /* number of boxes around the innermost primitive */
    uint64_t bytes;  /* of the structure, without the primitives themselves */
    /* Expected cost of a ray in units of one primitive test, by the surface-area heuristic,
     * computed the same way for all kinds. It is the sum of 1 for each primitive of the entered
     * leaves, 0.15 for each box of the entered nodes, and 1 for each infinite primitive. A ray
     * always enters the first node. It enters a box with probability area(box) / area(box around
     * all finite primitives), as a random line through the latter does. The cost ignores where rays
     * begin, end and are blocked. */
    double sah_cost;
    double build_ms;
    /* For PEN_ACCEL_AUTO: the choice, and the expected time of a ray's query with each choice
     * (src/accel/auto_choice.c). The unit is one test of a block of four triangles. The choice with
     * the least time is taken, the first of equals. The times are a pure function of the
     * primitives: no machine, thread or setting changes them. Without finite primitives there is no
     * tree, and only the time of PEN_AUTO_NONE is finite. */
    enum pen_auto_choice choice;
    double expected[PEN_AUTO_COUNT];
};

/* Builds a structure; PEN_ACCEL_MANUAL as if there were no groups.
 * Units: local frame.
 * Owns: the structure borrows `prims`, which must outlive it.
 * Fails: PEN_NO_MEMORY; PEN_TOO_LARGE for more than 2^26 - 1 primitives.
 * Cost: n log n or better for every kind; no primitive is inside more than 64 boxes. */
struct pen_accel *pen_accel_build(const struct pen_prims *prims, enum pen_accelerator kind,
                                  struct pen_arena *arena, struct pen_status *st);

/* As pen_accel_build. PEN_ACCEL_AUTO is built by up to `threads` threads, which end with the call.
 * Their number changes no bit of the structure. */
struct pen_accel *pen_accel_build_threads(const struct pen_prims *prims, enum pen_accelerator kind,
                                          int threads, struct pen_arena *arena,
                                          struct pen_status *st);

/* A group: the primitives with numbers begin ... end - 1. A group comes before the groups inside
 * it; two groups either nest or are disjoint. */
struct pen_group_range {
    uint32_t begin, end;
};

struct pen_groups {
    const struct pen_group_range *group;
    uint32_t count;
};

/* Builds PEN_ACCEL_MANUAL, else as pen_accel_build.
 * Owns: keeps no reference to `groups`. */
struct pen_accel *pen_accel_build_manual(const struct pen_prims *prims,
                                         const struct pen_groups *groups, struct pen_arena *arena,
                                         struct pen_status *st);

const struct pen_accel_stats *pen_accel_get_stats(const struct pen_accel *accel);

/* The intersections that a query considers: those after `after` in the order of intersections, with
 * t <= tmax. For a new ray, `after` is pen_after_start, which means t > 0. */
struct pen_t_interval {
    struct pen_hit after;
    double tmax;
};

extern const struct pen_hit pen_after_start;

/* Whether a primitive transmits light: see struct pen_shadow. */
static inline bool pen_see_through(const struct pen_prims *prims, const uint8_t *see_through,
                                   uint32_t prim)
{
    return see_through && see_through[pen_prim_slot(prims, prim)];
}

enum { PEN_SHADOW_MAX = 32 };

/* A shadow query considers intersections with 0 < t < tmax. With `to_point`, the ray ends in a
 * light at t = 1 = tmax, and a surface that contains the light within rounding does not count.
 * see_through[pen_prim_slot(prim)] != 0 marks primitives that transmit light; NULL means that no
 * primitive does.
 */
struct pen_shadow {
    double tmax;
    bool to_point;
    const uint8_t *see_through;
    uint32_t last_occluder; /* in and out: tested first; PEN_NO_PRIM at start */
    /* Results, valid if the query returned false (not blocked): the intersections with primitives
     * that transmit light, in order. If there are more than PEN_SHADOW_MAX, `overflow` is set. Then
     * the caller must trace the ray with `nearest`, one intersection after the other. */
    bool overflow;
    int count;
    struct pen_hit hit[PEN_SHADOW_MAX];
};

/* The queries, one table for each compiled variant. All variants give the same bits. */
struct pen_trace_ops {
    const char *name;
    /* Finds the first intersection in the interval; false if there is none. */
    bool (*nearest)(const struct pen_accel *accel, const struct pen_ray *ray,
                    const struct pen_origin_surface *origin, const struct pen_t_interval *interval,
                    struct pen_hit *hit);
    /* Whether an opaque primitive blocks the ray. */
    bool (*shadow)(const struct pen_accel *accel, const struct pen_ray *ray,
                   const struct pen_origin_surface *origin, struct pen_shadow *query);
    /* The same for all rays of a packet (accel/ray_packet.h). They return a bit for each ray that
     * has a hit, or that is blocked. NULL in counting variants. */
    uint64_t (*nearest_packet)(const struct pen_accel *accel, struct pen_ray_packet *packet);
    uint64_t (*shadow_packet)(const struct pen_accel *accel, struct pen_ray_packet *packet);
    /* The three steps of a disk packet (accel/disk_packet.h); NULL in counting variants.
     *  1. disk_begin collects the candidates and returns what is true for all rays.
     *  2. If that is PEN_DISK_MIXED, disk_test tests n <= PEN_DISK_RAYS rays, given by (a, b). It
     *     returns a bit for each blocked ray. *fallback gets a bit for each undecided ray: whether
     *     it is blocked, or how often it intersects which primitives, is not certain. Every other
     *     ray intersects the candidates in `transmissive` whose once and twice name it. If it has
     *     more than two such intersections in all, it is in in_sequence, and `sequence` has their
     *     order. The order of two does not matter for a product.
     *  3. disk_ray does for ray i of *fallback what `shadow` does, without last_occluder. */
    enum pen_disk_visibility (*disk_begin)(const struct pen_accel *accel,
                                           struct pen_disk_packet *packet);
    uint64_t (*disk_test)(struct pen_disk_packet *packet, const double a[PEN_DISK_RAYS],
                          const double b[PEN_DISK_RAYS], int n, uint64_t *fallback);
    bool (*disk_ray)(const struct pen_accel *accel, const struct pen_disk_packet *packet,
                     const struct pen_ray *ray, int i, struct pen_shadow *query);
};

/* The table for an instruction set. Its functions run only on processors that have this set
 * (pen_cpu_isa). */
const struct pen_trace_ops *pen_trace_ops_get(enum pen_isa isa);

/* Numbers of tests. A box test compares one box with one ray. All boxes of a visited node count,
 * because they are tested together. A primitive test computes the intersections of one primitive.
 * All primitives of a block (up to four of one kind in a leaf) count, even if one of them ends the
 * query. */
struct pen_test_counts {
    uint64_t boxes, primitives;
};

/* The table of queries that count their tests. They are compiled separately, so that the other
 * queries have no cost for it. They give the same answers but do not try `last_occluder`, so the
 * cost of a ray does not depend on earlier rays. Counts are a pure function of (accelerator, ray)
 * and equal in all variants. Their sums are the same for any division of the work. The queries
 * accept only an accelerator made by pen_accel_count_new. */
const struct pen_trace_ops *pen_trace_count_ops_get(enum pen_isa isa);

/* A view of an accelerator for one thread: counting queries of the view add to *counts.
 * Owns: free with pen_accel_count_free; borrows both.
 * Fails: NULL when out of memory. */
struct pen_accel *pen_accel_count_new(const struct pen_accel *accel,
                                      struct pen_test_counts *counts);
void pen_accel_count_free(struct pen_accel *view);

#endif
