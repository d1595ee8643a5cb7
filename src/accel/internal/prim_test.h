/* SPDX-License-Identifier: MIT */
/* One query in progress, and the tests of single primitives: common to all compiled variants.
 *
 * An instruction set's header (see isa_base.h) defines how boxes and items are tested:
 *
 *   struct box_ray { ...; float tmin; double scale; };
 *   static inline void box_ray_make(struct box_ray *, const struct pen_ray *, double tmin,
 *                                   double grow);
 *   static inline unsigned enter_node(const struct pen_node *, const struct box_ray *, float limit,
 *                                     float near[PEN_WIDE]);
 *   static inline unsigned enter_pair(const struct pen_pair *, const struct box_ray *, float limit,
 *                                     float near[2]);
 *   static inline bool test_item(struct trace *, uint32_t item, bool any);
 *
 * Every variant offers the same intersections: those of pen_prim_intersect.
 *
 * A struct box_ray is a ray in binary32 for tests of boxes. It is scaled by a power of two such
 * that the largest component of d is in [1, 2): a box's t is the ray's t times `scale`. Three rules
 * ensure that a box test never misses a box in error:
 *  1. The near plane of an axis is compared with an origin that is rounded towards that plane, the
 *     far plane with one rounded away from it. So rounding moves t of the near plane down and t of
 *     the far plane up.
 *  2. Reciprocals are off by 2^-22 in the same directions. That is more than the three roundings of
 *     a slab test.
 *  3. Boxes grow by `grow`, so that the ray also enters the box of a primitive that its origin only
 *     touches. */
#ifndef PEN_ACCEL_INTERNAL_PRIM_TEST_H
#define PEN_ACCEL_INTERNAL_PRIM_TEST_H

#include "accel/internal/rounding.h"
#include "accel/internal/structure.h"

struct box_ray; /* defined by the instruction set */

struct mesh_query; /* mesh_query.h */

/* One query in progress. */
struct trace {
    const struct pen_accel *accel;
    const struct pen_ray *ray;
    const struct pen_origin_surface *origin;
    bool from_surface;   /* the ray starts on a primitive */
    bool reaches_origin; /* from_surface, and the box of the current leaf contains the origin */
    double slack;        /* the distance by which a primitive that touches the origin may miss it */
    double grow;         /* the reach of the self-intersection rule */
    double near_sq;      /* squared t at distance grow */
    const struct box_ray *box;  /* the ray for boxes; NULL before it is made */
    struct mesh_query *meshes;  /* in trees with blocks of meshes */
    struct pen_hit after, best; /* nearest: the intersection is sought between these */
    struct pen_shadow *shadow;
    double light_bound; /* shadow: the distance by which the light may miss a surface that contains
                           it */
    struct pen_vec3 light; /* shadow to a point: the end of the ray */
};

/* The unit normal of a plane, triangle or polygon; NULL for other kinds and for a cut polygon.
 * `room` as in pen_prim_self. */
static inline const struct pen_vec3 *flat_normal(const struct pen_prims *prims,
                                                 struct pen_prim_ref ref, struct pen_triangle *room)
{
    switch (pen_block_of(ref.kind)) {
    case PEN_BLOCK_PLANES:
        return &prims->plane[ref.index].n;
    case PEN_BLOCK_TRIANGLES:
        return &pen_prim_triangle(prims, ref.index, room)->facet.n;
    case PEN_BLOCK_POLYGONS:
        return prims->polygon[ref.index].piece ? NULL : &prims->polygon[ref.index].facet.n;
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_SPHERES:
    case PEN_BLOCK_CYLINDERS:
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return NULL;
}

/* An upper bound of pen_prim_scale of a flat primitive. */
static inline double flat_scale(const struct trace *trace, struct pen_prim_ref ref,
                                struct pen_vec3 p)
{
    if (ref.kind != PEN_PRIM_PLANE)
        return trace->accel->scale;
    return pen_norm1(pen_sub(p, trace->accel->prims->plane[ref.index].q));
}

/* Whether pen_prim_ends_ray may be true: a cheaper test, which nearly always shows that the light
 * is not on the surface. */
static inline bool may_end_ray(const struct trace *trace, struct pen_hit h)
{
    struct pen_triangle room;
    const struct pen_prims *prims = trace->accel->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, h.prim);
    const struct pen_vec3 *n = flat_normal(prims, ref, &room);
    if (n)
        return fabs((trace->shadow->tmax - h.t) * pen_dot(trace->ray->d, *n)) <=
               trace->light_bound + 8 * PEN_U * flat_scale(trace, ref, trace->light);
    if (ref.kind == PEN_PRIM_SPHERE)
        return pen_sphere_touches(&prims->sphere[ref.index], trace->light, trace->light_bound);
    return ref.kind != PEN_PRIM_CYLINDER ||
           pen_cylinder_touches(&prims->cylinder[ref.index], trace->light, trace->light_bound) &
               1u << h.part;
}

/* Inserts an intersection with a primitive that transmits light, in order. */
static inline void keep_intersection(struct pen_shadow *query, struct pen_hit h)
{
    if (query->count == PEN_SHADOW_MAX) {
        query->overflow = true;
        return;
    }
    int at = query->count++;
    for (; at > 0 && pen_hit_before(h, query->hit[at - 1]); at--)
        query->hit[at] = query->hit[at - 1];
    query->hit[at] = h;
}

/* Records an intersection; returns true if it ends the query. */
static inline bool offer(struct trace *trace, uint32_t prim, double t, uint8_t part, bool any)
{
    struct pen_hit h = {t, prim, part};
    if (!any) {
        if (pen_hit_before(trace->after, h) && pen_hit_before(h, trace->best))
            trace->best = h;
        return false;
    }
    struct pen_shadow *query = trace->shadow;
    if (!(t > 0 && t < query->tmax))
        return false;
    if (query->to_point && may_end_ray(trace, h) &&
        pen_prim_ends_ray(trace->accel->prims, h, trace->ray, query->tmax, trace->light_bound))
        return false;
    if (pen_see_through(trace->accel->prims, query->see_through, prim)) {
        keep_intersection(query, h);
        return false;
    }
    query->last_occluder = prim;
    return true;
}

/* Tests any primitive by the reference: for kinds without a test here, and for primitives that the
 * ray's origin is on or touches. */
static __attribute__((noinline)) bool test_reference(struct trace *trace, uint32_t prim, bool any)
{
    struct pen_intersections c;
    pen_prim_intersect(trace->accel->prims, prim, trace->ray, trace->origin, &c);
    for (int i = 0; i < c.count; i++) {
        if (offer(trace, prim, c.t[i], c.part[i], any))
            return true;
    }
    return false;
}

static inline bool offer_pair(struct trace *trace, uint32_t prim, const double t[2], bool any)
{
    return offer(trace, prim, t[0], PEN_PART_SIDE, any) ||
           offer(trace, prim, t[1], PEN_PART_SIDE, any);
}

static inline bool test_sphere(struct trace *trace, uint32_t prim, const struct pen_sphere *s,
                               bool any)
{
    double t[2];
    if (prim == trace->origin->prim)
        return !pen_sphere_outward(s, trace->ray) && test_reference(trace, prim, any);
    if (trace->from_surface && pen_sphere_touches(s, trace->ray->o, trace->origin->bound))
        return test_reference(trace, prim, any);
    return pen_sphere_roots(s, trace->ray, t) && offer_pair(trace, prim, t, any);
}

static inline bool test_infinite_cylinder(struct trace *trace, uint32_t prim,
                                          const struct pen_infinite_cylinder *infinite_cylinder,
                                          bool any)
{
    double t[2];
    bool parallel;
    if (prim == trace->origin->prim)
        return test_reference(trace, prim, any);
    if (!pen_cylinder_side_roots(&infinite_cylinder->round, trace->ray, t, &parallel))
        return false;
    if (trace->from_surface &&
        pen_cylinder_side_touches(&infinite_cylinder->round, trace->ray->o,
                                  trace->origin->bound +
                                      pen_infinite_cylinder_rounding(infinite_cylinder)))
        return test_reference(trace, prim, any);
    return offer_pair(trace, prim, t, any);
}

static inline bool near_origin(const struct trace *trace, double t0, double t1)
{
    return t0 * t0 <= trace->near_sq || t1 * t1 <= trace->near_sq;
}

/* Whether the ray may pass the rim of a cylinder so near its origin that the self-intersection rule
 * decides. `in` is its interval inside; NULL if there is none. Then only an open cylinder may be
 * met. */
static inline bool may_pass_rim(const struct trace *trace, const struct pen_cylinder *c,
                                const struct pen_interval *in)
{
    double t[2];
    bool parallel;
    if (in)
        return near_origin(trace, in->lo, in->hi);
    return !c->caps && trace->reaches_origin &&
           pen_cylinder_side_roots(&c->round, trace->ray, t, &parallel) &&
           near_origin(trace, t[0], t[1]);
}

static inline bool test_cylinder(struct trace *trace, uint32_t prim, const struct pen_cylinder *c,
                                 bool any)
{
    struct pen_interval in;
    if (prim == trace->origin->prim)
        return !(trace->origin->part == PEN_PART_SIDE &&
                 pen_cylinder_side_outward(&c->round, trace->ray)) &&
               test_reference(trace, prim, any);
    if (trace->from_surface && pen_cylinder_touches(c, trace->ray->o, trace->origin->bound))
        return test_reference(trace, prim, any);
    bool met = pen_cylinder_interval(c, trace->ray, &in);
    if (trace->from_surface && may_pass_rim(trace, c, met ? &in : NULL))
        return test_reference(trace, prim, any);
    if (!met)
        return false;
    return ((c->caps || in.lo_part == PEN_PART_SIDE) &&
            offer(trace, prim, in.lo, in.lo_part, any)) ||
           ((c->caps || in.hi_part == PEN_PART_SIDE) && offer(trace, prim, in.hi, in.hi_part, any));
}

/* Whether the ray's origin may be on a plane. For a ray along the plane, t times d.n cannot decide
 * this. */
static inline bool starts_on_plane(const struct trace *trace, struct pen_prim_ref ref)
{
    if (ref.kind != PEN_PRIM_PLANE)
        return false;
    const struct pen_plane *plane = &trace->accel->prims->plane[ref.index];
    const struct pen_vec3 f = pen_sub(trace->ray->o, plane->q);
    return fabs(pen_dot(plane->n, f)) <= 2 * trace->origin->bound + 16 * PEN_U * pen_norm1(f);
}

/* Offers the intersection of the ray's line with a flat primitive at t, unless the
 * self-intersection rule decides otherwise. */
static inline bool offer_flat(struct trace *trace, uint32_t prim, double t, bool any)
{
    struct pen_triangle room;
    bool late = t > (any ? trace->shadow->tmax : trace->best.t);
    if (!trace->from_surface)
        return t > 0 && !late && offer(trace, prim, t, PEN_PART_SIDE, any);
    if (prim == trace->origin->prim)
        return false;
    const struct pen_prim_ref ref = pen_prim_ref(trace->accel->prims, prim);
    if (t * t <= trace->near_sq || starts_on_plane(trace, ref))
        return test_reference(trace, prim, any);
    if (late && !trace->reaches_origin)
        return false;
    struct pen_vec3 n = *flat_normal(trace->accel->prims, ref, &room);
    if (fabs(t * pen_dot(trace->ray->d, n)) <=
            trace->origin->bound + 8 * PEN_U * flat_scale(trace, ref, trace->ray->o) &&
        (trace->reaches_origin ||
         pen_flat_touches(n, pen_prim_scale(trace->accel->prims, prim, trace->ray->o), trace->ray,
                          t, trace->origin->bound)))
        return test_reference(trace, prim, any);
    return !late && offer(trace, prim, t, PEN_PART_SIDE, any);
}

/* Whether a facet is certainly behind the ray's origin or beyond the end of the query, and beyond
 * the reach of the self-intersection rule. t is an estimate. */
static inline bool is_useless(const struct trace *trace, double t, bool any)
{
    double end = any ? trace->shadow->tmax : trace->best.t;
    return (t < 0 || t > 1.0000001 * end) &&
           (!trace->from_surface || t * t > 1.0000001 * trace->near_sq);
}

/* Whether the ray's origin is certainly not on a facet that its line meets at t, an estimate. */
static inline bool starts_off(const struct trace *trace, double t, double dn)
{
    return fabs(t * dn) > 2 * trace->origin->bound + 16 * PEN_U * trace->accel->scale;
}

/* offer_flat, if the ray's origin may be in the facet's plane. For a grazing ray, t cannot decide
 * this. |g| is below 2. */
static __attribute__((noinline)) bool offer_near_plane(struct trace *trace, uint32_t prim,
                                                       const struct pen_facet *facet, double t,
                                                       bool any)
{
    if (fabs(pen_facet_above(facet, trace->ray->o)) <=
        2 * trace->origin->bound + 16 * PEN_U * trace->accel->scale)
        return prim != trace->origin->prim && test_reference(trace, prim, any);
    return offer_flat(trace, prim, t, any);
}

/* Whether a facet whose inside the ray's line passes certainly blocks a shadow ray that starts off
 * it. It does if it is opaque and is met clearly between the ray's ends, where neither the
 * self-intersection rule nor the light can change the answer. So most occluders need no exact t. */
static inline bool surely_blocks(const struct trace *trace, uint32_t prim, double t, double dn)
{
    const struct pen_shadow *query = trace->shadow;
    if (pen_see_through(trace->accel->prims, query->see_through, prim) ||
        prim == trace->origin->prim)
        return false;
    double rounding = 16 * PEN_U * trace->accel->scale + 0x1p-28 * fabs(t * dn);
    return t > 0 && t * t > 1.0000001 * trace->near_sq && 1.0000001 * t < query->tmax &&
           fabs((query->tmax - t) * dn) > 2 * trace->light_bound + rounding;
}

/* Offers the intersection with a triangle or polygon whose inside the ray's line passes. Most of
 * those behind the origin are dropped at once, but not if the origin may be on them. A ray that
 * nearly lies in a plane meets it far from its start, and rounding of the origin decides whether
 * before or behind. */
static inline bool offer_outline(struct trace *trace, uint32_t prim, const struct pen_facet *facet,
                                 const struct pen_vec3 *v, uint32_t count, bool any)
{
    double rough = pen_facet_root_roughly(facet, trace->ray), dn = pen_dot(trace->ray->d, facet->n);
    bool off = starts_off(trace, rough, dn);
    if ((off || !trace->reaches_origin) && is_useless(trace, rough, any))
        return false;
    if (any && off && surely_blocks(trace, prim, rough, dn)) {
        trace->shadow->last_occluder = prim;
        return true;
    }
    double t = pen_outline_root(facet, v, count, trace->ray);
    if (!off && trace->from_surface && t > 0)
        return offer_near_plane(trace, prim, facet, t, any);
    if (t < 0 && (!trace->from_surface || (t * t > trace->near_sq && !trace->reaches_origin)))
        return false;
    return offer_flat(trace, prim, t, any);
}

static inline bool test_triangle(struct trace *trace, uint32_t prim, const struct pen_triangle *tri,
                                 bool any)
{
    return pen_triangle_entered(tri, trace->ray) &&
           offer_outline(trace, prim, &tri->facet, tri->v, 3, any);
}

static inline bool test_polygon(struct trace *trace, uint32_t prim, const struct pen_polygon *p,
                                bool any)
{
    if (p->piece)
        return test_reference(trace, prim, any);
    return pen_polygon_entered(p, trace->ray) &&
           offer_outline(trace, prim, &p->facet, p->v, p->count, any);
}

/* Tests a triangle. One of a mesh is made only if the line enters its outline. */
static inline bool test_any_triangle(struct trace *trace, uint32_t prim, uint32_t index, bool any)
{
    const struct pen_prims *prims = trace->accel->prims;
    const struct pen_mesh *mesh = pen_prim_mesh(prims, prim);
    struct pen_triangle room;
    if (mesh) {
        pen_mesh_outline(mesh, prim - mesh->first, &room);
        if (!pen_triangle_entered(&room, trace->ray))
            return false;
    }
    return test_triangle(trace, prim, pen_prim_triangle(prims, index, &room), any);
}

/* Tests one primitive of any kind, by the functions of its header or by the reference. */
static inline bool test_prim(struct trace *trace, uint32_t prim, bool any)
{
    const struct pen_prims *prims = trace->accel->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    double t;
    switch (pen_block_of(ref.kind)) {
    case PEN_BLOCK_SPHERES:
        return test_sphere(trace, prim, &prims->sphere[ref.index], any);
    case PEN_BLOCK_INFINITE_CYLINDERS:
        return test_infinite_cylinder(trace, prim, &prims->infinite_cylinder[ref.index], any);
    case PEN_BLOCK_CYLINDERS:
        return test_cylinder(trace, prim, &prims->cylinder[ref.index], any);
    case PEN_BLOCK_PLANES:
        return pen_plane_root(&prims->plane[ref.index], trace->ray, &t) &&
               offer_flat(trace, prim, t, any);
    case PEN_BLOCK_TRIANGLES:
        return test_any_triangle(trace, prim, ref.index, any);
    case PEN_BLOCK_POLYGONS:
        return test_polygon(trace, prim, &prims->polygon[ref.index], any);
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return test_reference(trace, prim, any);
}

/* The primitives of a block, in order; NULL if the item is not a block. */
static inline const uint32_t *block_prims(const struct pen_accel *accel, uint32_t item)
{
    uint32_t index = PEN_ITEM_INDEX(item);
    switch (PEN_ITEM_KIND(item)) {
    case PEN_BLOCK_TRIANGLES:
        return accel->triangles[index].prim;
    case PEN_BLOCK_POLYGONS:
        return accel->polygons[index].prim;
    case PEN_BLOCK_SPHERES:
        return accel->spheres[index].prim;
    case PEN_BLOCK_CYLINDERS:
        return accel->cylinders[index].prim;
    case PEN_BLOCK_PLANES:
        return accel->planes[index].prim;
    case PEN_BLOCK_INFINITE_CYLINDERS:
        return accel->infinite_cylinders[index].prim;
    case PEN_BLOCK_GENERIC:
        return accel->generic[index].prim;
    case PEN_BLOCK_MESH:
        return accel->mesh_blocks[index].prim;
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return NULL;
}

/* The items of a leaf, from the number in its child. Those of a leaf without items are made in
 * `room`.
 */
static inline const uint32_t *leaf_items(const struct pen_accel *accel, uint32_t leaf,
                                         uint32_t room[PEN_LEAF_BLOCKS_MAX])
{
    if (!(leaf & PEN_LEAF_BLOCKS))
        return &accel->items[leaf];
    const uint32_t first = (leaf & ~PEN_LEAF_BLOCKS) / PEN_LEAF_BLOCKS_MAX;
    const uint32_t others = leaf % PEN_LEAF_BLOCKS_MAX;
    for (uint32_t i = 0; i <= others; i++)
        room[i] = PEN_ITEM(PEN_BLOCK_MESH, first + i);
    room[others] |= PEN_ITEM_LAST;
    return room;
}

/* Tests one primitive of a leaf. A flat primitive with the ray's origin on its border may count as
 * hit although the ray's line misses its inside. So near the origin the reference decides. */
static inline bool test_one(struct trace *trace, uint32_t prim, bool any)
{
    uint32_t kind = pen_prim_kind(trace->accel->prims, prim);
    if (trace->reaches_origin && (kind == PEN_PRIM_TRIANGLE || kind == PEN_PRIM_POLYGON))
        return prim != trace->origin->prim && test_reference(trace, prim, any);
    return test_prim(trace, prim, any);
}

/* Tests the primitives of an item one by one. */
static inline bool test_each(struct trace *trace, uint32_t item, bool any)
{
    if (PEN_ITEM_KIND(item) == PEN_BLOCK_SINGLE)
        return test_one(trace, PEN_ITEM_INDEX(item), any);
    bool generic = PEN_ITEM_KIND(item) == PEN_BLOCK_GENERIC;
    const uint32_t *prim = block_prims(trace->accel, item);
    for (int lane = 0; prim && lane < PEN_LANES && prim[lane] != PEN_NO_PRIM; lane++) {
        if (generic ? test_reference(trace, prim[lane], any) : test_one(trace, prim[lane], any))
            return true;
    }
    return false;
}

/* The power of two by which a ray's d is scaled for boxes. */
static inline double box_scale(const struct pen_ray *ray)
{
    double largest = pen_component(ray->d, ray->kz);
    uint64_t bits;
    memcpy(&bits, &largest, sizeof bits);
    bits &= 0x7ff0000000000000u;
    memcpy(&largest, &bits, sizeof bits);
    return largest;
}

#endif
