/* SPDX-License-Identifier: MIT */
/* The horizon of a shaded point: whether a direction goes above the surface's tangent plane, on the
 * viewer's side, or below it, or grazes it: then rounding decides, and it counts as neither.
 *
 * One answer serves the light that arrives (unshadowed_light.h), the samples of a light's disk
 * (soft_shadow.h), and which side of the surface a shadow ray starts on (shadow_ray.h). Specular
 * light is not multiplied by n.l, so a light taken for one above the horizon by rounding would
 * bring its full highlight.
 *
 * With n the unit normal towards the viewer and q the vector to the light, or to a sample, q grazes
 * if |n.q| is at most the largest of
 *  - PEN_HORIZON_SINE |q|: lower rays may pass the foot of a wall outside the range in which the
 *    self-intersection rule looks for it;
 *  - bound(p) + bound(end), if the ray ends in a point: neither the shaded point nor the end is
 *    known better;
 *  - |q| bound(p) / radius, on a round surface: moving p by its bound turns the normal that much.
 */
#ifndef PEN_SHADE_INTERNAL_HORIZON_H
#define PEN_SHADE_INTERNAL_HORIZON_H

#include "shade/internal/surface.h"

enum horizon_side { HORIZON_BELOW, HORIZON_GRAZING, HORIZON_ABOVE };

/* The largest |n.q| at which q grazes, for |q| = length. bound(end) is pen_ray_end_bound(p, q) =
 * 16u (|p|_1 + |q|_1), where bound(p) contains 16u |p|_1, and |q|_1 <= 2 |q|. */
static ALWAYS_INLINE double horizon_band(const struct surface *s, double length, bool to_point)
{
    double band = s->grazing_sine * length;
    double rounding = 2 * s->origin.bound + 32 * PEN_U * length;
    return to_point && rounding > band ? rounding : band;
}

/* nq is n.q. */
static ALWAYS_INLINE enum horizon_side horizon_side_of(double nq, double band)
{
    return nq > band ? HORIZON_ABOVE : nq < -band ? HORIZON_BELOW : HORIZON_GRAZING;
}

/* The side of q from p: a vector to a point, or a direction of any length. */
static ALWAYS_INLINE enum horizon_side horizon_side(const struct surface *s, struct pen_vec3 q,
                                                    bool to_point)
{
    return horizon_side_of(pen_dot(s->n, q), horizon_band(s, pen_length(q), to_point));
}

#endif
