/* SPDX-License-Identifier: MIT */
/* Refraction: reflection and transmission at the surface of a solid, and the refracted ray. It is
 * computed for every surface of a path. A surface that does not belong to a solid has equal indices
 * on both sides, and the same ray continues there.
 *
 * If rounding decides on which side of the surface the viewer is, the ray continues without
 * refraction, and nothing is reflected. If the ray has hardly left the surface it starts on, in a
 * corner, no reflected ray can start (surface_hardly_left), so everything is refracted. Energy is
 * preserved in both cases. */
#ifndef PEN_SHADE_INTERNAL_REFRACTION_H
#define PEN_SHADE_INTERNAL_REFRACTION_H

#include "geom/ray_lanes.h"
#include "shade/internal/media.h"
#include "shade/internal/snell.h"
#include "shade/internal/surface.h"

/* Reflection and transmission at the points of a surface. Arrays are by lane. */
struct refraction {
    double index[LANES],
        beyond[LANES]; /* the index on the side of the ray, and behind the surface */
    struct pen_vec3 kt[LANES];
    struct pen_vec3 reflected[LANES], transmitted[LANES]; /* factors of the path's weight */
    unsigned straight;         /* lanes in which the same ray continues */
    struct pen_ray ray[LANES]; /* in the other lanes: the refracted ray */
};

/* Whether the scene refracts. A kernel with refraction also renders scenes without it. */
static ALWAYS_INLINE bool refracts(const struct pen_scene *scene, const unsigned fx)
{
    return (fx & PEN_FX_REFRACTION) && scene->solids.count > 0;
}

/* Whether a ray that comes from outside the surface enters the solid of the primitive. */
static ALWAYS_INLINE bool enters(const struct pen_solids *solids, uint32_t prim, bool outside)
{
    return outside != (solids->turned[prim] != 0);
}

/* Sets the indices at a lane's point. A path that leaves a solid which it has not entered was
 * inside it if the solid is open. If it is closed, the ray passes its edge. */
static ALWAYS_INLINE void refraction_cross(struct refraction *r, const struct pen_scene *scene,
                                           const struct surface *s, int lane, struct media *media,
                                           struct pen_ray_counts *counts)
{
    const struct pen_solids *solids = &scene->solids;
    const uint32_t prim = s->hit[lane].prim, solid = solids->of_prim[prim];
    if (solid == PEN_NO_SOLID)
        return;
    const bool entering = enters(solids, prim, lane_mask_bits(s->outside) >> lane & 1);
    if (!entering && media_lacks(media, solid)) {
        counts->unmatched_exits++;
        if (solids->at[solid].closed) {
            r->index[lane] = r->beyond[lane] = media_index_without(solids, media, PEN_NO_SOLID);
            return;
        }
        media_add(media, solid);
    }
    r->index[lane] = media_index_without(solids, media, PEN_NO_SOLID);
    r->beyond[lane] = entering ? media_index_with(solids, media, solid)
                               : media_index_without(solids, media, solid);
}

/* Sets the media of the transmitted path. */
static ALWAYS_INLINE void refraction_pass(const struct pen_scene *scene, const struct surface *s,
                                          int lane, struct media *media)
{
    const struct pen_solids *solids = &scene->solids;
    const uint32_t prim = s->hit[lane].prim, solid = solids->of_prim[prim];
    if (solid == PEN_NO_SOLID)
        return;
    if (enters(solids, prim, lane_mask_bits(s->outside) >> lane & 1))
        media_add(media, solid);
    else
        media_remove(media, solid);
}

/* Begins as if no surface belonged to a solid. */
static ALWAYS_INLINE void refraction_begin(struct refraction *r, const struct surface *s,
                                           const struct pen_scene *scene, const unsigned fx)
{
    for (int i = 0; i < LANES; i++)
        r->index[i] = r->beyond[i] = 1;
    lanes3_store(r->kt, surface_colours(s, scene, offsetof(struct pen_material, kt), fx));
}

/* Sets the factors and rays from the indices and kt. */
static ALWAYS_INLINE void refraction_end(struct refraction *r, const struct surface *s,
                                         const struct pen_scene *scene, const unsigned fx)
{
    const lanes zero = lanes_splat(0), one = lanes_splat(1);
    const lanes n1 = lanes_load(r->index), n2 = lanes_load(r->beyond);
    const struct refracted ray = lanes_refract(s->n, s->v, s->nv, n1, n2);
    const lane_mask corner = lanes_equal(s->unsure, lanes_splat(INFINITY));
    const lane_mask grazes = lanes_at_most(-s->nv, lanes_splat(PEN_HORIZON_SINE)) |
                             (surface_viewer_grazes(s) & lane_mask_not(corner));
    const lane_mask straight = lanes_equal(n1, n2) | grazes | (corner & ray.total);
    const lanes share = lanes_select(straight | corner, zero, ray.fresnel);
    const struct lanes3 kt = lanes3_load(r->kt);
    const struct lanes3 kr = surface_colours(s, scene, offsetof(struct pen_material, kr), fx);
    lanes3_store(r->reflected, lanes3_along(kr, kt, share));
    lanes3_store(r->transmitted, lanes3_scale(kt, one - share));
    r->straight = lane_mask_bits(straight);
    if (r->straight != LANES_ALL) {
        struct pen_ray *to[LANES];
        for (int i = 0; i < LANES; i++)
            to[i] = &r->ray[i];
        lanes_ray_make(to, s->p, ray.d);
    }
}

/* Turns a path into the refracted one, at a point where it does not go straight on. */
static ALWAYS_INLINE void refraction_turn(const struct refraction *r, const struct surface *s,
                                          int lane, struct path *path)
{
    path->ray = r->ray[lane];
    path->origin = surface_origin(s, lane, true);
    path->after = pen_after_start;
}

/* Whether a hit is on a solid's surface that coincides with the surface that the ray starts on. */
static ALWAYS_INLINE bool is_layer_of_solid(const struct pen_scene *scene, struct pen_hit hit)
{
    return hit.t > PEN_FIRST_T && hit.t <= PEN_LAST_LAYER_T &&
           scene->solids.of_prim[hit.prim] != PEN_NO_SOLID;
}

/* Whether the path has passed the hit at its start. A path through a surface of a solid passes all
 * surfaces of solids that coincide with it. */
static ALWAYS_INLINE bool has_passed_layer(const struct pen_scene *scene, const struct path *path,
                                           struct pen_hit hit)
{
    return path->origin.through && is_layer_of_solid(scene, hit) &&
           scene->solids.of_prim[path->origin.prim] != PEN_NO_SOLID;
}

#endif
