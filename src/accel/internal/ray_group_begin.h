/* SPDX-License-Identifier: MIT */
/* How a group of rays is filled, and what is prepared of it: beams, and what tests of outlines
 * need. */
#ifndef PEN_ACCEL_INTERNAL_RAY_GROUP_BEGIN_H
#define PEN_ACCEL_INTERNAL_RAY_GROUP_BEGIN_H

#include "accel/internal/ray_group.h"

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
}

static inline void group_add(struct ray_group *g, const struct pen_ray_packet *packet, int ray)
{
    const int i = g->count++;
    const struct pen_ray *r = packet->ray[ray];
    const struct pen_origin_surface *origin = packet->origin[ray];
    const bool from_surface = origin->prim != PEN_NO_PRIM;
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
    g->near[i] = r->near;
    g->bound[i] = from_surface ? origin->bound : -1;
    g->from_surface |= from_surface;
    group_add_own(g, i, origin->prim);
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

/* Fills the arrays beyond the last ray, up to a whole part, with copies of the first. */
static inline void group_pad(struct ray_group *g)
{
    double *const all[] = {g->o[0], g->o[1],   g->o[2], g->d[0],    g->d[1], g->d[2], g->sx,
                           g->sy,   g->inv_dd, g->near, g->after_t, g->tmax, g->bound};
    const int whole = (g->count + GROUP_PART - 1) / GROUP_PART * GROUP_PART;
    for (size_t k = 0; g->count < whole && k < sizeof all / sizeof *all; k++)
        for (int i = g->count; i < whole; i++)
            all[k][i] = all[k][0];
    g->live = g->count < 64 ? (UINT64_C(1) << g->count) - 1 : UINT64_MAX;
    g->blocked = 0;
    g->part_bits = (1u << whole / GROUP_PART) - 1;
}

/* Of rays that start on a surface, how far the self-intersection rule reaches: as trace_begin.
 * Others have 0 and -1. */
static inline void group_begin_slack(struct ray_group *g)
{
    const lanes own = lanes_splat(8 * PEN_U * g->accel->scale), zero = lanes_splat(0);
    lanes most = zero;
    g->grow = g->most_slack = 0;
    for (int i = 0; i < g->count; i += LANES) {
        const lanes bound = lanes_load(g->bound + i);
        const lane_mask free = lanes_less(bound, zero);
        const lanes slack = bound + own, grow = lanes_splat(2 * PEN_NEARBY) * slack;
        const lanes near_sq = grow * grow * lanes_load(g->inv_dd + i);
        most = lanes_max(most, lanes_select(free, zero, slack));
        lanes_store(g->near_sq + i, lanes_select(free, lanes_splat(-1), near_sq));
        lanes_store(g->slack + i, lanes_select(free, zero, slack));
        lanes_store(g->bound + i, lanes_select(free, zero, bound));
    }
    g->most_slack = lanes_largest(most);
    g->grow = 2 * PEN_NEARBY * g->most_slack;
}

/* The least and the largest of the numbers of each part. */
struct group_range {
    double lo[GROUP_PARTS], hi[GROUP_PARTS];
};

static inline struct group_range group_range_of(const struct ray_group *g, const double *x)
{
    struct group_range range;
    for (int k = 0; k < GROUP_PARTS; k++) {
        const int i = k * GROUP_PART < g->count ? k * GROUP_PART : 0;
        lanes least = lanes_load(x + i), most = least;
        for (int n = LANES; n < GROUP_PART; n += LANES) {
            least = lanes_min(lanes_load(x + i + n), least);
            most = lanes_max(lanes_load(x + i + n), most);
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

/* The ranges of a group's origins and slopes, of each part and of all. */
struct group_ranges {
    struct group_range o[3], s[2];
    double o_lo[3], o_hi[3], s_lo[2], s_hi[2];
};

static inline void group_ranges_of(const struct ray_group *g, struct group_ranges *r)
{
    for (int k = 0; k < 3; k++) {
        r->o[k] = group_range_of(g, g->o[k]);
        r->o_lo[k] = smallest_of(r->o[k].lo);
        r->o_hi[k] = largest_of(r->o[k].hi);
    }
    for (int k = 0; k < 2; k++) {
        r->s[k] = group_range_of(g, k ? g->sy : g->sx);
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
    const struct pen_ray *first = g->ray[0];
    const struct pen_vec3 light = pen_permuted(first, &g->light);
    struct beam *beam = &g->beam;
    *beam = (struct beam){.axis = {first->kx, first->ky, first->kz},
                          .forward = ray_is_forward(first) != g->to_point,
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
    struct beams *b = &g->parts;
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < GROUP_PARTS; i++) {
            b->least[k][i] = (float)(beam->forward ? r->s[k].lo[i] : -r->s[k].hi[i]);
            b->most[k][i] = (float)(beam->forward ? r->s[k].hi[i] : -r->s[k].lo[i]);
        }
    }
    for (int k = 0; k < 3; k++) {
        const float lo = beam->lo[k], hi = beam->hi[k];
        for (int i = 0; i < GROUP_PARTS; i++) {
            b->lo[k][i] = g->to_point ? lo : (float)r->o[k].lo[i];
            b->hi[k][i] = g->to_point ? hi : (float)r->o[k].hi[i];
        }
        for (int i = 0; g->to_point && i < GROUP_PARTS; i++) {
            const float least = (float)(r->o[k].lo[i] - margin), at = beam->lo[k] - beam->margin;
            const float most = (float)(r->o[k].hi[i] + margin), to = beam->hi[k] + beam->margin;
            b->box_lo[k][i] = least < at ? least : at;
            b->box_hi[k][i] = most > to ? most : to;
        }
    }
}

/* Prepares tests of outlines; x is the largest size of a coordinate. */
static inline void group_begin_edges(struct ray_group *g, const struct group_ranges *r, double x)
{
    const struct pen_vec3 c = g->to_point ? pen_permuted(g->ray[0], &g->light)
                                          : pen_vec3(g->o[0][0], g->o[1][0], g->o[2][0]);
    const struct lanes3 middle = lanes3_splat(c);
    lanes most = lanes_splat(0);
    for (int i = 0; i < g->count; i += LANES) {
        const struct lanes3 o = lanes3_sub(group_origin(g, i), middle);
        const lanes sx = lanes_load(g->sx + i), sy = lanes_load(g->sy + i);
        const struct lanes3 m = {o.y - o.z * sy, o.z * sx - o.x, o.x * sy - o.y * sx};
        lanes_store(g->moment[0] + i, m.x);
        lanes_store(g->moment[1] + i, m.y);
        lanes_store(g->moment[2] + i, m.z);
        most =
            lanes_max(most, lanes_max(lanes_abs(m.x), lanes_max(lanes_abs(m.y), lanes_abs(m.z))));
    }
    const double moved = lanes_largest(most);
    g->middle = c;
    g->concurrent = moved <= 0x1p-40 * x;
    g->edge_distance = x > 0x1p-200 ? 0x1p-44 * x + (g->concurrent ? 3 * moved : 0) : 0;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < GROUP_CORNERS; i++)
            g->corner[k][i] = i >> k & 1 ? r->s_hi[k] : r->s_lo[k];
}

/* Prepares the group. False if lengths are out of the range of binary32. */
static inline bool group_begin(struct ray_group *g)
{
    struct group_ranges r;
    group_pad(g);
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
