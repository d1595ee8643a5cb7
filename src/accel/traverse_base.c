/* SPDX-License-Identifier: MIT */
/* Queries in plain C: the reference for every other variant. */
#include "accel.h"

static bool nearest(const struct pen_accel *accel, const struct pen_ray *ray,
                    const struct pen_leave *leave, const struct pen_span *span, struct pen_hit *hit)
{
    bool found = false;
    struct pen_crossings c;
    for (uint32_t prim = 0; prim < accel->prims->count; prim++) {
        pen_prim_cross(accel->prims, prim, ray, leave, &c);
        for (int i = 0; i < c.count; i++) {
            struct pen_hit h = {c.t[i], prim, c.part[i]};
            if (!(h.t <= span->tmax) || !pen_hit_before(span->after, h))
                continue;
            if (!found || pen_hit_before(h, *hit))
                *hit = h;
            found = true;
        }
    }
    return found;
}

/* Keeps the see-through crossings in order. */
static void keep(struct pen_shadow *query, struct pen_hit h)
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

static bool shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                   const struct pen_leave *leave, struct pen_shadow *query)
{
    struct pen_crossings c;
    double light = query->to_point ? 16 * PEN_U * pen_norm1(pen_add(ray->o, ray->d)) : 0;
    query->count = 0;
    query->overflow = false;
    for (uint32_t prim = 0; prim < accel->prims->count; prim++) {
        pen_prim_cross(accel->prims, prim, ray, leave, &c);
        for (int i = 0; i < c.count; i++) {
            struct pen_hit h = {c.t[i], prim, c.part[i]};
            if (!(h.t > 0 && h.t < query->tmax))
                continue;
            if (query->to_point && pen_prim_ends_ray(accel->prims, h, ray, query->tmax, light))
                continue;
            if (!query->see_through || !query->see_through[prim]) {
                query->last_occluder = prim;
                return true;
            }
            keep(query, h);
        }
    }
    return false;
}

const struct pen_trace_ops *pen_trace_ops_get(enum pen_isa isa)
{
    static const struct pen_trace_ops base = {"base", nearest, shadow};
    (void)isa;
    return &base;
}
