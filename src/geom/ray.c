/* SPDX-License-Identifier: MIT */
/* Making one ray: geom/ray_lanes.h with one lane. */
#include "geom/ray_lanes.h"

_Static_assert(LANES == 1, "this file is compiled for the base instruction set");

bool pen_ray_make(struct pen_ray *ray, struct pen_vec3 o, struct pen_vec3 d)
{
    return lane_mask_bits(lanes_ray_make(&ray, lanes3_splat(o), lanes3_splat(d)));
}
