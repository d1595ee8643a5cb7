/* SPDX-License-Identifier: MIT */
/* Inside of the acceleration structure, shared by builders and traversals. */
#ifndef PEN_SRC_ACCEL_ACCEL_H
#define PEN_SRC_ACCEL_ACCEL_H

#include "pen/accel/accel.h"

struct pen_accel {
    const struct pen_prims *prims;
    struct pen_accel_stats stats;
};

#endif
