/* SPDX-License-Identifier: MIT */
/* A test door: builds structures that keep chosen kinds of primitives in generic blocks, like a
 * kind that has no block of its own. */
#ifndef PEN_ACCEL_INTERNAL_BUILD_GENERIC_H
#define PEN_ACCEL_INTERNAL_BUILD_GENERIC_H

#include "accel/accel.h"

/* As pen_accel_build; generic_kinds has bit 1 << kind for each enum pen_prim_kind that goes into
 * generic blocks. */
struct pen_accel *pen_accel_build_generic(const struct pen_prims *prims, enum pen_accelerator kind,
                                          unsigned generic_kinds, struct pen_arena *arena,
                                          struct pen_status *st);

#endif
