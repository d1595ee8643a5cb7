/* SPDX-License-Identifier: MIT */
/* The order in which rays of a disk packet intersect primitives that transmit light. The ray's
 * transmittance is a product of kt in that order. The order matters, because a rounded product of
 * more than two factors depends on it. */
#ifndef PEN_ACCEL_INTERNAL_DISK_PACKET_ORDER_H
#define PEN_ACCEL_INTERNAL_DISK_PACKET_ORDER_H

#include "accel/internal/disk_packet_classify.h"

/* The intersections of LANES rays with a candidate that transmits light, and the error of their t.
 * A ray that the verdict has in `twice` intersects it at lo and hi. A ray in `once` does so at hi
 * if it is in `at_hi`, else at lo. */
struct lane_intersections {
    lane_mask at_hi;
    lanes lo, hi, error;
};

static inline struct lane_intersections
flat_intersections(const struct pen_disk_candidate *candidate, struct disk_points p)
{
    const lanes facing = line_at(&candidate->facing, p), t = candidate->height / facing;
    return (struct lane_intersections){.at_hi = lane_mask_of(0),
                                       .lo = t,
                                       .hi = t,
                                       .error = candidate->facing.band * (1 + t) / facing};
}

static inline struct lane_intersections
candidate_intersections(const struct pen_disk_candidate *candidate, struct disk_points p)
{
    const bool sphere = candidate->kind == PEN_DISK_CANDIDATE_SPHERE_AHEAD ||
                        candidate->kind == PEN_DISK_CANDIDATE_SPHERE;
    if (!sphere && candidate->kind != PEN_DISK_CANDIDATE_CYLINDER)
        return flat_intersections(candidate, p);
    const struct chord c = sphere ? sphere_chord(candidate, p) : cylinder_chord(candidate, p);
    return (struct lane_intersections){.at_hi = c.ends.hi,
                                       .lo = c.lo,
                                       .hi = c.hi,
                                       .error = 0x1p-20 * (1 + lanes_abs(c.lo) + lanes_abs(c.hi))};
}

/* The intersections of one ray, sorted by t. */
struct intersection_list {
    int count;
    bool overflow;
    struct intersection {
        double t, error;
        uint8_t candidate;
    } at[PEN_DISK_SEQUENCE];
};

static inline void add_intersection(struct intersection_list *list, struct intersection x)
{
    int at = list->count;
    if (at == PEN_DISK_SEQUENCE) {
        list->overflow = true;
        return;
    }
    for (; at > 0 && list->at[at - 1].t > x.t; at--)
        list->at[at] = list->at[at - 1];
    list->at[at] = x;
    list->count++;
}

/* Adds the intersections with candidate `number` of the rays from i on. `rays` has a bit for each
 * ray to include. */
static inline void add_intersections(const struct pen_disk_packet *packet, uint8_t number, int i,
                                     struct disk_points p, unsigned rays,
                                     struct intersection_list list[LANES])
{
    const struct pen_disk_candidate *candidate = &packet->candidate[number];
    const struct lane_intersections x = candidate_intersections(candidate, p);
    for (; rays; rays &= rays - 1) {
        const int lane = __builtin_ctz(rays);
        const bool twice = candidate->twice >> (i + lane) & 1;
        const bool at_hi = lane_mask_bits(x.at_hi) >> lane & 1;
        const double error = lanes_at(x.error, lane);
        if (twice || !at_hi)
            add_intersection(&list[lane],
                             (struct intersection){lanes_at(x.lo, lane), error, number});
        if (twice || at_hi)
            add_intersection(&list[lane],
                             (struct intersection){lanes_at(x.hi, lane), error, number});
    }
}

/* Makes the sequence of ray i of the packet. Returns false if rounding could change it, or if it is
 * too long. */
static inline bool make_sequence(struct pen_disk_packet *packet, int i,
                                 const struct intersection_list *list)
{
    bool sure = !list->overflow;
    for (int k = 0; k < list->count; k++) {
        const struct intersection *x = &list->at[k];
        packet->sequence[i][k] = x->candidate;
        if (k > 0 && x[-1].candidate != x->candidate)
            sure &= x->t - x[-1].t > x->error + x[-1].error;
    }
    packet->sequence_count[i] = (uint8_t)list->count;
    return sure;
}

/* Finds the order in which some rays, all decided, intersect candidates that transmit light.
 * Returns the rays whose order is certain. */
static inline uint64_t order_intersections(struct pen_disk_packet *packet, const double *a,
                                           const double *b, uint64_t rays)
{
    uint64_t sure = 0;
    for (int i = 0; i < PEN_DISK_RAYS; i += LANES) {
        const unsigned group = (unsigned)(rays >> i) & LANES_ALL;
        struct intersection_list list[LANES];
        if (!group)
            continue;
        for (int lane = 0; lane < LANES; lane++)
            list[lane].count = list[lane].overflow = 0;
        for (int k = 0; k < packet->transmissive_count; k++) {
            const struct pen_disk_candidate *c = &packet->candidate[packet->transmissive[k]];
            const unsigned met = (unsigned)((c->once | c->twice) >> i) & group;
            if (met)
                add_intersections(packet, packet->transmissive[k], i,
                                  (struct disk_points){lanes_load(a + i), lanes_load(b + i)}, met,
                                  list);
        }
        for (unsigned left = group; left; left &= left - 1) {
            const int lane = __builtin_ctz(left);
            sure |= (uint64_t)make_sequence(packet, i + lane, &list[lane]) << (i + lane);
        }
    }
    return sure;
}

#endif
