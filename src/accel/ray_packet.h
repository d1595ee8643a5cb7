/* SPDX-License-Identifier: MIT */
/* Packets of rays: the rays of a block of pixels, traced together. They are rays from the camera,
 * mirrored or transmitted ones, or the shadow rays of many points to one light.
 *
 * The tree is traversed once for all rays whose directions have the same largest axis. It gives the
 * primitives that some ray may meet, each of which is tested against the rays, LANES at a time. The
 * answers are those of pen_trace_ops.nearest and .shadow, ray by ray and bit for bit: whatever the
 * test in lanes does not decide for sure is asked of the scalar test. src/accel/README.md describes
 * the steps. */
#ifndef PEN_ACCEL_RAY_PACKET_H
#define PEN_ACCEL_RAY_PACKET_H

#include "geom/prims.h"

struct pen_shadow;

enum { PEN_RAY_PACKET_MAX = 64 };

struct pen_ray_packet {
    /* In. Borrowed. */
    int count;
    const struct pen_ray *ray[PEN_RAY_PACKET_MAX];
    const struct pen_origin_surface *origin[PEN_RAY_PACKET_MAX];
    /* nearest_packet: in and out by ray, as the interval and the hit of `nearest`, with tmax
     * INFINITY. */
    struct pen_hit after[PEN_RAY_PACKET_MAX];
    struct pen_hit hit[PEN_RAY_PACKET_MAX];
    /* shadow_packet: queries as `shadow` takes them, all to one light. `light` is its position if
     * the queries are to_point. last_occluder is in and out, and that of the queries is not used.
     */
    struct pen_shadow *query[PEN_RAY_PACKET_MAX];
    struct pen_vec3 light;
    uint32_t last_occluder;
};

#endif
