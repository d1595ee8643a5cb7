/* SPDX-License-Identifier: MIT */
/* Doors for tests and benchmarks: structures that pen_accel_build would not make. */
#ifndef PEN_ACCEL_INTERNAL_TEST_DOORS_H
#define PEN_ACCEL_INTERNAL_TEST_DOORS_H

#include "accel/accel.h"

/* As pen_accel_build, but keeps chosen kinds of primitives in generic blocks, like a kind that has
 * no block of its own: generic_kinds has bit 1 << kind for each such enum pen_prim_kind.
 * PEN_ACCEL_AUTO chooses PEN_AUTO_PACKETS. */
struct pen_accel *pen_accel_build_generic(const struct pen_prims *prims, enum pen_accelerator kind,
                                          unsigned generic_kinds, struct pen_arena *arena,
                                          struct pen_status *st);

/* Builds PEN_ACCEL_AUTO with this choice, whatever it is expected to cost. Without finite
 * primitives there is no tree, and all choices are the same. */
struct pen_accel *pen_accel_build_choice(const struct pen_prims *prims, enum pen_auto_choice choice,
                                         struct pen_arena *arena, struct pen_status *st);

#endif
