/* SPDX-License-Identifier: MIT */
/* Candidates of a disk packet: the relation of one primitive to all rays of the packet.
 * disk_packet_traverse.h finds the primitives in the tree; disk_packet_test.h tests rays against
 * candidates. */
#ifndef PEN_ACCEL_INTERNAL_DISK_CANDIDATE_H
#define PEN_ACCEL_INTERNAL_DISK_CANDIDATE_H

#include "accel/disk_packet.h"

/* Which rays of a packet a primitive blocks. */
enum pen_disk_candidate_verdict {
    PEN_DISK_CANDIDATE_NEVER,  /* no ray intersects it */
    PEN_DISK_CANDIDATE_ALWAYS, /* every ray intersects it, and it is opaque */
    PEN_DISK_CANDIDATE_SOME    /* decided for each ray */
};

/* Computes the packet's derived members. Returns false if its lengths are out of the range in which
 * the margins are valid. */
bool pen_disk_packet_prepare(struct pen_disk_packet *packet, double scale);

/* Makes the candidate of a primitive. With `generic`, the reference tests every ray, for any kind
 * of primitive. */
enum pen_disk_candidate_verdict pen_disk_candidate_make(const struct pen_disk_packet *packet,
                                                        const struct pen_prims *prims,
                                                        uint32_t prim, bool generic,
                                                        struct pen_disk_candidate *candidate);

#endif
