/* SPDX-License-Identifier: MIT */
/* Tests of triangles and polygons against the rays of a group: whether a ray's line passes inside
 * the outline, and where it meets the facet.
 *
 * The winding of geom/triangle.h decides inside or outside, but most rays pass the outline at a
 * distance and need less. Let C be a point near the rays, r a ray's origin relative to C, and S =
 * (sx, sy, 1) its direction as in the shear. For an edge from C + A to C + A + U,
 *
 *   E = S.(A x U) + U.(r x S)
 *
 * is the product pen_edge of its ends in ray space. A x U is the same for all rays. r x S vanishes
 * for rays that begin or end in C. The test computes E for each edge:
 *
 *   - If E > margin for all edges, or E < -margin for all, the ray passes inside: the angles at
 *     which it sees the edges all have one sign, so their sum is not 0.
 *   - If E > margin for one edge and E < -margin for another, and the outline is convex, the ray
 *     passes outside: one of the two edges separates the ray from the outline.
 *   - Otherwise the winding decides, as in the scalar test.
 *
 * Edges without length have E = 0 and are left out. The margin is a distance times the largest
 * component of U, written |U| below. X is the largest size of a coordinate (group_extent) and u =
 * 2^-53. The distance is the sum of
 *
 *   1. the rounding of E: A and r are below 2 X and off by u 2 X, U by u |U|. So A x U is off by
 *      16 u X |U| in each component, which are below 4 X |U|, and r x S, below 4 X, by 16 u X. With
 *      the sums, E is off by less than 220 u X |U|. Rays whose r x S is replaced by 0 add 3 times
 *      its largest component |U|, and 48 u X |U| for the error of that component.
 *   2. the rounding of the scalar test: it computes corners in ray space to 10 u X, and from these
 *      the winding is exact. So it moves corners by at most d = 14 u X, which changes the winding
 *      only if the ray passes within d of the outline. The ray passes an edge's line at |E| over
 * the edge's length in ray space, which is at most 2^1.5 |U|: more than d if |E| > 40 u X |U|.
 *   3. the distance of a corner from the left of an edge or from its plane, 2^-36 of the extent
 *      (pack_boxes.c).
 *   4. for rays that may start on the primitive, the reach of the self-intersection rule (slack):
 *      at
 *      most doubled by the shear, 2^1.5 of it for the edge's length.
 *
 * 1 and 2 are below 2^-44 X. The margin contains twice 3, and 32 slack. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_OUTLINE_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_OUTLINE_H

#include "accel/internal/ray_group.h"

struct group_outline {
    const struct pen_vec3 *v;
    uint32_t count;
    const struct pen_facet *facet;
    bool convex;
    double extent;
};

/* An edge: A x U, U and the margin. */
struct group_edge {
    double w[3], u[3], margin;
};

/* The edges that some rays may pass on either side. `positive`: all rays have E > margin at some
 * other edge; `negative`: all have E < -margin at one. */
struct group_edges {
    int count;
    bool known; /* the outline has few corners, and numbers do not underflow */
    bool convex, positive, negative;
    struct group_edge edge[PEN_CONVEX_CORNERS];
};

static inline struct group_edge group_edge_of(const struct ray_group *g,
                                              const struct pen_vec3 *from,
                                              const struct pen_vec3 *to, double distance)
{
    const struct pen_vec3 p = group_permuted(g, from), q = group_permuted(g, to);
    const struct pen_vec3 a = pen_sub(p, g->middle), u = pen_sub(q, p);
    return (struct group_edge){
        .w = {a.y * u.z - a.z * u.y, a.z * u.x - a.x * u.z, a.x * u.y - a.y * u.x},
        .u = {u.x, u.y, u.z},
        .margin = distance * pen_larger(pen_larger(fabs(u.x), fabs(u.y)), fabs(u.z))};
}

/* S.(A x U) */
static inline lanes edge_seen(const struct group_edge *e, lanes sx, lanes sy)
{
    return lanes_fma(lanes_splat(e->w[0]), sx,
                     lanes_fma(lanes_splat(e->w[1]), sy, lanes_splat(e->w[2])));
}

/* Adds U.(r x S) to that. */
static inline lanes edge_moved(const struct ray_group *g, int i, const struct group_edge *e,
                               lanes x)
{
    x = lanes_fma(lanes_splat(e->u[0]), lanes_load(g->moment[0] + i), x);
    x = lanes_fma(lanes_splat(e->u[1]), lanes_load(g->moment[1] + i), x);
    return lanes_fma(lanes_splat(e->u[2]), lanes_load(g->moment[2] + i), x);
}

/* The side on which all rays certainly pass the edge: 1 or -1; 0 if it is not certain. E has its
 * least and its largest value at corners of the range of slopes. */
static inline int group_side_of(const struct ray_group *g, const struct group_edge *e)
{
    const lanes margin = lanes_splat(e->margin);
    unsigned positive = LANES_ALL, negative = LANES_ALL;
    if (!g->concurrent)
        return 0;
    for (int i = 0; i < GROUP_CORNERS; i += LANES) {
        const lanes x = edge_seen(e, lanes_load(g->corner[0] + i), lanes_load(g->corner[1] + i));
        positive &= lane_mask_bits(lanes_less(margin, x));
        negative &= lane_mask_bits(lanes_less(x, -margin));
    }
    return (positive == LANES_ALL) - (negative == LANES_ALL);
}

/* Prepares the edges. Returns false if all rays certainly pass outside. */
static inline bool group_edges_of(const struct ray_group *g, const struct group_outline *outline,
                                  bool near, struct group_edges *out)
{
    const double distance =
        g->edge_distance + 0x1p-35 * outline->extent + (near ? 32 * g->most_slack : 0);
    const struct pen_vec3 *from = &outline->v[outline->count - 1];
    out->count = 0;
    out->known = g->edge_distance > 0 && outline->count <= PEN_CONVEX_CORNERS;
    out->convex = outline->convex;
    out->positive = out->negative = false;
    if (!out->known)
        return true;
    for (uint32_t k = 0; k < outline->count; from = &outline->v[k++]) {
        struct group_edge *e = &out->edge[out->count];
        *e = group_edge_of(g, from, &outline->v[k], distance);
        if (!(e->margin > 0))
            continue;
        const int side = group_side_of(g, e);
        out->positive |= side > 0;
        out->negative |= side < 0;
        out->count += side == 0;
        if (out->positive && out->negative && out->convex)
            return false;
    }
    return true;
}

/* Finds the lanes that certainly pass inside and those that certainly pass outside. */
static inline void group_sides(const struct ray_group *g, int i, const struct group_edges *edges,
                               unsigned *inside, unsigned *outside)
{
    const lanes sx = lanes_load(g->rays->sx + i), sy = lanes_load(g->rays->sy + i);
    unsigned all_positive = edges->negative ? 0 : LANES_ALL,
             some_negative = LANES_ALL & ~all_positive;
    unsigned all_negative = edges->positive ? 0 : LANES_ALL,
             some_positive = LANES_ALL & ~all_negative;
    for (int k = 0; k < edges->count; k++) {
        const struct group_edge *e = &edges->edge[k];
        const lanes margin = lanes_splat(e->margin);
        lanes x = edge_seen(e, sx, sy);
        if (!g->concurrent)
            x = edge_moved(g, i, e, x);
        const unsigned positive = lane_mask_bits(lanes_less(margin, x));
        const unsigned negative = lane_mask_bits(lanes_less(x, -margin));
        all_positive &= positive;
        some_positive |= positive;
        all_negative &= negative;
        some_negative |= negative;
    }
    *inside = all_positive | all_negative;
    *outside = edges->convex ? some_positive & some_negative : 0;
}

/* pen_shear: x if k = 0, y if k = 1. */
static inline lanes group_shear(const struct ray_group *g, int i, const struct pen_vec3 *v, int k)
{
    const struct pen_ray_array *r = g->rays;
    const double *at = (const double *)v;
    const lanes z = lanes_splat(at[g->axis[2]]) - lanes_load(r->o[2] + i);
    return (lanes_splat(at[g->axis[k]]) - lanes_load(r->o[k] + i)) -
           lanes_load((k ? r->sy : r->sx) + i) * z;
}

/* The lines of lanes and an outline. */
struct lanes_winding {
    unsigned inside; /* right except in `ties` */
    unsigned ties;   /* two products round to the same number: their order is not known */
    unsigned border; /* a superset of those whose origin is on the border */
};

/* A superset of the lanes whose edge from a to b passes within `slack` of the ray's origin. In ray
 * space the shear at most doubles distances across the ray. An edge that is a single point there
 * has a neighbour that is longer and passes as near. */
static inline unsigned edge_passes_origins(const struct ray_group *g, int i, const lanes a[2],
                                           const lanes b[2])
{
    const lanes size = lanes_abs(b[0] - a[0]) + lanes_abs(b[1] - a[1]);
    const lanes slack = lanes_splat(16) * lanes_load(g->slack + i);
    return lane_mask_bits(lanes_less(lanes_abs(a[0] * b[1] - a[1] * b[0]), slack * size));
}

/* pen_polygon_entered, pen_triangle_entered. If two products round to different numbers, these have
 * the order of the exact products. x is computed only for ends of edges that pass y = 0, which are
 * few. */
static inline struct lanes_winding
group_winding(const struct ray_group *g, int i, const struct pen_vec3 *v, uint32_t count, bool near)
{
    const lanes zero = lanes_splat(0), one = lanes_splat(1);
    struct lanes_winding w = {0, 0, 0};
    lanes winding = zero;
    const struct pen_vec3 *from = &v[count - 1];
    lanes a[2] = {zero, group_shear(g, i, from, 1)}, b[2] = {zero, zero};
    lane_mask a_low = lanes_at_most(a[1], zero);
    for (uint32_t k = 0; k < count; from = &v[k++]) {
        b[1] = group_shear(g, i, &v[k], 1);
        const lane_mask b_low = lanes_at_most(b[1], zero), passes = a_low ^ b_low;
        const unsigned any = lane_mask_bits(passes);
        if (any || near) {
            a[0] = group_shear(g, i, from, 0);
            b[0] = group_shear(g, i, &v[k], 0);
        }
        if (any) {
            const lanes x = a[0] * b[1], y = a[1] * b[0];
            /* On the right: x > y for an upward edge, x < y for a downward one. */
            const lane_mask right = passes & lane_mask_not(lanes_less(y, x) ^ a_low);
            w.ties |= lane_mask_bits(passes & lanes_equal(x, y));
            winding = winding + lanes_select(right, lanes_select(a_low, one, -one), zero);
        }
        if (near)
            w.border |= edge_passes_origins(g, i, a, b);
        a[1] = b[1];
        a_low = b_low;
    }
    w.inside = LANES_ALL & ~lane_mask_bits(lanes_equal(winding, zero));
    return w;
}

/* pen_facet_root, if it is not grazing. */
static inline lanes group_facet_root(const struct ray_group *g, int i,
                                     const struct pen_facet *facet)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i);
    const struct lanes3 n = group_splat(g, facet->g), low = group_splat(g, facet->g_low);
    const struct lanes3 minus = {-n.x, -n.y, -n.z};
    const lanes along = lanes3_dot2_plus(lanes_splat(0), n, d, lanes3_dot(low, d));
    return lanes3_dot2_plus(lanes_splat(facet->c), minus, o,
                            lanes_splat(facet->c_low) - lanes3_dot(low, o)) /
           along;
}

/* As offer_outline, for lanes that pass inside. */
static inline void group_offer_facet(struct ray_group *g, int i, unsigned inside,
                                     const struct pen_facet *facet, const struct group_prim *q)
{
    const struct lanes3 o = group_origin(g, i), d = group_direction(g, i),
                        n = group_splat(g, facet->g);
    const lanes above = lanes_splat(facet->c) - lanes3_dot(n, o), along = lanes3_dot(n, d);
    const lanes size = lanes_splat(fabs(facet->c)) + lanes3_norm1(o);
    const lanes t = above / along, tmax = lanes_load(g->tmax + i);
    const lanes bound = lanes_load(g->bound + i), near_sq = lanes_load(g->near_sq + i);
    const lanes slack = lanes_splat(2) * bound + lanes_splat(16 * PEN_U * g->accel->scale);
    const lanes more = lanes_splat(1.0000001), dn = lanes3_dot(d, group_splat(g, facet->n));
    /* pen_facet_root_roughly is certain, starts_off is true, and t is beyond the rule's reach. */
    unsigned sure = lane_mask_bits(
        lanes_at_most(lanes_splat(0x1p-16) * size, lanes_abs(above)) &
        lanes_at_most(lanes_splat(2 * facet->grazing) * lanes_abs(d.z), lanes_abs(along)));
    if (g->from_surface)
        sure &= lane_mask_bits(lanes_less(slack, lanes_abs(t * dn)) &
                               lanes_less(more * near_sq, t * t));
    const unsigned fallback = inside & ~sure;
    unsigned ahead = inside & sure &
                     lane_mask_bits(lanes_less(lanes_splat(0), t) & lanes_at_most(t, more * tmax));
    if (g->any && !q->see_through) {
        const unsigned ends = lane_mask_bits(lanes_less(more * t, tmax));
        g->blocked |= (uint64_t)(ahead & ends) << i;
        ahead &= ~ends;
    }
    if (ahead)
        group_offer(g, i, ahead, group_facet_root(g, i, facet), q);
    group_fall_back_all(g, i, fallback, q->prim, q->near);
}

/* The rays from i on that pass inside. Rays whose winding is not certain fall back to the scalar
 * test. */
static inline unsigned group_inside(struct ray_group *g, int i, const struct group_outline *outline,
                                    const struct group_edges *edges, unsigned live,
                                    const struct group_prim *q)
{
    unsigned inside = 0, outside = 0;
    if (edges->known)
        group_sides(g, i, edges, &inside, &outside);
    const unsigned unsure = live & ~(inside | outside);
    if (!unsure)
        return live & inside;
    const struct lanes_winding w = group_winding(g, i, outline->v, outline->count, q->near);
    const unsigned fallback = unsure & (w.ties | w.border);
    group_fall_back_all(g, i, fallback, q->prim, q->near);
    return live & (inside | (unsure & w.inside)) & ~fallback;
}

/* Tests a triangle or a polygon against all live rays. */
static inline void group_test_outline(struct ray_group *g, const struct group_outline *outline,
                                      const struct group_prim *q)
{
    struct group_edges edges;
    if (!group_edges_of(g, outline, q->near, &edges))
        return;
    for (int i = 0; i < g->end; i += LANES) {
        const unsigned live = group_waits(g, i, q) & ~group_starts_on(i, q);
        const unsigned inside = live ? group_inside(g, i, outline, &edges, live, q) : 0;
        if (inside)
            group_offer_facet(g, i, inside, outline->facet, q);
    }
}

#endif
