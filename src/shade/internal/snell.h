/* SPDX-License-Identifier: MIT */
/* Refraction at a smooth surface between two dielectrics: Snell's law and Fresnel's equations for
 * unpolarised light, LANES at a time.
 *
 * Let e = n1 / n2, c the cosine and s the sine of the incident angle, and t = sqrt(1 - e^2 s^2) the
 * cosine of the refracted angle. The direction is e v + (e c - t) n, and the amplitudes are (e c -
 * t) / (e c + t) and (c - e t) / (c + e t). Some differences cancel if the indices are nearly equal
 * or the angles small, so they are not computed directly. Each is multiplied by the sum of the same
 * two numbers: e^2 c^2 - t^2 = e^2 - 1, c^2 - e^2 t^2 = (1 - e^2) (c^2 - e^2 s^2), and e^2 - 1 =
 * (n1 - n2) (n1 + n2) / n2^2. And t^2 is computed as c^2 - (e^2 - 1) s^2, since near grazing s is
 * too close to 1. So all are exact to a few u for an angle that differs from the given one by a few
 * u. Total reflection begins at t^2 = 0, which counts as total. One test decides it for the
 * refracted ray and for its weight. */
#ifndef PEN_SHADE_INTERNAL_SNELL_H
#define PEN_SHADE_INTERNAL_SNELL_H

#include "math/lanes.h"

struct refracted {
    lane_mask total; /* no ray is refracted */
    lanes fresnel;   /* the reflected share: 1 for total reflection */
    struct lanes3 d; /* of the refracted ray; unit to a few u */
};

/* Refracts rays. n: unit normal towards the side from which the ray comes; v: the ray's direction,
 * unit; nv = n.v <= 0; n1, n2: the indices on that side and on the other side. */
static inline __attribute__((always_inline)) struct refracted
lanes_refract(struct lanes3 n, struct lanes3 v, lanes nv, lanes n1, lanes n2)
{
    const lanes one = lanes_splat(1), zero = lanes_splat(0);
    const lanes e = n1 / n2, c = -nv, s = lanes3_length(lanes3_cross(n, v));
    const lanes difference = (n1 - n2) / n2 * ((n1 + n2) / n2); /* e^2 - 1 */
    const lanes square = c * c - difference * (s * s); /* squared cosine of the refracted angle */
    const lane_mask some = lanes_less(zero, square);
    const lanes t = lanes_sqrt(lanes_select(some, square, zero));
    const lanes across = e * c + t, along = c + e * t;
    const lanes a = difference / (across * across);
    const lanes b = difference * ((c - e * s) * (c + e * s)) / (along * along);
    const lanes share = 0.5 * (a * a + b * b);
    return (struct refracted){
        .total = lane_mask_not(some),
        .fresnel = lanes_select(some, lanes_select(lanes_less(share, one), share, one), one),
        .d = lanes3_along(lanes3_scale(v, e), n, difference / across),
    };
}

#endif
