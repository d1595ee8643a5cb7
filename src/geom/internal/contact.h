/* SPDX-License-Identifier: MIT */
/* The contact of a ray's origin with a surface that contains it: from which side the ray comes, and
 * whether the surface counts there. src/geom/SELF_INTERSECTION.md derives the rule. P is the
 * primitive that the ray starts on, Q another one. Bounds are as in geom/ray.h. All functions are
 * pure. */
#ifndef PEN_GEOM_INTERNAL_CONTACT_H
#define PEN_GEOM_INTERNAL_CONTACT_H

#include <math.h>
#include <stddef.h>

#include "geom/internal/kinds.h"
#include "geom/prims.h"
#include "math/scale.h"

/* The distance by which an intersection of the primitive near p may miss it. */
static inline double pen_own_rounding(const struct pen_prims *prims, uint32_t prim,
                                      struct pen_vec3 p)
{
    return 8 * PEN_U * pen_prim_scale(prims, prim, p);
}

/* A surface to judge: a primitive, or a triangle of a cut polygon. */
struct pen_surface {
    const struct pen_kind_functions *fn;
    const void *self;
};

static inline struct pen_surface pen_surface_of_piece(const struct pen_triangle *piece)
{
    return (struct pen_surface){&pen_triangle_functions, piece};
}

/* The surface of the primitive; if it is a cut polygon, its triangle at p. `room` as in
 * pen_prim_self. */
static inline struct pen_surface pen_surface_at(const struct pen_prims *prims, uint32_t prim,
                                                struct pen_vec3 p, struct pen_triangle *room)
{
    const struct pen_polygon *polygon = pen_prim_cut(prims, prim);
    if (polygon)
        return pen_surface_of_piece(pen_polygon_piece(polygon, p));
    return (struct pen_surface){pen_prim_row(prims, prim)->fn, pen_prim_self(prims, prim, room)};
}

static inline struct pen_outline pen_surface_outline(struct pen_surface s)
{
    return s.fn->outline ? s.fn->outline(s.self) : (struct pen_outline){NULL, 0, 0};
}

/* Whether p is within b of the segment from a to c. */
static inline bool pen_near_segment(struct pen_vec3 a, struct pen_vec3 c, struct pen_vec3 p,
                                    double b)
{
    struct pen_vec3 e = pen_sub(c, a), f = pen_sub(p, a);
    double ee = pen_dot(e, e), s = ee > 0 ? pen_dot(f, e) / ee : 0;
    struct pen_vec3 off = pen_along(f, e, s < 0 ? 0 : s > 1 ? -1 : -s);
    return pen_dot(off, off) <= b * b;
}

/* The height of p above a flat surface with unit normal n, to some u of |p|; the distance of the
 * vertices does not matter. */
static inline double pen_height_above(struct pen_surface s, struct pen_vec3 n, struct pen_vec3 p)
{
    return pen_dot(n, pen_sub(p, s.fn->project(s.self, PEN_PART_SIDE, p)));
}

/* Whether p is within b of a flat primitive with unit normal n: of its border or its inside. */
bool pen_surface_contains(struct pen_surface s, struct pen_vec3 n, struct pen_vec3 p, double b);

/* The contact of a primitive Q with the origin of a ray that starts on another primitive P. */
struct pen_contact {
    const struct pen_prims *prims;
    const struct pen_origin_surface *origin; /* P */
    struct pen_hit q;                        /* Q and its part */
    struct pen_surface surface;              /* that of Q */
    struct pen_vec3 p, n;                    /* the ray's origin, and Q's unit normal there */
    double slack;                            /* the distance by which p may miss Q */
    double own;                              /* the rounding of Q itself */
    double share;                            /* d counts as parallel to Q if |d.n| <= share |d| */
};

/* Makes the contact of q, whose surface is s, with the origin of `ray`. The plane of a flat
 * primitive is known to `slack` over its whole extent, which bounds `share`. */
struct pen_contact pen_contact_at(const struct pen_prims *prims, struct pen_hit q,
                                  struct pen_surface s, const struct pen_ray *ray,
                                  const struct pen_origin_surface *origin);

/* d.n; 0 if it is within rounding. */
double pen_contact_across(const struct pen_contact *c, struct pen_vec3 d);

/* The side of Q on which the path began, by its last ray that decides; 0 if none decides. */
double pen_contact_path_side(const struct pen_contact *c);

/* Whether Q extends beyond P's tangent plane on the side to which the ray goes. */
bool pen_contact_rises(const struct pen_contact *c, struct pen_vec3 d);

/* Whether a flat Q extends beyond P's tangent plane near p, where the ray passes Q's border. If Q
 * rises only farther away, no ray is low enough to meet it there (PEN_HORIZON_SINE). Without this
 * test, a corner that the rounding of the document has lifted over P would count. */
bool pen_contact_rises_nearby(const struct pen_contact *c, struct pen_vec3 d);

/* Whether a ray along d is too low over a surface with unit normal n: it has not risen above the
 * bounds at the end of the range in which borders are tested (PEN_NEARBY). */
bool pen_grazes(struct pen_vec3 n, struct pen_vec3 d);

/* Whether an intersection with Q at the ray's origin counts: the ray does not return to the side
 * from which it comes, and Q rises over P. A ray that grazes Q does not return. */
bool pen_contact_counts(const struct pen_contact *c, struct pen_vec3 d);

/* Whether Q is a layer with P at the origin: the two coincide, and Q covers P there. */
bool pen_contact_is_layer(const struct pen_contact *c);

/* The t at which the ray meets layer Q; 0 if it does not. Layers lie in document order; the first
 * is nearest to the side from which the path came. So a ray that returns to that side meets the
 * earlier layers, the nearest first. Any other ray meets the later layers. */
double pen_contact_layer_t(const struct pen_contact *c, struct pen_vec3 d);

/* The t of an intersection of Q at the ray's origin; 0 if it does not count. */
double pen_contact_t(const struct pen_contact *c, struct pen_vec3 d);

#endif
