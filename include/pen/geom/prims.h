/* SPDX-License-Identifier: MIT */
/* The primitives of a frozen scene: one typed array per kind, in the local frame (coordinates
 * about 1). A primitive's number is its place in the document, depth first, and decides ties.
 *
 * One header per kind holds its struct and its functions, static inline because they are the
 * hot path: pen_<kind>_cross (all crossings), _normal (unit, outward), _project (the point of the
 * surface nearest a computed hit), _bounds (finite kinds). Outward is as scene-format.md says. */
#ifndef PEN_GEOM_PRIMS_H
#define PEN_GEOM_PRIMS_H

#include <stdint.h>

#include "pen/geom/cylinder.h"
#include "pen/geom/plane.h"
#include "pen/geom/polygon.h"
#include "pen/geom/ray.h"
#include "pen/geom/sphere.h"
#include "pen/geom/triangle.h"
#include "pen/geom/tube.h"
#include "pen/math/box.h"

enum pen_prim_kind {
    PEN_PRIM_SPHERE,
    PEN_PRIM_PLANE,
    PEN_PRIM_TRIANGLE,
    PEN_PRIM_POLYGON,
    PEN_PRIM_TUBE,
    PEN_PRIM_CYLINDER,
    PEN_PRIM_KIND_COUNT
};

/* Where primitive number i lives. */
struct pen_prim_ref {
    uint32_t kind : 4; /* enum pen_prim_kind */
    uint32_t index : 28;
};

/* Owns nothing: the arrays belong to the scene's arena. */
struct pen_prims {
    uint32_t count;
    const struct pen_prim_ref *ref; /* by primitive number */
    const struct pen_sphere *sphere;
    const struct pen_plane *plane;
    const struct pen_triangle *triangle;
    const struct pen_polygon *polygon;
    const struct pen_tube *tube;
    const struct pen_cylinder *cylinder;
    uint32_t kind_count[PEN_PRIM_KIND_COUNT];
};

/* Whether the kind has no bounds. */
static inline bool pen_prim_infinite(uint32_t kind)
{
    return kind == PEN_PRIM_PLANE || kind == PEN_PRIM_TUBE;
}

/* All crossings of the ray with primitive `prim`, those that the leave rule drops left out.
 * The reference that every accelerator must agree with, bit for bit. */
void pen_prim_cross(const struct pen_prims *prims, uint32_t prim, const struct pen_ray *ray,
                    const struct pen_leave *leave, struct pen_crossings *out);

/* Outward unit normal at a point of the surface. */
struct pen_vec3 pen_prim_normal(const struct pen_prims *prims, struct pen_hit hit,
                                struct pen_vec3 p);

/* The hit point: o + t d, put back on the surface. */
struct pen_vec3 pen_prim_point(const struct pen_prims *prims, struct pen_hit hit,
                               const struct pen_ray *ray);

/* Bounds in double precision, rounded outward so that every computed hit point lies inside.
 * Only for finite kinds. */
struct pen_box pen_prim_bounds(const struct pen_prims *prims, uint32_t prim);

/* The rounding bound for rays that start at p: 16u (|p|_1 + the primitive's own scale). */
double pen_prim_rounding(const struct pen_prims *prims, uint32_t prim, struct pen_vec3 p);

#endif
