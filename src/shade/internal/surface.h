/* SPDX-License-Identifier: MIT */
/* The point that a ray hit, with what shading needs to know of it. */
#ifndef PEN_SHADE_INTERNAL_SURFACE_H
#define PEN_SHADE_INTERNAL_SURFACE_H

#include "shade/internal/scratch.h"

#define ALWAYS_INLINE inline __attribute__((always_inline))

struct surface {
    struct pen_hit hit;
    const struct pen_material *material;
    struct pen_vec3 p;   /* on the surface */
    struct pen_vec3 n;   /* unit, turned towards the viewer */
    struct pen_vec3 v;   /* unit, from the viewer to p */
    double nv;           /* n.v <= 0 */
    double unsure;       /* on which side the viewer is, rounding decides where -n.v is no more;
                            INFINITY: it decides also on which side of other surfaces p is */
    double grazing_sine; /* q grazes where |n.q| <= grazing_sine |q|: see horizon.h */
    struct pen_origin_surface origin; /* for rays that start at p on the viewer's side; its bound is
                               how far p may be off by rounding */
};

/* The sine below which directions graze: on a round surface, moving p by its bound turns the normal
 * by `turn`. At an apex, and on what is smaller than rounding, that is 1 or more, and there is no
 * tangent plane; but seen from outside, all of a round primitive lies below the plane across the
 * normal, as on a flat surface. Seen from inside, every direction grazes. */
static ALWAYS_INLINE double surface_grazing_sine(double turn, bool outside)
{
    if (turn <= PEN_HORIZON_SINE || (outside && !(turn < 1)))
        return PEN_HORIZON_SINE;
    return turn < 1 ? turn : INFINITY;
}

/* The sine -n.v up to which rounding decides on which side of a round surface the viewer is, since
 * the normal is known to `turn`, and a mirrored ray is off by twice that. At an apex that is a wide
 * angle; but a viewer who seems to be outside and looks steeply at it is outside. */
static ALWAYS_INLINE double surface_unsure(double turn, bool outside)
{
    return outside && !(4 * turn < 0x1p-6) ? 0x1p-6 : 4 * turn;
}

/* Whether a ray that starts on a surface meets another one where it starts, or within 16 bounds of
 * there: at a seam or in a corner. The point is then on the border of both within rounding, and on
 * which side of others around the corner, it does not tell. Layers are told by the document. */
static ALWAYS_INLINE bool surface_hardly_left(const struct pen_ray *ray, double t, double bound)
{
    return t * t <= 0x1p8 * (bound * bound) * ray->inv_dd &&
           (t > PEN_LAST_LAYER_T || t <= PEN_FIRST_T);
}

/* Fills in *s. A returned struct would be copied. */
static ALWAYS_INLINE void surface_at(struct surface *s, const struct pen_scene *scene,
                                     const struct pen_ray *ray,
                                     const struct pen_origin_surface *left, struct pen_hit hit)
{
    s->hit = hit;
    s->material = &scene->materials[scene->prim_material[hit.prim]];
    s->p = pen_prim_point(&scene->prims, hit, ray);
    s->n = pen_prim_normal(&scene->prims, hit, s->p);
    s->v = pen_normalize(ray->d);
    s->nv = pen_dot(s->n, s->v);
    if (fabs(s->nv) < PEN_POINT_STEEP && pen_prim_flat(scene->prims.ref[hit.prim].kind))
        s->p = pen_prim_point_in_outline(&scene->prims, hit, ray->o, s->p, s->nv);
    s->origin = pen_origin_at(&scene->prims, ray, left, hit, s->p);
    bool outside = !(s->nv > 0);
    if (left->prim != PEN_NO_PRIM && fabs(s->nv) <= PEN_HORIZON_SINE)
        outside = pen_prim_viewer_side(&scene->prims, hit, s->p, s->v, &s->origin) >= 0;
    if (!outside) {
        s->n = pen_neg(s->n);
        s->nv = -s->nv;
    }
    if (s->nv > 0)
        s->nv = 0; /* by rounding, the ray leaves the surface that it has met */
    double turn = s->origin.bound * pen_prim_curvature(&scene->prims, hit, s->p);
    s->grazing_sine = surface_grazing_sine(turn, outside);
    s->unsure = surface_unsure(turn, outside);
    if (left->prim != PEN_NO_PRIM && surface_hardly_left(ray, hit.t, s->origin.bound))
        s->unsure = INFINITY;
}

/* Whether rounding decides on which side of the surface the viewer is, or of one beside it. */
static ALWAYS_INLINE bool surface_viewer_grazes(const struct surface *s)
{
    return s->unsure > 0 && !(-s->nv > s->unsure);
}

/* Whether lights contribute: a viewer in the tangent plane is on neither side of it. */
static ALWAYS_INLINE bool surface_lit(const struct surface *s)
{
    return s->nv < 0 && !surface_viewer_grazes(s);
}

/* The origin surface of a ray that starts at p, on the viewer's side or `through` the surface. */
static ALWAYS_INLINE struct pen_origin_surface surface_origin(const struct surface *s, bool through)
{
    struct pen_origin_surface origin = s->origin;
    origin.through = through;
    return origin;
}

/* Whether the point, the normal and the direction are finite. The bound is computed from the point,
 * so it is not finite where the point is not. */
static ALWAYS_INLINE bool surface_finite(const struct surface *s)
{
    return fabs(s->nv - s->origin.bound) < INFINITY;
}

/* The value of a sample that cannot be computed. The film cannot hold it, so it is left out and
 * counted. */
static ALWAYS_INLINE struct pen_vec3 no_sample(void)
{
    return pen_vec3(INFINITY, INFINITY, INFINITY);
}

static ALWAYS_INLINE bool is_black(struct pen_vec3 c)
{
    return pen_norm1(c) <= 0; /* one comparison; false for NaN */
}

#endif
