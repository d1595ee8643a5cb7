/* SPDX-License-Identifier: MIT */
/* The kinds of primitives: one row each.
 *
 * The list PEN_KINDS holds what is constant about a kind. The enumeration, the arrays of a scene,
 * and the table pen_kinds are made from it. What a kind computes is in a struct pen_kind_functions
 * at the end of the kind's own file. All other code uses the table, or a switch over enum
 * pen_prim_kind without `default`, which the compiler checks.
 *
 * A new kind needs two files (its header and its functions), one line in PEN_KINDS, one include in
 * geom/prims.h, and its words in the scene format. */
#ifndef PEN_GEOM_KIND_H
#define PEN_GEOM_KIND_H

#include <stddef.h>

#include "base/arena.h"
#include "geom/ray.h"
#include "math/box.h"

enum pen_kind_shape {
    PEN_KIND_FLAT, /* one intersection; a ray that starts on it does not meet it again */
    PEN_KIND_ROUND /* a quadric, perhaps with flat caps: one unit normal for each part and point */
};
enum pen_kind_extent {
    PEN_KIND_FINITE, /* has bounds */
    PEN_KIND_INFINITE
};

/* KIND(CONSTANT, name, word, shape, extent, most, cost) makes three things: enumerator
 * PEN_PRIM_CONSTANT, member `name` of struct pen_prims with elements of struct pen_name, and the
 * row of the table with functions pen_name_functions.
 *   word    its name in the scene format
 *   most    the most intersections of one ray with one primitive
 *   cost    for builders: the measured time of one block test, in units of a block of triangles; a
 *           block holds up to four primitives, or one if the kind has no block of its own */
#define PEN_KINDS(KIND)                                                                            \
    KIND(SPHERE, sphere, "sphere", ROUND, FINITE, 2, 1.0F)                                         \
    KIND(PLANE, plane, "plane", FLAT, INFINITE, 1, 1.0F)                                           \
    KIND(TRIANGLE, triangle, "triangle", FLAT, FINITE, 1, 1.0F)                                    \
    KIND(POLYGON, polygon, "polygon", FLAT, FINITE, 1, 2.0F)                                       \
    KIND(INFINITE_CYLINDER, infinite_cylinder, "tube", ROUND, INFINITE, 2, 3.0F)                   \
    KIND(CYLINDER, cylinder, "cylinder", ROUND, FINITE, 2, 3.0F)                                   \
    KIND(CONE, cone, "cone", ROUND, FINITE, 2, 10.0F)

enum pen_prim_kind {
#define KIND(NAME, ...) PEN_PRIM_##NAME,
    PEN_KINDS(KIND)
#undef KIND
        PEN_PRIM_KIND_COUNT
};

/* Tags of items in acceleration structures hold at most this number of kinds. */
#define PEN_PRIM_KINDS_MAX 16
_Static_assert(PEN_PRIM_KIND_COUNT <= PEN_PRIM_KINDS_MAX, "pen_prim_ref.kind has four bits");

/* Sets of kinds, by bit. */
#define FLAT_BIT(NAME, name, word, shape, ...)                                                     \
    (PEN_KIND_##shape == PEN_KIND_FLAT ? 1 << PEN_PRIM_##NAME : 0) |
#define INFINITE_BIT(NAME, name, word, shape, extent, ...)                                         \
    (PEN_KIND_##extent == PEN_KIND_INFINITE ? 1 << PEN_PRIM_##NAME : 0) |
enum { PEN_FLAT_KINDS = PEN_KINDS(FLAT_BIT) 0, PEN_INFINITE_KINDS = PEN_KINDS(INFINITE_BIT) 0 };
#undef FLAT_BIT
#undef INFINITE_BIT

/* Whether primitives of the kind are flat; if not, they are round. */
static inline bool pen_prim_flat(uint32_t kind)
{
    return (unsigned)PEN_FLAT_KINDS >> kind & 1;
}

/* Whether the kind has no bounds. */
static inline bool pen_prim_infinite(uint32_t kind)
{
    return (unsigned)PEN_INFINITE_KINDS >> kind & 1;
}

/* Whether primitives of the kind are flat and end at an outline. */
static inline bool pen_prim_outlined(uint32_t kind)
{
    return pen_prim_flat(kind) && !pen_prim_infinite(kind);
}

/* The corners of a flat primitive, in order. */
struct pen_outline {
    const struct pen_vec3 *v;
    uint32_t count;
    double extent; /* no two corners are farther apart along an axis */
};

/* The lengths that a primitive may have. */
enum pen_length { PEN_RADIUS, PEN_TOP_RADIUS, PEN_HEIGHT, PEN_LENGTHS };

/* The numbers that a primitive is made from. Each kind reads some of them and ignores the rest. */
struct pen_prim_source {
    struct pen_vec3 point; /* centre; a point of a plane or of an axis; the base's middle */
    /* The normal or axis, of any length except zero. Of a triangle or polygon: the normal to take
     * if its vertices are on one line, or zero to refuse them. */
    struct pen_vec3 direction;
    double length[PEN_LENGTHS];
    double rounding; /* u of the coordinates of `point` before they were moved to the local frame */
    bool caps;
    uint32_t count; /* of vertices */
    const struct pen_vec3 *vertices;
};

/* What a kind computes. `self` points at a primitive of the kind, in its array of struct pen_prims.
 * A part is an enum pen_part; a set of parts has bit 1 << part for each. */
struct pen_kind_functions {
    /* Makes a primitive.
     * Owns: if keeps_vertices, the primitive borrows the vertices for its life.
     * Fails: returns false if the numbers are out of the kind's range. */
    bool keeps_vertices;
    bool (*make)(void *self, const struct pen_prim_source *from);

    /* Completes a primitive that has been made, with memory from the arena; NULL: nothing to do.
     * Fails: returns false when out of memory. */
    bool (*cut)(void *self, struct pen_arena *arena);

    /* All intersections with the ray's line, of any sign, in ascending order, for a ray that starts
     * in free space. out->count is 0 before. */
    void (*intersect_line)(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out);

    /* Outward unit normal of the part at p, a point of it within rounding. */
    struct pen_vec3 (*normal)(const void *self, uint8_t part, struct pen_vec3 p);

    /* The point of the part's surface, continued without end, that is nearest p. */
    struct pen_vec3 (*project)(const void *self, uint8_t part, struct pen_vec3 p);

    /* As pen_prim_bounds. NULL: infinite. */
    struct pen_box (*bounds)(const void *self);

    /* As pen_prim_scale. */
    double (*scale)(const void *self, struct pen_vec3 p);

    /* How far the primitive extends along unit vector n beyond point p; INFINITY if without end. */
    double (*reach)(const void *self, struct pen_vec3 n, struct pen_vec3 p);

    /* A lower bound of the distance from p to the surface. NULL: use the distance to the bounds. */
    double (*distance)(const void *self, struct pen_vec3 p);

    /* The outline. NULL: the kind is round or infinite. */
    struct pen_outline (*outline)(const void *self);

    /* The following functions are NULL for flat kinds. */

    /* The largest angle in radians by which the normal of the part turns when p moves by one unit:
     * 1 over the radius; 0 on a cap, INFINITY at an apex. */
    double (*curvature)(const void *self, uint8_t part, struct pen_vec3 p);

    /* The parts that p lies on, up to `bound` and the primitive's own rounding. */
    unsigned (*touches)(const void *self, struct pen_vec3 p, double bound);

    /* The intersections with t > 0 of a ray that leaves this primitive from a point of `part`,
     * without the root at the origin. out->count is 0 before. */
    void (*intersect_own)(const void *self, const struct pen_ray *ray, uint8_t part,
                          struct pen_intersections *out);

    /* If the ray's origin touches the primitive within `bound`, replaces the intersections; the one
     * at the origin then has t = 0 exactly. Returns the set of parts that may count at the origin
     * although the line meets none of them, because the ray grazes a rim. */
    unsigned (*intersect_touching)(const void *self, const struct pen_ray *ray, double bound,
                                   struct pen_intersections *out);

    /* Whether the ray passes a rim within `bound`. NULL: the kind has no rims whose borders count.
     * Open primitive: the ray passes on the side or beyond it; *t is where it meets the side,
     * continued, and *part is the side. Closed primitive: *t is where the ray passes the plane of
     * the cap *part. */
    bool (*passes_rim)(const void *self, const struct pen_ray *ray, double bound, double *t,
                       uint8_t *part);
};

struct pen_kind {
    const char *name; /* the scene format's word */
    enum pen_kind_shape shape;
    enum pen_kind_extent extent;
    int most_intersections;
    float cost;
    size_t bytes; /* of one primitive */
    const struct pen_kind_functions *fn;
};

/* The table, by enum pen_prim_kind. */
extern const struct pen_kind pen_kinds[PEN_PRIM_KIND_COUNT];

#endif
