/* SPDX-License-Identifier: MIT */
/* What the parts of fans share: fan.c makes gates of bodies, fan_walk.h finds bodies in the tree,
 * fan_look.h holds rays against gates. */
#ifndef PEN_ACCEL_INTERNAL_FAN_PREPARE_H
#define PEN_ACCEL_INTERNAL_FAN_PREPARE_H

#include "accel/fan.h"

/* What a body is to the rays of a fan. */
enum pen_gate_say {
    PEN_GATE_NEVER,  /* none meets it */
    PEN_GATE_ALWAYS, /* all meet it, and it is opaque */
    PEN_GATE_SOME    /* the gate tells */
};

/* Fills in the fan's own members. False if its rays are not fit for it. */
bool pen_fan_prepare(struct pen_fan *fan, double scale);

/* Makes the gate of a body. */
enum pen_gate_say pen_gate_make(const struct pen_fan *fan, const struct pen_prims *prims,
                                uint32_t prim, struct pen_gate *gate);

#endif
