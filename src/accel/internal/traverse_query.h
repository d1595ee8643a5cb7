/* SPDX-License-Identifier: MIT */
/* The two queries, nearest intersection and shadow ray: their begin, and the choice of the
 * traversal. The including file first includes an instruction set's header (see isa_base.h). It
 * states whether tests are counted: `enum { COUNTING = 0 };` or 1. */
#ifndef PEN_ACCEL_INTERNAL_TRAVERSE_QUERY_H
#define PEN_ACCEL_INTERNAL_TRAVERSE_QUERY_H

#include "accel/internal/traverse_lists.h"
#include "accel/internal/traverse_mesh.h"
#include "accel/internal/traverse_pairs.h"
#include "accel/internal/traverse_wide.h"

/* Traverses the rarer shapes. It is not inlined, so that the code for wide trees stays small. */
static __attribute__((noinline)) bool traverse_other(struct trace *trace, const struct box_ray *box,
                                                     bool any)
{
    return trace->accel->shape == PEN_SHAPE_PAIRS ? traverse_pairs(trace, box, any)
                                                  : traverse_lists(trace, box, any);
}

static inline bool search(struct trace *trace, double tmin, bool any)
{
    const struct pen_accel *accel = trace->accel;
    const uint32_t infinite = accel->infinite;
    if ((PEN_ITEM_KIND(accel->items[infinite]) != PEN_BLOCK_NOTHING &&
         test_leaf(trace, infinite, true, any)) ||
        (accel->list && test_leaf(trace, accel->list, true, any)))
        return true;
    if (accel->shape == PEN_SHAPE_NONE)
        return false;
    if (accel->mesh_frames) {
        if (any)
            return mesh_any(trace);
        mesh_nearest(trace);
        return false;
    }
    struct box_ray box;
    box_ray_make(&box, trace->ray, tmin, trace->grow);
    trace->box = &box;
    if (accel->shape != PEN_SHAPE_WIDE)
        return traverse_other(trace, &box, any);
    if (any)
        return traverse_any(trace, &box);
    traverse_nearest(trace, &box);
    return false;
}

/* Begins a query. A struct trace is never copied: a copy would wait for all of its stores. */
static inline void trace_begin(struct trace *trace, const struct pen_accel *accel,
                               const struct pen_ray *ray, const struct pen_origin_surface *origin)
{
    trace->accel = accel;
    trace->ray = ray;
    trace->origin = origin;
    trace->from_surface = origin->prim != PEN_NO_PRIM;
    trace->reaches_origin = false;
    trace->slack = origin->bound + 8 * PEN_U * accel->scale;
    trace->grow = 2 * PEN_NEARBY * trace->slack;
    trace->near_sq = trace->grow * trace->grow * ray->inv_dd;
    trace->box = NULL;
    trace->meshes = NULL;
    trace->shadow = NULL;
    trace->light_bound = 0;
}

static bool nearest(const struct pen_accel *accel, const struct pen_ray *ray,
                    const struct pen_origin_surface *origin, const struct pen_t_interval *interval,
                    struct pen_hit *hit)
{
    struct trace trace;
    trace_begin(&trace, accel, ray, origin);
    trace.after.t = interval->after.t;
    trace.after.prim = interval->after.prim;
    trace.after.part = interval->after.part;
    trace.best.t = interval->tmax;
    trace.best.prim = PEN_NO_PRIM;
    trace.best.part = UINT8_MAX;
    search(&trace, interval->after.t, false);
    if (trace.best.prim == PEN_NO_PRIM)
        return false;
    *hit = trace.best;
    return true;
}

static inline void trace_begin_shadow(struct trace *trace, const struct pen_accel *accel,
                                      const struct pen_ray *ray,
                                      const struct pen_origin_surface *origin,
                                      struct pen_shadow *query)
{
    trace_begin(trace, accel, ray, origin);
    trace->shadow = query;
    if (query->to_point) {
        trace->light_bound = pen_ray_end_bound(ray->o, ray->d);
        trace->light = pen_along(ray->o, ray->d, query->tmax);
    }
    query->count = 0;
    query->overflow = false;
}

static bool shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                   const struct pen_origin_surface *origin, struct pen_shadow *query)
{
    struct trace trace;
    trace_begin_shadow(&trace, accel, ray, origin, query);
    uint32_t last = query->last_occluder;
    /* Counts must not depend on earlier rays, so the hint is not tried. */
    if (!COUNTING && last < accel->prims->count &&
        !pen_see_through(accel->prims, query->see_through, last) && test_prim(&trace, last, true))
        return true;
    query->last_occluder = PEN_NO_PRIM;
    return search(&trace, 0, true);
}

#endif
