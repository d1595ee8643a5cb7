/* SPDX-License-Identifier: MIT */
/* Functions for tests and benchmarks: structures that pen_accel_build would not make. */
#ifndef PEN_ACCEL_INTERNAL_TEST_DOORS_H
#define PEN_ACCEL_INTERNAL_TEST_DOORS_H

#include "accel/accel.h"

/* As pen_accel_build, but packs some kinds of primitives in generic blocks, as if they had no block
 * of their own. generic_kinds has bit 1 << kind for each such enum pen_prim_kind. PEN_ACCEL_AUTO
 * chooses PEN_AUTO_PACKETS. */
struct pen_accel *pen_accel_build_generic(const struct pen_prims *prims, enum pen_accelerator kind,
                                          unsigned generic_kinds, struct pen_arena *arena,
                                          struct pen_status *st);

/* Builds PEN_ACCEL_AUTO with this choice, even if another one has a smaller expected time. Without
 * finite primitives there is no tree, and all choices are the same. */
struct pen_accel *pen_accel_build_choice(const struct pen_prims *prims, enum pen_auto_choice choice,
                                         struct pen_arena *arena, struct pen_status *st);

#endif
