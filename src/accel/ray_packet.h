/* SPDX-License-Identifier: MIT */
/* Packets of rays: the rays of a block of pixels, traced together. They are camera rays, mirrored
 * or transmitted rays, or the shadow rays of many points to one light.
 *
 * The tree is traversed once for all rays whose directions have the same largest axis. The result
 * is the primitives that some ray may meet. Each is tested against the rays, LANES at a time. The
 * answers are those of pen_trace_ops.nearest and .shadow, ray by ray and bit for bit. If the test
 * in lanes is not certain, the scalar test decides. src/accel/README.md describes the steps. */
#ifndef PEN_ACCEL_RAY_PACKET_H
#define PEN_ACCEL_RAY_PACKET_H

#include "geom/prims.h"
#include "geom/ray_array.h"

struct pen_shadow;

enum { PEN_RAY_PACKET_MAX = PEN_RAY_ARRAY_MAX };

/* Rays that start on one primitive. */
struct pen_ray_starts {
    uint32_t prim;
    uint64_t rays;
};

/* Arrays and bits are by ray. */
struct pen_ray_packet {
    /* In. */
    uint64_t live; /* a bit for each ray of the packet */
    struct pen_ray_array rays;
    /* Starts of the rays: pen_ray_packet_start and _start_ray. Packets of rays from the same points
     * share them. */
    const struct pen_origin_surface *origin[PEN_RAY_PACKET_MAX]; /* borrowed */
    double bound[PEN_RAY_PACKET_MAX];                            /* of *origin; -1 in free space */
    bool from_surface;                                           /* some ray starts on a surface */
    int starts_count;
    struct pen_ray_starts starts[PEN_RAY_PACKET_MAX];
    /* nearest_packet: in and out, as the interval and the hit of `nearest`, with tmax INFINITY. */
    struct pen_hit after[PEN_RAY_PACKET_MAX];
    struct pen_hit hit[PEN_RAY_PACKET_MAX];
    /* shadow_packet: all rays go to one light. If to_point, `light` is its position. see_through is
     * as in struct pen_shadow. last_occluder is in and out. `recorded`: the rays that are not
     * blocked but meet primitives that transmit light; their queries[] hold the results of
     * `shadow`. The array is borrowed. */
    struct pen_vec3 light;
    bool to_point;
    const uint8_t *see_through;
    uint32_t last_occluder;
    uint64_t recorded;
    struct pen_shadow *queries;
};

/* Begins the list of starts. */
static inline void pen_ray_packet_start(struct pen_ray_packet *packet)
{
    packet->from_surface = false;
    packet->starts_count = 0;
}

/* Sets the primitive that some rays start on, a bit each; PEN_NO_PRIM: none. Neighbouring rays
 * often start on the same primitive. */
static inline void pen_ray_packet_start_on(struct pen_ray_packet *packet, uint32_t prim,
                                           uint64_t rays)
{
    int k = packet->starts_count;
    packet->from_surface |= prim != PEN_NO_PRIM;
    while (k > 0 && packet->starts[k - 1].prim != prim)
        k--;
    if (k == 0) {
        k = ++packet->starts_count;
        packet->starts[k - 1] = (struct pen_ray_starts){prim, 0};
    }
    packet->starts[k - 1].rays |= rays;
}

/* Sets the start of ray i. */
static inline void pen_ray_packet_start_ray(struct pen_ray_packet *packet, int i,
                                            const struct pen_origin_surface *origin)
{
    packet->origin[i] = origin;
    packet->bound[i] = origin->prim != PEN_NO_PRIM ? origin->bound : -1;
    pen_ray_packet_start_on(packet, origin->prim, UINT64_C(1) << i);
}

#endif
