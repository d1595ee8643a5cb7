/* SPDX-License-Identifier: MIT */
/* The points that rays hit, with the data that shading needs, LANES at a time (math/lanes.h). The
 * pixel kernel is compiled only for the base instruction set, where LANES is 1. There every vector
 * is a number, and every mask a condition. */
#ifndef PEN_SHADE_INTERNAL_SURFACE_H
#define PEN_SHADE_INTERNAL_SURFACE_H

#include "geom/surface_lanes.h"
#include "math/lanes.h"
#include "shade/internal/patterns.h"
#include "shade/internal/scratch.h"

/* A kernel is a copy of these functions for its mask of effects. If PEN_SHARED_KERNELS is defined,
 * all kernels call the same copy, which tests the mask at run time. It compiles some thirty times
 * faster, for builds with sanitizers and for compiler warnings. */
#ifdef PEN_SHARED_KERNELS
#define ALWAYS_INLINE inline
#else
#define ALWAYS_INLINE inline __attribute__((always_inline))
#endif

/* Points of up to LANES paths. Arrays are by lane. Lanes beyond the last point hold arbitrary
 * numbers that are safe in computations. */
struct surface {
    struct pen_hit hit[LANES];
    uint32_t material[LANES];
    bool patterned;                 /* with patterns: some point has a pattern; then */
    struct pen_material own[LANES]; /* these are the materials at the points */
    struct lanes3 kd, ks;           /* of the materials */
    lanes shininess;
    struct lanes3 p;    /* on the surface */
    struct lanes3 n;    /* unit, turned towards the viewer */
    struct lanes3 v;    /* unit, from the viewer to p */
    lanes nv;           /* n.v <= 0 */
    lanes unsure;       /* if -n.v is at most this, rounding decides on which side the viewer is;
                           INFINITY: it also decides on which side of other surfaces p is */
    lanes grazing_sine; /* q grazes if |n.q| <= grazing_sine |q|: see horizon.h */
    lanes bound;        /* the distance by which p may be off by rounding */
    lane_mask outside;  /* with refraction: the viewer is on the side of the outward normal */
    lane_mask corner;   /* paths that have also met another surface (corners.h), or that graze */
    lane_mask finite;   /* the point exists, and it, its normal and its direction are finite */
    struct pen_origin_surface origin[LANES]; /* for rays that start at p on the viewer's side */
    bool smooth; /* with smooth normals: some point is in a mesh that has them; then, and at other
                    points n and nv: */
    struct lanes3 shading; /* the shading normal: unit, on the side of n */
    lanes shading_v;       /* shading.v, of any sign */
};

/* The sine below which directions graze. On a round surface, moving p by its bound turns the normal
 * by `turn`. At an apex, and on a surface smaller than rounding, `turn` is 1 or more, and there is
 * no tangent plane. But seen from outside, the whole round primitive is below the plane across the
 * normal, as on a flat surface. Seen from inside, every direction grazes. */
static ALWAYS_INLINE lanes surface_grazing_sine(lanes turn, lane_mask outside)
{
    const lanes least = lanes_splat(PEN_HORIZON_SINE);
    const lane_mask tangent = lanes_less(turn, lanes_splat(1));
    const lane_mask flat = lanes_at_most(turn, least) | (outside & lane_mask_not(tangent));
    return lanes_select(flat, least, lanes_select(tangent, turn, lanes_splat(INFINITY)));
}

/* The largest sine -n.v at which rounding decides on which side of a round surface the viewer is.
 * The normal is known to `turn`, and a mirrored ray is off by twice that. At an apex this is a wide
 * angle. But a viewer who seems to be outside and looks steeply at it is outside. */
static ALWAYS_INLINE lanes surface_unsure(lanes turn, lane_mask outside)
{
    const lanes wide = lanes_splat(0x1p-6), unsure = 4 * turn;
    return lanes_select(outside & lane_mask_not(lanes_less(unsure, wide)), wide, unsure);
}

/* Whether a ray that starts on a surface meets another surface within a distance of its start. For
 * layers, the document's order decides. */
static ALWAYS_INLINE lane_mask surface_met_within(const struct lanes_arrived *ray, lanes distance)
{
    return lanes_at_most(ray->t * ray->t, distance * distance * ray->inv_dd) &
           (lanes_less(lanes_splat(PEN_LAST_LAYER_T), ray->t) |
            lanes_at_most(ray->t, lanes_splat(PEN_FIRST_T)));
}

/* Whether that is within 16 bounds: at a seam or in a corner. Within rounding, the point is then on
 * the border of both surfaces. It does not show on which side of other surfaces around the corner
 * it is. */
static ALWAYS_INLINE lane_mask surface_hardly_left(const struct lanes_arrived *ray, lanes bound)
{
    return surface_met_within(ray, 0x1p4 * bound);
}

enum { MATERIAL_DOUBLES = sizeof(struct pen_material) / sizeof(double) };

/* Whether the materials are those of the points rather than of the scene. */
static ALWAYS_INLINE bool surface_is_patterned(const struct surface *s, const unsigned fx)
{
    return (fx & PEN_FX_PATTERNS) && s->patterned;
}

/* The points' colours of one sort, given as the offset of a member of struct pen_material. */
static ALWAYS_INLINE struct lanes3 surface_colours(const struct surface *s,
                                                   const struct pen_scene *scene, size_t sort,
                                                   const unsigned fx)
{
    const bool patterned = surface_is_patterned(s, fx);
    const struct pen_material *first = patterned ? s->own : scene->materials;
    uint32_t own[LANES];
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++)
        own[i] = (uint32_t)i;
    return lanes3_rows((const struct pen_vec3 *)((const char *)first + sort), MATERIAL_DOUBLES,
                       patterned ? own : s->material);
}

/* The material at one point. */
static ALWAYS_INLINE const struct pen_material *surface_material(const struct surface *s,
                                                                 const struct pen_scene *scene,
                                                                 int lane, const unsigned fx)
{
    return surface_is_patterned(s, fx) ? &s->own[lane] : &scene->materials[s->material[lane]];
}

static ALWAYS_INLINE void surface_set_colours(struct surface *s, const struct pen_scene *scene,
                                              const unsigned fx)
{
    s->kd = surface_colours(s, scene, offsetof(struct pen_material, kd), fx);
    s->ks = surface_colours(s, scene, offsetof(struct pen_material, ks), fx);
}

/* Sets the materials. Patterns are evaluated later, when the points are known. */
static ALWAYS_INLINE void surface_materials(struct surface *s, const struct pen_scene *scene,
                                            int count, const unsigned fx)
{
    const struct pen_material *first = scene->materials;
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++)
        s->material[i] = i < count ? pen_scene_material_of(scene, s->hit[i].prim) : 0;
    s->patterned = false;
    for (int i = 0; (fx & PEN_FX_PATTERNS) && i < count; i++)
        s->patterned |= first[s->material[i]].patterns != NULL;
    if (!surface_is_patterned(s, fx))
        surface_set_colours(s, scene, fx);
    s->shininess = lanes_rows(&first->shininess, MATERIAL_DOUBLES, s->material);
}

/* Evaluates the patterns at the points, which are set. */
static ALWAYS_INLINE void surface_patterns(struct surface *s, const struct pen_scene *scene,
                                           int count, const unsigned fx)
{
    for (int i = 0; i < LANES; i++)
        s->own[i] = i < count ? pen_material_at(scene, s->hit[i].prim, lanes3_at(s->p, i),
                                                lanes_at(s->bound, i))
                              : scene->materials[0];
    surface_set_colours(s, scene, fx);
}

/* Whether points have shading normals. */
static ALWAYS_INLINE bool surface_is_smooth(const struct surface *s, const unsigned fx)
{
    return (fx & PEN_FX_SMOOTH_NORMALS) && s->smooth;
}

/* Sets the shading normals of the points, which are set. */
static ALWAYS_INLINE void surface_shading_normals(struct surface *s, const struct pen_scene *scene,
                                                  int count)
{
    struct pen_vec3 n[LANES];
    unsigned smooth = 0;
    s->smooth = false;
    if (!(scene->effects & PEN_FX_SMOOTH_NORMALS))
        return;
    lanes3_store(n, s->n);
    for (int i = 0; i < count; i++)
        smooth |= (unsigned)pen_prim_shading_normal(&scene->prims, s->hit[i].prim,
                                                    lanes3_at(s->p, i), &n[i])
                  << i;
    s->smooth = smooth != 0;
    s->shading = lanes3_load(n);
    s->shading_v = lanes_select(lane_mask_of(smooth), lanes3_dot(s->shading, s->v), s->nv);
}

/* The points that are on the same part of a primitive as the first of `left`, out of `left`, a bit
 * each. */
static ALWAYS_INLINE unsigned surface_points_of_part(const struct surface *s, unsigned left)
{
    const struct pen_hit *first = &s->hit[__builtin_ctz(left)];
    unsigned same = 0;
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++)
        same |= (unsigned)(s->hit[i].prim == first->prim && s->hit[i].part == first->part) << i;
    return same & left;
}

/* Moves points to the border of their outline. A line that is seen to pass just inside an outline
 * may meet the plane outside it. */
static ALWAYS_INLINE void surface_keep_in_outlines(struct surface *s, const struct pen_prims *prims,
                                                   const struct path *const *path, int count)
{
    const lane_mask slanting = lanes_less(lanes_abs(s->nv), lanes_splat(PEN_POINT_STEEP));
    const unsigned bits = lane_mask_bits(slanting);
    if (!bits)
        return;
    struct pen_vec3 p[LANES];
    lanes3_store(p, s->p);
    for (int i = 0; i < count; i++) {
        if (bits >> i & 1 && pen_prim_flat(pen_prim_kind(prims, s->hit[i].prim)))
            p[i] = pen_prim_point_in_outline(prims, s->hit[i], path[i]->ray.o, p[i],
                                             lanes_at(s->nv, i));
    }
    s->p = lanes3_load(p);
}

/* The outward normal of a point that is seen along d. At the apex of a cone that refracts it is the
 * axis: refracted by the cone's side there, a ray might leave the cone where it enters. */
static ALWAYS_INLINE struct pen_vec3 surface_normal(const struct pen_scene *scene,
                                                    struct pen_hit hit, struct pen_vec3 p,
                                                    struct pen_vec3 d)
{
    if (pen_scene_see_through(scene, hit.prim) && pen_scene_material(scene, hit.prim)->ior != 1)
        return pen_prim_normal(&scene->prims, hit, p);
    return pen_prim_normal_seen(&scene->prims, hit, p, d);
}

/* Computes some points one by one, as lanes_prim_surface. */
static ALWAYS_INLINE void surface_points_singly(struct surface *s, const struct pen_scene *scene,
                                                const struct path *const *path, unsigned points,
                                                struct lanes_prim_point *at)
{
    const struct pen_prims *prims = &scene->prims;
    struct pen_vec3 p[LANES], n[LANES];
    double scale[LANES], curvature[LANES];
    lanes3_store(p, at->p);
    lanes3_store(n, at->n);
    lanes_store(scale, at->scale);
    lanes_store(curvature, at->curvature);
    for (; points; points &= points - 1) {
        const int i = __builtin_ctz(points);
        p[i] = pen_prim_point(prims, s->hit[i], &path[i]->ray);
        n[i] = surface_normal(scene, s->hit[i], p[i], path[i]->ray.d);
        scale[i] = pen_prim_scale(prims, s->hit[i].prim, p[i]);
        curvature[i] = pen_prim_curvature(prims, s->hit[i], p[i]);
    }
    *at = (struct lanes_prim_point){lanes3_load(p), lanes3_load(n), lanes_load(scale),
                                    lanes_load(curvature)};
}

/* Computes the points that rays have met, and the outward normals: in lanes, one part of a
 * primitive after the other. */
static ALWAYS_INLINE struct lanes_prim_point surface_points(struct surface *s,
                                                            const struct pen_scene *scene,
                                                            const struct path *const *path,
                                                            int count, struct lanes3 met)
{
    const struct pen_prims *prims = &scene->prims;
    unsigned left = LANES_ALL >> (LANES - count), singly = 0;
    const lanes zero = lanes_splat(0);
    struct lanes_prim_point all = {met, met, zero, zero};
    while (left) {
        const struct pen_hit *first = &s->hit[__builtin_ctz(left)];
        const unsigned same = surface_points_of_part(s, left);
        const lane_mask here = lane_mask_of(same);
        struct lanes_prim_point at = {.p = met};
        if (lanes_prim_surface(prims, first->prim, first->part, same, &at)) {
            all.p = lanes3_select(here, at.p, all.p);
            all.n = lanes3_select(here, at.n, all.n);
            all.scale = lanes_select(here, at.scale, all.scale);
            all.curvature = lanes_select(here, at.curvature, all.curvature);
        } else {
            singly |= same;
        }
        left &= ~same;
    }
    if (singly)
        surface_points_singly(s, scene, path, singly, &all);
    return all;
}

/* The origin surfaces of the rays of some paths. */
static ALWAYS_INLINE struct lanes_origin surface_left(const struct path *const *path, int count)
{
    struct pen_vec3 toward[LANES], before[LANES];
    double bound[LANES], toward_bound[LANES], before_bound[LANES];
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++) {
        const struct pen_origin_surface *left = &path[i < count ? i : 0]->origin;
        toward[i] = left->toward;
        before[i] = left->before;
        bound[i] = left->bound;
        toward_bound[i] = left->toward_bound;
        before_bound[i] = left->before_bound;
    }
    return (struct lanes_origin){lanes3_load(toward), lanes3_load(before), lanes_load(bound),
                                 lanes_load(toward_bound), lanes_load(before_bound)};
}

/* The rays of some paths, all or none of which are camera rays. Sets d to their directions. */
static ALWAYS_INLINE struct lanes_arrived
surface_rays(const struct surface *s, const struct path *const *path, int count, struct lanes3 *d)
{
    struct pen_vec3 origin[LANES], direction[LANES];
    double t[LANES], inv_dd[LANES];
    struct lanes_arrived ray;
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++) {
        const int from = i < count ? i : 0;
        origin[i] = path[from]->ray.o;
        direction[i] = path[from]->ray.d;
        inv_dd[i] = path[from]->ray.inv_dd;
        t[i] = s->hit[from].t;
    }
    *d = lanes3_load(direction);
    ray.o = lanes3_load(origin);
    ray.t = lanes_load(t);
    ray.inv_dd = lanes_load(inv_dd);
    if (path[0]->depth == 0) { /* pen_origin_none */
        const lanes zero = lanes_splat(0);
        const struct lanes3 none = {zero, zero, zero};
        ray.left = (struct lanes_origin){none, none, zero, zero, zero};
    } else {
        ray.left = surface_left(path, count);
    }
    return ray;
}

enum { ORIGIN_DOUBLES = sizeof(struct pen_origin_surface) / sizeof(double) };

static ALWAYS_INLINE void surface_store3(struct pen_vec3 *first, struct lanes3 v)
{
    lanes_store_strided(&first->x, ORIGIN_DOUBLES, v.x);
    lanes_store_strided(&first->y, ORIGIN_DOUBLES, v.y);
    lanes_store_strided(&first->z, ORIGIN_DOUBLES, v.z);
}

/* Sets the origin surfaces of rays from the points. */
static ALWAYS_INLINE void surface_set_origins(struct surface *s, const struct lanes_origin *origin)
{
    struct pen_origin_surface *first = s->origin;
#pragma GCC unroll 8
    for (int i = 0; i < LANES; i++) {
        first[i].prim = s->hit[i].prim;
        first[i].part = s->hit[i].part;
        first[i].through = false;
    }
    surface_store3(&first->toward, origin->toward);
    surface_store3(&first->before, origin->before);
    lanes_store_strided(&first->bound, ORIGIN_DOUBLES, origin->bound);
    lanes_store_strided(&first->toward_bound, ORIGIN_DOUBLES, origin->toward_bound);
    lanes_store_strided(&first->before_bound, ORIGIN_DOUBLES, origin->before_bound);
}

/* Whether the viewer is on the side of the outward normal. */
static ALWAYS_INLINE lane_mask surface_seen_from_outside(const struct surface *s,
                                                         const struct pen_scene *scene,
                                                         const struct path *const *path, int count)
{
    const lane_mask outside = lane_mask_not(lanes_less(lanes_splat(0), s->nv));
    const lane_mask along = lanes_at_most(lanes_abs(s->nv), lanes_splat(PEN_HORIZON_SINE));
    unsigned bits = lane_mask_bits(outside), grazing = lane_mask_bits(along);
    if (!grazing)
        return outside;
    for (int i = 0; i < count; i++) {
        if (!(grazing >> i & 1) || path[i]->origin.prim == PEN_NO_PRIM)
            continue;
        const double side = pen_prim_viewer_side(&scene->prims, s->hit[i], lanes3_at(s->p, i),
                                                 lanes3_at(s->v, i), &s->origin[i]);
        bits = (bits & ~(1u << i)) | (unsigned)(side >= 0) << i;
    }
    return lane_mask_of(bits);
}

/* Fills in *s with the points of up to LANES paths, all or none of which are camera rays. The
 * caller has set s->hit. */
static ALWAYS_INLINE void surface_at(struct surface *s, const struct pen_scene *scene,
                                     const struct path *const *path, int count, const unsigned fx)
{
    struct lanes3 d;
    surface_materials(s, scene, count, fx);
    const struct lanes_arrived ray = surface_rays(s, path, count, &d);
    const struct lanes_prim_point at =
        surface_points(s, scene, path, count, lanes3_along(ray.o, d, ray.t));
    s->p = at.p;
    s->n = at.n;
    s->v = lanes3_normalize(d);
    s->nv = lanes3_dot(s->n, s->v);
    surface_keep_in_outlines(s, &scene->prims, path, count);
    const struct lanes_origin origin = lanes_origin_at(&ray, s->p, at.scale);
    s->bound = origin.bound;
    surface_set_origins(s, &origin);
    const lane_mask outside = surface_seen_from_outside(s, scene, path, count);
    if (fx & PEN_FX_REFRACTION)
        s->outside = outside;
    s->n = lanes3_select(outside, s->n, lanes3_neg(s->n));
    s->nv = lanes_select(outside, s->nv, -s->nv);
    /* By rounding, a ray may leave the surface that it has met. */
    s->nv = lanes_select(lanes_less(lanes_splat(0), s->nv), lanes_splat(0), s->nv);
    /* The angle by which the normal turns when a point moves by its bound. */
    const lanes turn = s->bound * at.curvature;
    s->grazing_sine = surface_grazing_sine(turn, outside);
    s->unsure = surface_unsure(turn, outside);
    s->corner = lane_mask_of(0);
    if (path[0]->depth > 0) {
        s->corner = surface_met_within(&ray, CORNER_BOUNDS * s->bound) |
                    lanes_at_most(-s->nv, lanes_splat(PEN_HORIZON_SINE));
        s->unsure =
            lanes_select(surface_hardly_left(&ray, s->bound), lanes_splat(INFINITY), s->unsure);
    }
    /* The bound is computed from the point, so it is not finite if the point is not finite. */
    s->finite = lane_mask_of((1u << count) - 1) &
                lanes_less(lanes_abs(s->nv - s->bound), lanes_splat(INFINITY));
    if (surface_is_patterned(s, fx))
        surface_patterns(s, scene, count, fx);
    if (fx & PEN_FX_SMOOTH_NORMALS)
        surface_shading_normals(s, scene, count);
}

/* Whether rounding decides on which side of the surface, or of one beside it, the viewer is. */
static ALWAYS_INLINE lane_mask surface_viewer_grazes(const struct surface *s)
{
    return lanes_less(lanes_splat(0), s->unsure) & lane_mask_not(lanes_less(s->unsure, -s->nv));
}

/* Whether lights contribute. A viewer in the tangent plane is on neither side of it, so they do
 * not. */
static ALWAYS_INLINE lane_mask surface_lit(const struct surface *s)
{
    return s->finite & lanes_less(s->nv, lanes_splat(0)) & lane_mask_not(surface_viewer_grazes(s));
}

/* The origin surface of a ray that starts at a point, on the viewer's side or `through` the
 * surface. */
static ALWAYS_INLINE struct pen_origin_surface surface_origin(const struct surface *s, int lane,
                                                              bool through)
{
    struct pen_origin_surface origin = s->origin[lane];
    origin.through = through;
    return origin;
}

/* The value of a sample that cannot be computed. The film cannot hold it, so it is left out of the
 * mean and counted. */
static ALWAYS_INLINE struct pen_vec3 no_sample(void)
{
    return pen_vec3(INFINITY, INFINITY, INFINITY);
}

static ALWAYS_INLINE bool is_black(struct pen_vec3 c)
{
    return pen_norm1(c) <= 0; /* one comparison; false for NaN */
}

static ALWAYS_INLINE lane_mask lanes_black(struct lanes3 c)
{
    return lanes_at_most(lanes3_norm1(c), lanes_splat(0));
}

#endif
