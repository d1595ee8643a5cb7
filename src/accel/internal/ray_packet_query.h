/* SPDX-License-Identifier: MIT */
/* The queries of ray packets: divides the rays into groups, collects the primitives that a group's
 * beam enters, and tests them. */
#ifndef PEN_ACCEL_INTERNAL_RAY_PACKET_QUERY_H
#define PEN_ACCEL_INTERNAL_RAY_PACKET_QUERY_H

#include "accel/internal/ray_group_begin.h"
#include "accel/internal/ray_group_test.h"

/* Smaller groups are traced ray by ray, which is faster by measurement. So are groups with more
 * candidates than rays, as in fine meshes, because a single ray skips most of these. */
enum { GROUP_RAYS_MIN = 12 };

/* A primitive that some ray may meet. */
struct group_candidate {
    float near; /* a lower bound of the depth at which a ray meets it: see beam.h */
    uint32_t prim;
    uint64_t rays; /* the other rays certainly miss it */
};

/* The box of a finite primitive. That of a triangle of a mesh is made in *room. */
static inline const struct pen_float_box *accel_box(const struct pen_accel *accel, uint32_t prim,
                                                    struct pen_float_box *room)
{
    if (!pen_prim_mesh(accel->prims, prim))
        return &accel->prim_box[pen_prim_slot(accel->prims, prim)];
    const struct pen_box box = pen_prim_bounds(accel->prims, prim);
    *room = (struct pen_float_box){
        {pen_float_down(box.lo.x), pen_float_down(box.lo.y), pen_float_down(box.lo.z)},
        {pen_float_up(box.hi.x), pen_float_up(box.hi.y), pen_float_up(box.hi.z)}};
    return room;
}

/* Whether the origin of some ray may be on a primitive in this box, or on its border. */
static inline bool group_starts_in(const struct ray_group *g, const struct pen_float_box *box)
{
    return g->from_surface && box->lo[0] <= g->origins.hi.x && box->hi[0] >= g->origins.lo.x &&
           box->lo[1] <= g->origins.hi.y && box->hi[1] >= g->origins.lo.y &&
           box->lo[2] <= g->origins.hi.z && box->hi[2] >= g->origins.lo.z;
}

/* Whether the light and the origins of all shadow rays are on one side of a flat primitive, by more
 * than all roundings (the beam's margin). */
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

/* Whether shadow rays to a point certainly miss a flat primitive, because they are on one side of
 * it. */
static inline bool group_misses(const struct ray_group *g, uint32_t prim)
{
    struct pen_triangle room;
    const struct pen_prims *prims = g->accel->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    if (!g->to_point)
        return false;
    if (ref.kind == PEN_PRIM_TRIANGLE) {
        const struct pen_triangle *t = pen_prim_triangle(prims, ref.index, &room);
        return group_on_one_side(g, t->facet.n, t->v[0]);
    }
    if (ref.kind == PEN_PRIM_POLYGON)
        return prims->polygon[ref.index].flat &&
               group_on_one_side(g, prims->polygon[ref.index].facet.n,
                                 prims->polygon[ref.index].v[0]);
    return ref.kind == PEN_PRIM_PLANE &&
           group_on_one_side(g, prims->plane[ref.index].n, prims->plane[ref.index].q);
}

/* The rays of the parts of the group whose beams enter a box. */
static inline uint64_t group_rays_in(const struct ray_group *g, const struct pen_float_box *box)
{
    uint64_t rays = 0;
    for (unsigned parts = beams_enter(&g->parts, &g->beam, box) & g->part_bits; parts;
         parts &= parts - 1)
        rays |= (uint64_t)0xff << 8 * __builtin_ctz(parts);
    return rays;
}

/* The rays that may meet a primitive. */
static inline uint64_t group_rays_at(const struct ray_group *g, uint32_t prim)
{
    struct pen_float_box room;
    const bool infinite = pen_prim_infinite(pen_prim_kind(g->accel->prims, prim));
    return infinite ? UINT64_MAX : group_rays_in(g, accel_box(g->accel, prim, &room));
}

/* Whether a primitive is tested in lanes. A primitive without such a test needs the scalar test for
 * every ray of a part, although most of these miss its box. So groups that meet it are faster ray
 * by ray. */
static inline bool group_has_test(const struct ray_group *g, uint32_t prim)
{
    switch (pen_block_of(pen_prim_kind(g->accel->prims, prim))) {
    case PEN_BLOCK_POLYGONS:
        return !pen_prim_cut(g->accel->prims, prim);
    case PEN_BLOCK_TRIANGLES:
    case PEN_BLOCK_SPHERES:
    case PEN_BLOCK_CYLINDERS:
    case PEN_BLOCK_PLANES:
        return true;
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return false;
}

/* Collects the candidates among the primitives of a list of items. Returns false if there are too
 * many. */
static inline bool group_collect_leaf(const struct ray_group *g, uint32_t first, bool boxes,
                                      struct group_candidate *out, int *count)
{
    struct pen_float_box room;
    uint32_t items[PEN_LEAF_BLOCKS_MAX];
    for (const uint32_t *item = leaf_items(g->accel, first, items);; item++) {
        const uint32_t *prim = block_prims(g->accel, *item);
        for (int lane = 0; prim && lane < PEN_LANES && prim[lane] != PEN_NO_PRIM; lane++) {
            struct group_candidate c = {0, prim[lane], UINT64_MAX};
            if (boxes) {
                const struct pen_float_box *box = accel_box(g->accel, c.prim, &room);
                c.rays = group_rays_in(g, box);
                c.near = beam_near(&g->beam, box);
            }
            if (!c.rays)
                continue;
            if (group_misses(g, c.prim))
                continue;
            if (*count == g->ray_count || (boxes && !group_has_test(g, c.prim)))
                return false;
            out[(*count)++] = c;
        }
        if (*item & PEN_ITEM_LAST)
            return true;
    }
}

/* Finds the leaves that the beam enters, as numbers of their first items. Returns false if there
 * are more than three leaves for four rays. In nine of ten such groups their primitives would make
 * too many candidates, and to find that out later costs more. */
static inline bool group_leaves(const struct ray_group *g, uint32_t *leaves, int *count)
{
    uint32_t stack[STACK];
    int top = 0;
    *count = 0;
    stack[top++] = 0;
    while (top > 0) {
        const struct pen_node *node = &g->accel->nodes[stack[--top]];
        for (unsigned in = beam_enter_node(&g->beam, node); in; in &= in - 1) {
            const uint32_t child = node->child[__builtin_ctz(in)];
            if (!(child & PEN_CHILD_LEAF))
                stack[top++] = child;
            else if (*count == g->ray_count * 3 / 4)
                return false;
            else
                leaves[(*count)++] = child & ~PEN_CHILD_LEAF;
        }
    }
    return true;
}

/* Collects all candidates. Returns false if there are too many. */
static inline bool group_collect(const struct ray_group *g, struct group_candidate *out, int *count)
{
    uint32_t leaves[PEN_RAY_PACKET_MAX];
    int leaf_count;
    *count = 0;
    if (!group_leaves(g, leaves, &leaf_count) ||
        !group_collect_leaf(g, g->accel->infinite, false, out, count))
        return false;
    for (int k = 0; k < leaf_count; k++)
        if (!group_collect_leaf(g, leaves[k], true, out, count))
            return false;
    return true;
}

/* A primitive that only `rays` may meet, for a test. */
static inline struct group_prim group_prim_of(const struct ray_group *g, uint32_t prim,
                                              uint64_t rays, bool see_through)
{
    struct pen_float_box room;
    const bool infinite = pen_prim_infinite(pen_prim_kind(g->accel->prims, prim));
    const bool near =
        g->from_surface && (infinite || group_starts_in(g, accel_box(g->accel, prim, &room)));
    return (struct group_prim){
        .prim = prim,
        .rays = rays,
        .own = near ? group_own(g, prim) : 0,
        .near = near,
        .see_through = see_through,
    };
}

/* Sorts candidates, the nearest first, so that later ones can be skipped. */
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

/* The largest depth at which a ray may still meet a primitive nearer than its best intersection. */
static inline double group_depth(const struct ray_group *g)
{
    lanes most = lanes_splat(0);
    for (int i = 0; i < g->end; i += LANES) {
        const lanes depth = lanes_load(g->tmax + i) * lanes_abs(lanes_load(g->rays->d[2] + i));
        most = lanes_max(most, lanes_select(g->in_group[i / LANES], depth, lanes_splat(0)));
    }
    return lanes_largest(most);
}

static inline bool group_nearest(struct ray_group *g)
{
    struct group_candidate c[PEN_RAY_PACKET_MAX];
    int count;
    if (!group_begin(g) || !group_collect(g, c, &count))
        return false;
    sort_candidates(c, count);
    for (int k = 0; k < count; k++) {
        if (c[k].near > 0 && (double)c[k].near > 1.0000001 * group_depth(g))
            break;
        struct group_prim q = group_prim_of(g, c[k].prim, c[k].rays, false);
        q.depth = c[k].near;
        group_test(g, &q);
    }
    for (uint64_t left = g->all; left; left &= left - 1) {
        const int i = __builtin_ctzll(left);
        g->packet->hit[i] = group_hit(g, i);
    }
    return true;
}

/* Whether a point may be within b of a facet's plane. The sums are off by less than 2^-48 of the
 * coordinates, and b is 2^-30 of them; the normal's length is below 2. */
static inline bool may_be_on_facet(const struct pen_facet *facet, struct pen_vec3 p, double b)
{
    return fabs(facet->c - pen_dot(facet->g, p)) <= 2 * b;
}

/* Whether a primitive may contain the light, so that rays that end there do not count it. A
 * primitive farther away than light_bound certainly does not: pen_ray_end_bound and the roundings
 * of t and of the primitive are below 2^-40 of the coordinates. */
static inline bool group_light_on(const struct ray_group *g, uint32_t prim)
{
    struct pen_triangle room;
    const struct pen_prims *prims = g->accel->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    const double b = g->light_bound;
    switch (pen_block_of(ref.kind)) {
    case PEN_BLOCK_TRIANGLES:
        return may_be_on_facet(&pen_prim_triangle(prims, ref.index, &room)->facet, g->light, b);
    case PEN_BLOCK_POLYGONS:
        return prims->polygon[ref.index].piece ||
               may_be_on_facet(&prims->polygon[ref.index].facet, g->light,
                               b + 8 * PEN_U * prims->polygon[ref.index].scale);
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
    case PEN_BLOCK_MESH:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    return true;
}

/* Tests a primitive against shadow rays. */
static inline void group_test_shadow(struct ray_group *g, uint32_t prim, uint64_t rays,
                                     bool see_through)
{
    const struct group_prim q = group_prim_of(g, prim, rays, see_through);
    if (!g->to_point || !group_light_on(g, prim)) {
        group_test(g, &q);
        return;
    }
    for (int i = 0; i < g->end; i += LANES)
        group_fall_back_all(g, i, group_live(g, i), prim, true);
    g->live &= ~g->blocked;
}

/* Finds the group's blocked rays. The last occluder is tested first, then opaque candidates. */
static inline bool group_shadow(struct ray_group *g)
{
    struct group_candidate c[PEN_RAY_PACKET_MAX];
    struct pen_ray_packet *packet = g->packet;
    const uint8_t *see_through = packet->see_through;
    int count;
    uint32_t last = packet->last_occluder;
    if (!group_begin(g))
        return false;
    if (last < g->accel->prims->count && !pen_see_through(g->accel->prims, see_through, last))
        group_test_shadow(g, last, group_rays_at(g, last), false);
    else
        last = PEN_NO_PRIM;
    if (!g->live)
        return true;
    if (!group_collect(g, c, &count))
        return false;
    for (int pass = 0; pass < (see_through ? 2 : 1); pass++) {
        for (int k = 0; k < count && g->live; k++) {
            const bool transmits = pen_see_through(g->accel->prims, see_through, c[k].prim);
            const uint64_t live = g->live;
            if (c[k].prim == last || transmits != (pass == 1))
                continue;
            group_test_shadow(g, c[k].prim, c[k].rays, transmits);
            if (g->live != live)
                packet->last_occluder = c[k].prim;
        }
    }
    return true;
}

/* Divides the rays of a packet by the largest axis of their directions and its sign. */
static inline void divide_rays(const struct pen_ray_packet *packet, uint64_t rays[6])
{
    const uint64_t x = packet->rays.along_x, y = packet->rays.along_y;
    const uint64_t along[3] = {x, y, ~(x | y)};
    for (int k = 0; k < 3; k++) {
        rays[2 * k] = packet->live & along[k] & ~packet->rays.forward;
        rays[2 * k + 1] = packet->live & along[k] & packet->rays.forward;
    }
}

static inline bool group_is_worth(const struct pen_accel *accel, uint64_t rays)
{
    return accel->packets && __builtin_popcountll(rays) >= GROUP_RAYS_MIN;
}

static inline void nearest_one_by_one(const struct pen_accel *accel, struct pen_ray_packet *packet,
                                      uint64_t rays)
{
    for (; rays; rays &= rays - 1) {
        const int i = __builtin_ctzll(rays);
        const struct pen_t_interval interval = {packet->after[i], INFINITY};
        struct pen_ray ray;
        pen_ray_array_get(&packet->rays, i, &ray);
        packet->hit[i].prim = PEN_NO_PRIM;
        nearest(accel, &ray, packet->origin[i], &interval, &packet->hit[i]);
    }
}

static uint64_t nearest_packet(const struct pen_accel *accel, struct pen_ray_packet *packet)
{
    uint64_t met = 0, divided[6];
    divide_rays(packet, divided);
    for (int side = 0; side < 6; side++) {
        const uint64_t rays = divided[side];
        if (!rays)
            continue;
        bool done = false;
        if (group_is_worth(accel, rays)) {
            struct ray_group g;
            group_init(&g, accel, packet, rays);
            group_init_nearest(&g);
            done = group_nearest(&g);
        }
        if (!done)
            nearest_one_by_one(accel, packet, rays);
    }
    for (uint64_t left = packet->live; left; left &= left - 1) {
        const int i = __builtin_ctzll(left);
        met |= (uint64_t)(packet->hit[i].prim != PEN_NO_PRIM) << i;
    }
    return met;
}

static inline uint64_t shadow_one_by_one(const struct pen_accel *accel,
                                         struct pen_ray_packet *packet, uint64_t rays)
{
    uint64_t blocked = 0;
    for (; rays; rays &= rays - 1) {
        const int i = __builtin_ctzll(rays);
        struct pen_shadow *query = packet_query(packet, i);
        struct pen_ray ray;
        pen_ray_array_get(&packet->rays, i, &ray);
        query->last_occluder = packet->last_occluder;
        blocked |= (uint64_t)shadow(accel, &ray, packet->origin[i], query) << i;
        packet->last_occluder = query->last_occluder;
    }
    return blocked;
}

static uint64_t shadow_packet(const struct pen_accel *accel, struct pen_ray_packet *packet)
{
    uint64_t blocked = 0, divided[6];
    divide_rays(packet, divided);
    packet->recorded = 0;
    for (int side = 0; side < 6; side++) {
        uint64_t rays = divided[side];
        if (!rays)
            continue;
        if (group_is_worth(accel, rays)) {
            struct ray_group g;
            group_init(&g, accel, packet, rays);
            group_init_shadow(&g);
            const bool done = group_shadow(&g);
            blocked |= g.blocked & rays;
            rays &= done ? 0 : ~g.blocked;
        }
        blocked |= shadow_one_by_one(accel, packet, rays);
    }
    return blocked;
}

#endif
