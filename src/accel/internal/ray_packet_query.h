/* SPDX-License-Identifier: MIT */
/* The queries of ray packets: divides the rays into groups, collects the primitives that a group's
 * beam enters, and tests them. */
#ifndef PEN_ACCEL_INTERNAL_RAY_PACKET_QUERY_H
#define PEN_ACCEL_INTERNAL_RAY_PACKET_QUERY_H

#include "accel/internal/ray_group_test.h"

/* Smaller groups, and groups that may meet more primitives, are traced ray by ray. */
enum { GROUP_RAYS_MIN = 4, GROUP_CANDIDATES = 192 };

/* A primitive that some ray may meet. */
struct group_candidate {
    float near; /* no ray meets it at a smaller depth: see beam.h */
    uint32_t prim;
};

static inline bool ray_is_forward(const struct pen_ray *ray)
{
    return ray->permuted_d.z > 0;
}

static inline void group_init(struct ray_group *g, const struct pen_accel *accel)
{
    g->count = g->own_count = 0;
    g->any = g->from_surface = g->to_point = false;
    g->accel = accel;
    g->light = pen_vec3(0, 0, 0);
    g->grow = 0;
}

static inline void group_add(struct ray_group *g, const struct pen_ray_packet *packet, int ray)
{
    const int i = g->count++;
    const struct pen_ray *r = packet->ray[ray];
    const struct pen_origin_surface *origin = packet->origin[ray];
    const struct trace trace = trace_begin(g->accel, r, origin);
    g->ray[i] = r;
    g->origin[i] = origin;
    g->o[0][i] = r->permuted_o.x;
    g->o[1][i] = r->permuted_o.y;
    g->o[2][i] = r->permuted_o.z;
    g->d[0][i] = r->permuted_d.x;
    g->d[1][i] = r->permuted_d.y;
    g->d[2][i] = r->permuted_d.z;
    g->sx[i] = r->sx;
    g->sy[i] = r->sy;
    g->inv_dd[i] = r->inv_dd;
    group_add_own(g, i, origin->prim);
    g->near[i] = r->near;
    g->bound[i] = trace.from_surface ? origin->bound : 0;
    g->slack[i] = trace.from_surface ? trace.slack : 0;
    g->near_sq[i] = trace.from_surface ? trace.near_sq : -1;
    g->from_surface |= trace.from_surface;
    if (trace.from_surface && trace.grow > g->grow)
        g->grow = trace.grow;
}

static inline void group_add_shadow(struct ray_group *g, const struct pen_ray_packet *packet,
                                    int ray)
{
    const int i = g->count;
    group_add(g, packet, ray);
    struct pen_shadow *query = packet->query[ray];
    query->count = 0;
    query->overflow = false;
    g->query[i] = query;
    g->tmax[i] = query->tmax;
    g->after_t[i] = 0;
}

static inline void group_add_nearest(struct ray_group *g, const struct pen_ray_packet *packet,
                                     int ray)
{
    const int i = g->count;
    group_add(g, packet, ray);
    g->after[i] = packet->after[ray];
    g->best[i] = (struct pen_hit){INFINITY, PEN_NO_PRIM, UINT8_MAX};
    g->after_t[i] = packet->after[ray].t;
    g->tmax[i] = INFINITY;
}

/* Fills the lanes beyond the last ray with copies of the first. */
static inline void group_pad(struct ray_group *g)
{
    double *const all[] = {g->o[0],    g->o[1], g->o[2],  g->d[0],   g->d[1],
                           g->d[2],    g->sx,   g->sy,    g->inv_dd, g->near,
                           g->after_t, g->tmax, g->bound, g->slack,  g->near_sq};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        for (int i = g->count; i % LANES; i++)
            all[k][i] = all[k][0];
    g->live = g->count < 64 ? (UINT64_C(1) << g->count) - 1 : UINT64_MAX;
    g->blocked = 0;
}

/* The least and the largest of x[begin] to x[end - 1]. `begin` is a multiple of LANES, and lanes
 * beyond the end repeat an earlier number. */
static inline void range_of(const double *x, int begin, int end, double *lo, double *hi)
{
    lanes least = lanes_load(x + begin), most = least;
    double l[LANES], m[LANES];
    for (int i = begin + LANES; i < end; i += LANES) {
        least = lanes_min(lanes_load(x + i), least);
        most = lanes_max(lanes_load(x + i), most);
    }
    lanes_store(l, least);
    lanes_store(m, most);
    *lo = l[0];
    *hi = m[0];
    for (int i = 1; i < LANES; i++) {
        *lo = l[i] < *lo ? l[i] : *lo;
        *hi = m[i] > *hi ? m[i] : *hi;
    }
}

/* Makes the beam of rays begin to end - 1. */
static inline void group_beam(const struct ray_group *g, int begin, int end, double margin,
                              struct beam *beam)
{
    const struct pen_ray *first = g->ray[0];
    const struct pen_vec3 light = pen_permuted(first, &g->light);
    const double *const slopes[2] = {g->sx, g->sy};
    *beam = (struct beam){.axis = {first->kx, first->ky, first->kz},
                          .forward = ray_is_forward(first) != g->to_point,
                          .margin = pen_float_up(margin),
                          .bounded = g->to_point};
    for (int k = 0; k < 2; k++) {
        double least, most;
        range_of(slopes[k], begin, end, &least, &most);
        beam->least[k] = pen_float_near(beam->forward ? least : -most);
        beam->most[k] = pen_float_near(beam->forward ? most : -least);
    }
    for (int k = 0; k < 3; k++) {
        const double at = pen_component(light, k);
        double lo, hi;
        range_of(g->o[k], begin, end, &lo, &hi);
        beam->lo[k] = pen_float_near(g->to_point ? at : lo);
        beam->hi[k] = pen_float_near(g->to_point ? at : hi);
        beam->box_lo[beam->axis[k]] = pen_float_down((lo < at ? lo : at) - margin);
        beam->box_hi[beam->axis[k]] = pen_float_up((hi > at ? hi : at) + margin);
    }
}

/* The largest size of a coordinate. */
static inline double group_extent(const struct ray_group *g)
{
    double most = g->accel->extent;
    if (g->to_point)
        most = larger(most, larger(fabs(g->light.x), larger(fabs(g->light.y), fabs(g->light.z))));
    for (int k = 0; k < 3; k++) {
        double lo, hi;
        range_of(g->o[k], 0, g->count, &lo, &hi);
        most = larger(most, larger(fabs(lo), fabs(hi)));
    }
    return most;
}

/* Prepares tests of outlines; x is the largest size of a coordinate. */
static inline void group_begin_edges(struct ray_group *g, double x)
{
    const struct pen_vec3 c = g->to_point ? pen_permuted(g->ray[0], &g->light)
                                          : pen_vec3(g->o[0][0], g->o[1][0], g->o[2][0]);
    const struct lanes3 middle = lanes3_splat(c);
    double lo, hi, most = 0;
    for (int i = 0; i < g->count; i += LANES) {
        const struct lanes3 r = lanes3_sub(group_origin(g, i), middle);
        const lanes sx = lanes_load(g->sx + i), sy = lanes_load(g->sy + i);
        lanes_store(g->moment[0] + i, r.y - r.z * sy);
        lanes_store(g->moment[1] + i, r.z * sx - r.x);
        lanes_store(g->moment[2] + i, r.x * sy - r.y * sx);
    }
    for (int k = 0; k < 3; k++) {
        range_of(g->moment[k], 0, g->count, &lo, &hi);
        most = larger(most, larger(-lo, hi));
    }
    range_of(g->slack, 0, g->count, &lo, &g->most_slack);
    g->middle = c;
    g->concurrent = most <= 0x1p-40 * x;
    g->edge_distance = x > 0x1p-200 ? 0x1p-44 * x + (g->concurrent ? 3 * most : 0) : 0;
    for (int k = 0; k < 2; k++) {
        range_of(k ? g->sy : g->sx, 0, g->count, &lo, &hi);
        for (int i = 0; i < GROUP_CORNERS; i++)
            g->corner[k][i] = i >> k & 1 ? hi : lo;
    }
}

/* Makes the beams. False if lengths are out of the range of binary32. */
static inline bool group_begin(struct ray_group *g)
{
    group_pad(g);
    const double most = group_extent(g), margin = 0x1p-18 * most + g->grow;
    if (!(most < 0x1p60 && g->grow < 0x1p60))
        return false;
    group_beam(g, 0, g->count, margin, &g->beam);
    for (int begin = 0; begin < g->count; begin += GROUP_PART) {
        const int end = begin + GROUP_PART < g->count ? begin + GROUP_PART : g->count;
        group_beam(g, begin, end, margin, &g->part[begin / GROUP_PART]);
    }
    for (int k = 0; k < 3; k++) {
        double lo, hi;
        range_of(g->o[k], 0, g->count, &lo, &hi);
        ((double *)&g->origins.lo)[g->beam.axis[k]] = lo - g->grow;
        ((double *)&g->origins.hi)[g->beam.axis[k]] = hi + g->grow;
    }
    g->extent = most;
    g->light_bound = 0x1p-30 * most;
    group_begin_edges(g, most);
    return true;
}

/* Whether the origin of some ray may be on a primitive in this box, or on its border. */
static inline bool group_starts_in(const struct ray_group *g, const struct pen_float_box *box)
{
    return g->from_surface && box->lo[0] <= g->origins.hi.x && box->hi[0] >= g->origins.lo.x &&
           box->lo[1] <= g->origins.hi.y && box->hi[1] >= g->origins.lo.y &&
           box->lo[2] <= g->origins.hi.z && box->hi[2] >= g->origins.lo.z;
}

/* Whether the light and the origins of all shadow rays are on one side of a flat primitive, by more
 * than all roundings: the beam's margin. */
static inline bool group_on_one_side(const struct ray_group *g, struct pen_vec3 n,
                                     struct pen_vec3 v)
{
    const double light = pen_dot(n, pen_sub(g->light, v)), margin = (double)g->beam.margin;
    const struct pen_vec3 lo = pen_sub(g->origins.lo, v), hi = pen_sub(g->origins.hi, v);
    const double middle = 0.5 * pen_dot(n, pen_add(lo, hi));
    const double half =
        0.5 * (fabs(n.x) * (hi.x - lo.x) + fabs(n.y) * (hi.y - lo.y) + fabs(n.z) * (hi.z - lo.z));
    return (light > margin && middle - half > margin) ||
           (light < -margin && middle + half < -margin);
}

/* Whether shadow rays to a point surely do not meet a primitive, because it is flat and they are on
 * one side of it. */
static inline bool group_misses(const struct ray_group *g, uint32_t prim)
{
    const struct pen_prims *prims = g->accel->prims;
    const struct pen_prim_ref ref = prims->ref[prim];
    if (!g->to_point)
        return false;
    if (ref.kind == PEN_PRIM_TRIANGLE)
        return group_on_one_side(g, prims->triangle[ref.index].facet.n,
                                 prims->triangle[ref.index].v[0]);
    if (ref.kind == PEN_PRIM_POLYGON)
        return prims->polygon[ref.index].flat &&
               group_on_one_side(g, prims->polygon[ref.index].facet.n,
                                 prims->polygon[ref.index].v[0]);
    return ref.kind == PEN_PRIM_PLANE &&
           group_on_one_side(g, prims->plane[ref.index].n, prims->plane[ref.index].q);
}

/* The candidates among the primitives of a list of items. False if there are too many. */
static inline bool group_collect_leaf(const struct ray_group *g, uint32_t first, bool boxes,
                                      struct group_candidate *out, int *count)
{
    for (const uint32_t *item = &g->accel->items[first];; item++) {
        const uint32_t *prim = block_prims(g->accel, *item);
        for (int lane = 0; prim && lane < PEN_LANES && prim[lane] != PEN_NO_PRIM; lane++) {
            struct group_candidate c = {0, prim[lane]};
            if (boxes && !beam_enters(&g->beam, &g->accel->prim_box[c.prim], &c.near))
                continue;
            if (group_misses(g, c.prim))
                continue;
            if (*count == GROUP_CANDIDATES)
                return false;
            out[(*count)++] = c;
        }
        if (*item & PEN_ITEM_LAST)
            return true;
    }
}

/* All candidates. False if there are too many. */
static inline bool group_collect(const struct ray_group *g, struct group_candidate *out, int *count)
{
    uint32_t stack[STACK];
    int top = 0;
    *count = 0;
    if (!group_collect_leaf(g, g->accel->infinite, false, out, count))
        return false;
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &g->accel->nodes[stack[--top]];
        for (unsigned in = beam_enter_node(&g->beam, node); in; in &= in - 1) {
            const uint32_t child = node->child[__builtin_ctz(in)];
            if (!(child & PEN_CHILD_LEAF))
                stack[top++] = child;
            else if (!group_collect_leaf(g, child & ~PEN_CHILD_LEAF, true, out, count))
                return false;
        }
    }
    return true;
}

/* The rays of those parts of the group whose beam enters a primitive's box. */
static inline uint64_t group_parts(const struct ray_group *g, uint32_t prim)
{
    uint64_t rays = 0;
    for (int begin = 0; begin < g->count; begin += GROUP_PART) {
        float near;
        if (beam_enters(&g->part[begin / GROUP_PART], &g->accel->prim_box[prim], &near))
            rays |= ((UINT64_C(1) << GROUP_PART) - 1) << begin;
    }
    return rays;
}

static inline struct group_prim group_prim_of(const struct ray_group *g, uint32_t prim,
                                              bool see_through)
{
    const bool infinite = pen_prim_infinite(g->accel->prims->ref[prim].kind);
    const bool near =
        g->from_surface && (infinite || group_starts_in(g, &g->accel->prim_box[prim]));
    return (struct group_prim){
        .prim = prim,
        .rays = infinite ? UINT64_MAX : group_parts(g, prim),
        .own = near ? group_own(g, prim) : 0,
        .near = near,
        .see_through = see_through,
    };
}

/* Nearest first, so that later ones can be left out. */
static inline void sort_candidates(struct group_candidate *c, int count)
{
    for (int i = 1; i < count; i++) {
        const struct group_candidate x = c[i];
        int at = i;
        for (; at > 0 && c[at - 1].near > x.near; at--)
            c[at] = c[at - 1];
        c[at] = x;
    }
}

/* The largest depth at which a ray may still meet something nearer than it has. */
static inline double group_depth(const struct ray_group *g)
{
    double most = 0;
    for (int i = 0; i < g->count; i++)
        most = larger(most, g->tmax[i] * fabs(g->d[2][i]));
    return most;
}

static inline bool group_nearest(struct ray_group *g)
{
    struct group_candidate c[GROUP_CANDIDATES];
    int count;
    if (!group_begin(g) || !group_collect(g, c, &count))
        return false;
    sort_candidates(c, count);
    for (int k = 0; k < count; k++) {
        if (c[k].near > 0 && (double)c[k].near > 1.0000001 * group_depth(g))
            break;
        struct group_prim q = group_prim_of(g, c[k].prim, false);
        q.depth = c[k].near;
        group_test(g, &q);
    }
    return true;
}

/* Whether a primitive may contain the light, so that rays that end there do not count it. What is
 * farther than light_bound away surely does not: pen_ray_end_bound and the roundings of t and of
 * the primitive are below 2^-40 of the coordinates. */
static inline bool group_light_on(const struct ray_group *g, uint32_t prim)
{
    const struct pen_prims *prims = g->accel->prims;
    const struct pen_prim_ref ref = prims->ref[prim];
    const double b = g->light_bound;
    switch (pen_block_of(ref.kind)) {
    case PEN_BLOCK_TRIANGLES:
        return fabs(pen_facet_above(&prims->triangle[ref.index].facet, g->light)) <= b;
    case PEN_BLOCK_POLYGONS:
        return prims->polygon[ref.index].piece ||
               fabs(pen_facet_above(&prims->polygon[ref.index].facet, g->light)) <=
                   b + 8 * PEN_U * prims->polygon[ref.index].scale;
    case PEN_BLOCK_PLANES: {
        const struct pen_plane *p = &prims->plane[ref.index];
        const struct pen_vec3 f = pen_sub(g->light, p->q);
        return fabs(pen_dot(p->n, f)) <= b + 0x1p-30 * pen_norm1(f);
    }
    case PEN_BLOCK_SPHERES:
        return pen_sphere_touches(&prims->sphere[ref.index], g->light,
                                  b + 0x1p-30 * prims->sphere[ref.index].r);
    case PEN_BLOCK_CYLINDERS: {
        const struct pen_cylinder *c = &prims->cylinder[ref.index];
        return pen_cylinder_touches(c, g->light, b + 0x1p-30 * (c->round.r + c->h)) != 0;
    }
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return true;
}

/* Tests a primitive against shadow rays. */
static inline void group_test_shadow(struct ray_group *g, uint32_t prim, bool see_through)
{
    const struct group_prim q = group_prim_of(g, prim, see_through);
    if (!g->to_point || !group_light_on(g, prim)) {
        group_test(g, &q);
        return;
    }
    for (int i = 0; i < g->count; i += LANES)
        group_ask_all(g, i, group_live(g, i), prim, true);
    g->live &= ~g->blocked;
}

/* The group's blocked rays. The last occluder is tried first, then what is opaque. */
static inline bool group_shadow(struct ray_group *g, struct pen_ray_packet *packet,
                                const uint8_t *see_through)
{
    struct group_candidate c[GROUP_CANDIDATES];
    int count;
    uint32_t last = packet->last_occluder;
    if (!group_begin(g))
        return false;
    if (last < g->accel->prims->count && !(see_through && see_through[last]))
        group_test_shadow(g, last, false);
    else
        last = PEN_NO_PRIM;
    if (!g->live)
        return true;
    if (!group_collect(g, c, &count))
        return false;
    for (int pass = 0; pass < (see_through ? 2 : 1); pass++) {
        for (int k = 0; k < count && g->live; k++) {
            const bool transmits = see_through && see_through[c[k].prim];
            const uint64_t live = g->live;
            if (c[k].prim == last || transmits != (pass == 1))
                continue;
            group_test_shadow(g, c[k].prim, transmits);
            if (g->live != live)
                packet->last_occluder = c[k].prim;
        }
    }
    return true;
}

/* Divides the rays of a packet by the largest axis of their directions and its sign. */
static inline void divide_rays(const struct pen_ray_packet *packet, uint64_t rays[6])
{
    for (int side = 0; side < 6; side++)
        rays[side] = 0;
    for (int i = 0; i < packet->count; i++)
        rays[2 * packet->ray[i]->kz + ray_is_forward(packet->ray[i])] |= UINT64_C(1) << i;
}

static inline bool group_is_worth(const struct pen_accel *accel, uint64_t rays)
{
    return accel->shape == PEN_SHAPE_WIDE && __builtin_popcountll(rays) >= GROUP_RAYS_MIN;
}

static inline uint64_t nearest_one_by_one(const struct pen_accel *accel,
                                          struct pen_ray_packet *packet, uint64_t rays)
{
    uint64_t met = 0;
    for (; rays; rays &= rays - 1) {
        const int i = __builtin_ctzll(rays);
        const struct pen_t_interval interval = {packet->after[i], INFINITY};
        met |=
            (uint64_t)nearest(accel, packet->ray[i], packet->origin[i], &interval, &packet->hit[i])
            << i;
    }
    return met;
}

static uint64_t nearest_packet(const struct pen_accel *accel, struct pen_ray_packet *packet)
{
    uint64_t met = 0, divided[6];
    divide_rays(packet, divided);
    for (int side = 0; side < 6; side++) {
        const uint64_t rays = divided[side];
        struct ray_group g;
        if (!rays)
            continue;
        if (!group_is_worth(accel, rays)) {
            met |= nearest_one_by_one(accel, packet, rays);
            continue;
        }
        group_init(&g, accel);
        for (uint64_t left = rays; left; left &= left - 1)
            group_add_nearest(&g, packet, __builtin_ctzll(left));
        if (!group_nearest(&g)) {
            met |= nearest_one_by_one(accel, packet, rays);
            continue;
        }
        int k = 0;
        for (uint64_t left = rays; left; left &= left - 1, k++) {
            const int i = __builtin_ctzll(left);
            packet->hit[i] = g.best[k];
            met |= (uint64_t)(g.best[k].prim != PEN_NO_PRIM) << i;
        }
    }
    return met;
}

static inline uint64_t shadow_one_by_one(const struct pen_accel *accel,
                                         struct pen_ray_packet *packet, uint64_t rays)
{
    uint64_t blocked = 0;
    for (; rays; rays &= rays - 1) {
        const int i = __builtin_ctzll(rays);
        packet->query[i]->last_occluder = packet->last_occluder;
        blocked |= (uint64_t)shadow(accel, packet->ray[i], packet->origin[i], packet->query[i])
                   << i;
        packet->last_occluder = packet->query[i]->last_occluder;
    }
    return blocked;
}

static uint64_t shadow_packet(const struct pen_accel *accel, struct pen_ray_packet *packet)
{
    uint64_t blocked = 0, divided[6];
    divide_rays(packet, divided);
    for (int side = 0; side < 6; side++) {
        const uint64_t rays = divided[side];
        if (!rays)
            continue;
        if (!group_is_worth(accel, rays)) {
            blocked |= shadow_one_by_one(accel, packet, rays);
            continue;
        }
        const struct pen_shadow *first = packet->query[__builtin_ctzll(rays)];
        struct ray_group g;
        group_init(&g, accel);
        g.any = true;
        g.to_point = first->to_point;
        g.light = packet->light;
        for (uint64_t left = rays; left; left &= left - 1)
            group_add_shadow(&g, packet, __builtin_ctzll(left));
        if (!group_shadow(&g, packet, first->see_through)) {
            blocked |= shadow_one_by_one(accel, packet, rays);
            continue;
        }
        int k = 0;
        for (uint64_t left = rays; left; left &= left - 1, k++)
            blocked |= (g.blocked >> k & 1) << __builtin_ctzll(left);
    }
    return blocked;
}

#endif
