/* SPDX-License-Identifier: MIT */
/* Fills a group of rays, and prepares its beams and its tests of outlines. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_BEGIN_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_BEGIN_H

#include "accel/internal/ray_group.h"

/* Begins the group of rays of a packet whose directions have the same largest axis and sign. */
static inline void group_init(struct ray_group *g, const struct pen_accel *accel,
                              struct pen_ray_packet *packet, uint64_t rays)
{
    const int first = __builtin_ctzll(rays);
    g->packet = packet;
    g->rays = &packet->rays;
    g->accel = accel;
    g->all = g->live = rays;
    g->blocked = 0;
    g->ray_count = __builtin_popcountll(rays);
    g->end = 64 - __builtin_clzll(rays);
    pen_ray_axes(pen_ray_array_kz(&packet->rays, first), g->axis);
    g->from_surface = packet->from_surface;
    g->part_bits = 0;
    for (int k = 0; k < GROUP_PARTS; k++)
        g->part_bits |= (unsigned)((rays >> k * GROUP_PART & GROUP_PART_BITS) != 0) << k;
    for (int i = 0; i < PEN_RAY_PACKET_MAX; i += LANES)
        g->in_group[i / LANES] = lane_mask_of((unsigned)(rays >> i) & LANES_ALL);
}

static inline void group_init_shadow(struct ray_group *g)
{
    const lanes end = lanes_splat(g->packet->to_point ? 1 : INFINITY);
    g->any = true;
    g->to_point = g->packet->to_point;
    g->light = g->packet->light;
    for (int i = 0; i < g->end; i += LANES) {
        lanes_store(g->tmax + i, end);
        lanes_store(g->after_t + i, lanes_splat(0));
    }
}

static inline void group_init_nearest(struct ray_group *g)
{
    const struct pen_ray_packet *packet = g->packet;
    g->any = g->to_point = false;
    g->light = pen_vec3(0, 0, 0);
    for (int i = 0; i < g->end; i += LANES) {
        lanes_store(g->tmax + i, lanes_splat(INFINITY));
        lanes_store(g->met + i, lanes_splat(group_part_number(PEN_NO_PRIM, UINT8_MAX)));
    }
    for (uint64_t left = g->all; left; left &= left - 1) {
        const int i = __builtin_ctzll(left);
        g->after_t[i] = packet->after[i].t;
    }
}

/* Sets the reach of the self-intersection rule for rays that start on a surface, as trace_begin.
 * Other rays have 0 and -1. */
static inline void group_begin_slack(struct ray_group *g)
{
    const lanes own = lanes_splat(8 * PEN_U * g->accel->scale), zero = lanes_splat(0);
    lanes most = zero;
    g->grow = g->most_slack = 0;
    for (int i = 0; i < g->end; i += LANES) {
        const lanes bound = lanes_load(g->packet->bound + i);
        const lane_mask free = lanes_less(bound, zero);
        const lanes slack = bound + own, grow = lanes_splat(2 * PEN_NEARBY) * slack;
        const lanes near_sq = grow * grow * lanes_load(g->rays->inv_dd + i);
        most = lanes_max(most,
                         lanes_select(g->in_group[i / LANES] & lane_mask_not(free), slack, zero));
        lanes_store(g->near_sq + i, lanes_select(free, lanes_splat(-1), near_sq));
        lanes_store(g->slack + i, lanes_select(free, zero, slack));
        lanes_store(g->bound + i, lanes_select(free, zero, bound));
    }
    g->most_slack = lanes_largest(most);
    g->grow = 2 * PEN_NEARBY * g->most_slack;
}

/* The least and the largest number of each part; INFINITY and -INFINITY for a part without rays. */
struct group_range {
    double lo[GROUP_PARTS], hi[GROUP_PARTS];
};

static inline struct group_range group_range_of(const struct ray_group *g, const double *x)
{
    struct group_range range;
    const lanes inf = lanes_splat(INFINITY);
    for (int k = 0; k < GROUP_PARTS; k++) {
        const double *part = x + k * GROUP_PART;
        const lane_mask *in = &g->in_group[k * GROUP_PART / LANES];
        lanes least = inf, most = -inf;
#pragma GCC unroll 8
        for (int i = 0; i < GROUP_PART / LANES; i++) {
            const lanes at = lanes_load(part + i * LANES);
            least = lanes_min(lanes_select(in[i], at, inf), least);
            most = lanes_max(lanes_select(in[i], at, -inf), most);
        }
        range.lo[k] = lanes_smallest(least);
        range.hi[k] = lanes_largest(most);
    }
    return range;
}

static inline double smallest_of(const double x[GROUP_PARTS])
{
    lanes least = lanes_load(x);
    for (int k = LANES; k < GROUP_PARTS; k += LANES)
        least = lanes_min(lanes_load(x + k), least);
    return lanes_smallest(least);
}

static inline double largest_of(const double x[GROUP_PARTS])
{
    lanes most = lanes_load(x);
    for (int k = LANES; k < GROUP_PARTS; k += LANES)
        most = lanes_max(lanes_load(x + k), most);
    return lanes_largest(most);
}

/* The ranges of a group's origins and slopes, for each part and for all. */
struct group_ranges {
    struct group_range o[3], s[2];
    double o_lo[3], o_hi[3], s_lo[2], s_hi[2];
};

static inline void group_ranges_of(const struct ray_group *g, struct group_ranges *r)
{
    for (int k = 0; k < 3; k++) {
        r->o[k] = group_range_of(g, g->rays->o[k]);
        r->o_lo[k] = smallest_of(r->o[k].lo);
        r->o_hi[k] = largest_of(r->o[k].hi);
    }
    for (int k = 0; k < 2; k++) {
        r->s[k] = group_range_of(g, k ? g->rays->sy : g->rays->sx);
        r->s_lo[k] = smallest_of(r->s[k].lo);
        r->s_hi[k] = largest_of(r->s[k].hi);
    }
}

/* The largest size of a coordinate. */
static inline double group_extent(const struct ray_group *g, const struct group_ranges *r)
{
    double most = g->accel->extent;
    if (g->to_point)
        most = pen_larger(
            most, pen_larger(fabs(g->light.x), pen_larger(fabs(g->light.y), fabs(g->light.z))));
    for (int k = 0; k < 3; k++)
        most = pen_larger(most, pen_larger(-r->o_lo[k], r->o_hi[k]));
    return most;
}

/* Makes the beam of all rays. */
static inline void group_beam(struct ray_group *g, const struct group_ranges *r, double margin)
{
    const bool forward = g->rays->forward >> __builtin_ctzll(g->all) & 1;
    const struct pen_vec3 light = group_permuted(g, &g->light);
    struct beam *beam = &g->beam;
    *beam = (struct beam){.axis = {g->axis[0], g->axis[1], g->axis[2]},
                          .forward = forward != g->to_point,
                          .margin = pen_float_up(margin),
                          .bounded = g->to_point};
    for (int k = 0; k < 2; k++) {
        beam->least[k] = (float)(beam->forward ? r->s_lo[k] : -r->s_hi[k]);
        beam->most[k] = (float)(beam->forward ? r->s_hi[k] : -r->s_lo[k]);
    }
    for (int k = 0; k < 3; k++) {
        const double at = pen_component(light, k), lo = r->o_lo[k], hi = r->o_hi[k];
        beam->lo[k] = (float)(g->to_point ? at : lo);
        beam->hi[k] = (float)(g->to_point ? at : hi);
        beam->box_lo[beam->axis[k]] = (float)((lo < at ? lo : at) - margin);
        beam->box_hi[beam->axis[k]] = (float)((hi > at ? hi : at) + margin);
    }
}

/* Makes the beams of the parts. */
static inline void group_beams(struct ray_group *g, const struct group_ranges *r, double margin)
{
    const struct beam *beam = &g->beam;
    const double sign = beam->forward ? 1 : -1;
    struct beams *b = &g->parts;
    for (int k = 0; k < 2; k++) {
        const double *lo = beam->forward ? r->s[k].lo : r->s[k].hi;
        const double *hi = beam->forward ? r->s[k].hi : r->s[k].lo;
        for (int i = 0; i < GROUP_PARTS; i++)
            b->least[k][i] = (float)(sign * lo[i]);
        for (int i = 0; i < GROUP_PARTS; i++)
            b->most[k][i] = (float)(sign * hi[i]);
    }
    for (int k = 0; k < 3; k++) {
        const double *lo = r->o[k].lo, *hi = r->o[k].hi;
        if (!g->to_point) {
            for (int i = 0; i < GROUP_PARTS; i++)
                b->lo[k][i] = (float)lo[i];
            for (int i = 0; i < GROUP_PARTS; i++)
                b->hi[k][i] = (float)hi[i];
            continue;
        }
        const float from = beam->lo[k] - beam->margin, to = beam->hi[k] + beam->margin;
        for (int i = 0; i < GROUP_PARTS; i++) {
            const float least = (float)(lo[i] - margin), most = (float)(hi[i] + margin);
            b->lo[k][i] = beam->lo[k];
            b->hi[k][i] = beam->hi[k];
            b->box_lo[k][i] = least < from ? least : from;
            b->box_hi[k][i] = most > to ? most : to;
        }
    }
}

/* Prepares tests of outlines; x is the largest size of a coordinate. */
static inline void group_begin_edges(struct ray_group *g, const struct group_ranges *r, double x)
{
    const struct pen_ray_array *rays = g->rays;
    const int first = __builtin_ctzll(g->all);
    const struct pen_vec3 c =
        g->to_point ? group_permuted(g, &g->light)
                    : pen_vec3(rays->o[0][first], rays->o[1][first], rays->o[2][first]);
    const struct lanes3 middle = lanes3_splat(c);
    lanes most = lanes_splat(0);
    for (int i = 0; i < g->end; i += LANES) {
        const struct lanes3 o = lanes3_sub(group_origin(g, i), middle);
        const lanes sx = lanes_load(rays->sx + i), sy = lanes_load(rays->sy + i);
        const struct lanes3 m = {o.y - o.z * sy, o.z * sx - o.x, o.x * sy - o.y * sx};
        lanes_store(g->moment[0] + i, m.x);
        lanes_store(g->moment[1] + i, m.y);
        lanes_store(g->moment[2] + i, m.z);
        const lanes size = lanes_max(lanes_abs(m.x), lanes_max(lanes_abs(m.y), lanes_abs(m.z)));
        most = lanes_max(most, lanes_select(g->in_group[i / LANES], size, lanes_splat(0)));
    }
    const double moved = lanes_largest(most);
    g->middle = c;
    g->concurrent = moved <= 0x1p-40 * x;
    g->edge_distance = x > 0x1p-200 ? 0x1p-44 * x + (g->concurrent ? 3 * moved : 0) : 0;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < GROUP_CORNERS; i++)
            g->corner[k][i] = i >> k & 1 ? r->s_hi[k] : r->s_lo[k];
}

/* Prepares the group. Returns false if lengths are out of the range of binary32. */
static inline bool group_begin(struct ray_group *g)
{
    struct group_ranges r;
    group_begin_slack(g);
    group_ranges_of(g, &r);
    const double most = group_extent(g, &r), margin = 0x1p-18 * most + g->grow;
    if (!(most < 0x1p60 && g->grow < 0x1p60))
        return false;
    group_beam(g, &r, margin);
    group_beams(g, &r, margin);
    for (int k = 0; k < 3; k++) {
        ((double *)&g->origins.lo)[g->beam.axis[k]] = r.o_lo[k] - g->grow;
        ((double *)&g->origins.hi)[g->beam.axis[k]] = r.o_hi[k] + g->grow;
    }
    g->extent = most;
    g->light_bound = 0x1p-30 * most;
    group_begin_edges(g, &r, most);
    return true;
}

#endif
