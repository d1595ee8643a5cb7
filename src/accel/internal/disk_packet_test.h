/* SPDX-License-Identifier: MIT */
/* Tests the rays of a disk packet against its candidates, LANES rays at a time. Traces the rays
 * that need the scalar fallback. */
#ifndef PEN_ACCEL_INTERNAL_DISK_PACKET_TEST_H
#define PEN_ACCEL_INTERNAL_DISK_PACKET_TEST_H

#include "accel/internal/disk_packet_order.h"
#include "accel/internal/disk_packet_traverse.h"
#include "accel/internal/traverse_query.h"

/* struct verdict for a whole packet, a bit for each ray. */
struct verdicts {
    uint64_t hit, miss, once, twice;
};

/* Classifies rays 0 ... n - 1. Skips groups of LANES rays that are all in `done`. */
static inline void classify_rays(const struct pen_disk_candidate *candidate, const double *a,
                                 const double *b, int n, uint64_t done, struct verdicts *v)
{
    *v = (struct verdicts){0, 0, 0, 0};
    for (int i = 0; i < n; i += LANES) {
        if ((done >> i & LANES_ALL) == LANES_ALL)
            continue;
        const struct disk_points p = {lanes_load(a + i), lanes_load(b + i)};
        const struct verdict out = classify(candidate, p);
        v->hit |= (uint64_t)lane_mask_bits(out.hit) << i;
        v->miss |= (uint64_t)lane_mask_bits(out.miss) << i;
        if (candidate->opaque)
            continue;
        v->once |= (uint64_t)lane_mask_bits(out.once) << i;
        v->twice |= (uint64_t)lane_mask_bits(out.twice) << i;
    }
}

/* Tests opaque candidates. Returns the blocked rays. */
static inline uint64_t test_opaque(struct pen_disk_packet *packet, const double *a, const double *b,
                                   int n, uint64_t all)
{
    uint64_t blocked = 0;
    for (int i = 0; i < packet->candidate_count && blocked != all; i++) {
        struct pen_disk_candidate *candidate = &packet->candidate[i];
        struct verdicts v;
        candidate->fallback = all;
        if (!candidate->opaque || candidate->kind == PEN_DISK_CANDIDATE_FALLBACK)
            continue;
        classify_rays(candidate, a, b, n, blocked | ~all, &v);
        blocked |= v.hit & all;
        candidate->fallback = all & ~v.hit & ~v.miss;
        if (v.hit == all)
            packet->last_occluder = candidate->prim;
    }
    return blocked;
}

/* Tests candidates that transmit light, for the rays in `open`. Returns the undecided rays. *many:
 * the rays with more than two intersections in all, for which the order of the products matters.
 * `one` and `two` are a counter of two bits per ray, `more` its overflow. */
static inline uint64_t test_transmissive(struct pen_disk_packet *packet, const double *a,
                                         const double *b, int n, uint64_t open, uint64_t *many)
{
    uint64_t one = 0, two = 0, more = 0, fallback = 0;
    for (int i = 0; i < packet->transmissive_count; i++) {
        struct pen_disk_candidate *candidate = &packet->candidate[packet->transmissive[i]];
        struct verdicts v = {0, 0, 0, 0};
        if (candidate->kind != PEN_DISK_CANDIDATE_FALLBACK)
            classify_rays(candidate, a, b, n, ~open, &v);
        candidate->once = v.once & open;
        candidate->twice = v.twice & open;
        candidate->fallback = open & ~(v.miss | v.once | v.twice);
        uint64_t carry = one & candidate->once;
        one ^= candidate->once;
        more |= (two & carry) | ((two ^ carry) & candidate->twice);
        two = two ^ carry ^ candidate->twice;
        fallback |= candidate->fallback;
    }
    *many = more | (one & two);
    return fallback;
}

static uint64_t disk_test(struct pen_disk_packet *packet, const double a[PEN_DISK_RAYS],
                          const double b[PEN_DISK_RAYS], int n, uint64_t *fallback)
{
    uint64_t all = n < 64 ? (UINT64_C(1) << n) - 1 : UINT64_MAX, many;
    uint64_t blocked = test_opaque(packet, a, b, n, all);
    *fallback = packet->in_sequence = 0;
    if (blocked == all)
        return blocked;
    *fallback = test_transmissive(packet, a, b, n, all & ~blocked, &many);
    for (int i = 0; i < packet->candidate_count; i++)
        if (packet->candidate[i].opaque || packet->candidate[i].kind == PEN_DISK_CANDIDATE_FALLBACK)
            *fallback |= packet->candidate[i].fallback;
    *fallback &= ~blocked;
    if (many & ~*fallback) {
        packet->in_sequence = order_intersections(packet, a, b, many & ~*fallback);
        *fallback |= many & ~packet->in_sequence;
    }
    for (int i = 0; *fallback && i < packet->transmissive_count; i++) {
        struct pen_disk_candidate *candidate = &packet->candidate[packet->transmissive[i]];
        candidate->fallback |= *fallback & (candidate->once | candidate->twice);
    }
    return blocked;
}

static bool disk_ray(const struct pen_accel *accel, const struct pen_disk_packet *packet,
                     const struct pen_ray *ray, int i, struct pen_shadow *query)
{
    struct trace trace;
    trace_begin_shadow(&trace, accel, ray, packet->origin, query);
    for (int k = 0; k < packet->candidate_count; k++) {
        const struct pen_disk_candidate *candidate = &packet->candidate[k];
        if (!(candidate->fallback >> i & 1))
            continue;
        if (candidate->by_reference ? test_reference(&trace, candidate->prim, true)
                                    : test_prim(&trace, candidate->prim, true))
            return true;
    }
    return false;
}

#endif
