/* SPDX-License-Identifier: MIT */
/* What the parts of shadow-ray packets share: packet.c makes candidates of primitives, fan_walk.h
 * finds primitives in the tree, packet_test.h holds rays against candidates. */
#ifndef PEN_ACCEL_INTERNAL_PACKET_CANDIDATE_H
#define PEN_ACCEL_INTERNAL_PACKET_CANDIDATE_H

#include "accel/shadow_packet.h"

/* What a primitive is to the rays of a packet. */
enum pen_candidate_verdict {
    PEN_CANDIDATE_NEVER,  /* none meets it */
    PEN_CANDIDATE_ALWAYS, /* all meet it, and it is opaque */
    PEN_CANDIDATE_SOME    /* the candidate tells */
};

/* Fills in the packet's own members. False if its rays are not fit for it. */
bool pen_packet_prepare(struct pen_shadow_packet *packet, double scale);

/* Makes the candidate of a primitive; with `generic`, one of which each ray is tested by the
 * reference, whatever its kind. */
enum pen_candidate_verdict pen_candidate_make(const struct pen_shadow_packet *packet,
                                              const struct pen_prims *prims, uint32_t prim,
                                              bool generic, struct pen_candidate *candidate);

#endif
