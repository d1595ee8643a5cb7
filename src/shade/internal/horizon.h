/* SPDX-License-Identifier: MIT */
/* The horizon of a shaded point: whether a direction goes above the surface's tangent plane, on the
 * viewer's side, or below it. If it grazes the plane, rounding decides, and it counts as neither.
 *
 * One test serves three uses: the arriving light (unshadowed_light.h), the samples of a light's
 * disk (soft_shadow.h), and the side of the surface on which a shadow ray starts (shadow_ray.h).
 * Specular light is not multiplied by n.l. So a light that rounding puts above the horizon would
 * add its full highlight.
 *
 * With n the unit normal towards the viewer and q the vector to the light, or to a sample, q grazes
 * if |n.q| is at most the largest of
 *  - PEN_HORIZON_SINE |q|: lower rays may pass the foot of a wall beyond the range of the
 *    self-intersection rule;
 *  - bound(p) + bound(end), if the ray ends in a point: this is the error of the shaded point and
 *    the end;
 *  - |q| bound(p) / radius, on a round surface: moving p by its bound turns the normal by that
 *    much. */
#ifndef PEN_SHADE_INTERNAL_HORIZON_H
#define PEN_SHADE_INTERNAL_HORIZON_H

#include "shade/internal/surface.h"

/* Points of a surface for which q is above the horizon, and below it; it grazes the others. */
struct horizon_sides {
    lane_mask above, below;
};

/* The largest |n.q| at which q grazes, for |q| = length. bound(end) is pen_ray_end_bound(p, q) =
 * 16u (|p|_1 + |q|_1), where bound(p) contains 16u |p|_1, and |q|_1 <= 2 |q|. */
static ALWAYS_INLINE lanes horizon_band(const struct surface *s, lanes length, bool to_point)
{
    const lanes band = s->grazing_sine * length;
    return to_point ? lanes_max(2 * s->bound + 32 * PEN_U * length, band) : band;
}

/* The side of q from each point. q is a vector to a point, or a direction of any length; nq is n.q.
 */
static ALWAYS_INLINE struct horizon_sides horizon_sides(lanes nq, lanes band)
{
    return (struct horizon_sides){lanes_less(band, nq), lanes_less(nq, -band)};
}

#endif
