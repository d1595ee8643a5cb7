/* SPDX-License-Identifier: MIT */
/* The two queries, nearest intersection and shadow ray: how they begin, and which traversal they
 * use. The including file first includes an instruction set's header (see isa_base.h) and states
 * whether tests are counted: `enum { COUNTING = 0 };` or 1. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_QUERY_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_QUERY_H

#include "accel/internal/traverse_lists.h"
#include "accel/internal/traverse_pairs.h"
#include "accel/internal/traverse_wide.h"

/* The shapes that rays seldom traverse; not inlined, so that the code for wide trees stays small.
 */
static __attribute__((noinline)) bool traverse_other(struct trace *w, const struct box_ray *box,
                                                     bool any)
{
    return w->accel->shape == PEN_SHAPE_PAIRS ? traverse_pairs(w, box, any)
                                              : traverse_lists(w, box, any);
}

static inline bool search(struct trace *w, double tmin, bool any)
{
    const struct pen_accel *accel = w->accel;
    if (test_leaf(w, accel->infinite, true, any) ||
        (accel->list && test_leaf(w, accel->list, true, any)))
        return true;
    if (accel->shape == PEN_SHAPE_NONE)
        return false;
    struct box_ray box;
    box_ray_make(&box, w->ray, tmin, w->grow);
    if (accel->shape != PEN_SHAPE_WIDE)
        return traverse_other(w, &box, any);
    if (any)
        return traverse_any(w, &box);
    traverse_nearest(w, &box);
    return false;
}

static inline struct trace trace_begin(const struct pen_accel *accel, const struct pen_ray *ray,
                                       const struct pen_origin_surface *origin)
{
    struct trace w = {.accel = accel, .ray = ray, .origin = origin};
    w.from_surface = origin->prim != PEN_NO_PRIM;
    w.slack = origin->bound + 8 * PEN_U * accel->scale;
    w.grow = 2 * PEN_NEARBY * w.slack;
    w.near_sq = w.grow * w.grow * ray->inv_dd;
    return w;
}

static bool nearest(const struct pen_accel *accel, const struct pen_ray *ray,
                    const struct pen_origin_surface *origin, const struct pen_t_interval *interval,
                    struct pen_hit *hit)
{
    struct trace w = trace_begin(accel, ray, origin);
    w.after = interval->after;
    w.best = (struct pen_hit){interval->tmax, PEN_NO_PRIM, UINT8_MAX};
    search(&w, interval->after.t, false);
    if (w.best.prim == PEN_NO_PRIM)
        return false;
    *hit = w.best;
    return true;
}

static inline struct trace trace_begin_shadow(const struct pen_accel *accel,
                                              const struct pen_ray *ray,
                                              const struct pen_origin_surface *origin,
                                              struct pen_shadow *query)
{
    struct trace w = trace_begin(accel, ray, origin);
    w.shadow = query;
    if (query->to_point) {
        w.light_bound = pen_shadow_light_bound(ray);
        w.light = pen_along(ray->o, ray->d, query->tmax);
    }
    query->count = 0;
    query->overflow = false;
    return w;
}

static bool shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                   const struct pen_origin_surface *origin, struct pen_shadow *query)
{
    struct trace w = trace_begin_shadow(accel, ray, origin, query);
    uint32_t last = query->last_occluder;
    /* Counts must not depend on the rays before this one, so the hint is not tried. */
    if (!COUNTING && last < accel->prims->count &&
        !(query->see_through && query->see_through[last]) && test_prim(&w, last, true))
        return true;
    query->last_occluder = PEN_NO_PRIM;
    return search(&w, 0, true);
}

#endif
