/* SPDX-License-Identifier: MIT */
/* Building: which builder makes which kind of tree. */
#include "accel.h"
#include "pen/base/clock.h"

const struct pen_hit pen_after_start = {0, PEN_NO_PRIM, UINT8_MAX};

struct pen_accel *pen_accel_build(const struct pen_prims *prims, enum pen_accelerator kind,
                                  struct pen_arena *arena, struct pen_status *st)
{
    if (kind != PEN_ACCEL_NONE && kind != PEN_ACCEL_AUTO) {
        pen_fail(st, PEN_UNSUPPORTED, "this accelerator is known, not supported yet");
        return NULL;
    }
    struct pen_accel *accel = pen_arena_alloc(arena, 1, sizeof *accel);
    if (!accel) {
        pen_fail(st, PEN_NO_MEMORY, "not enough memory for the acceleration structure");
        return NULL;
    }
    accel->prims = prims;
    accel->stats = (struct pen_accel_stats){.kind = kind, .sah_cost = prims->count};
    return accel;
}

const struct pen_accel_stats *pen_accel_get_stats(const struct pen_accel *accel)
{
    return &accel->stats;
}
