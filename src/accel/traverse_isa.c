/* SPDX-License-Identifier: MIT */
/* The queries and their table, pen_trace_<instruction set>. */
#include "accel/internal/isa.h"

enum { COUNTING = 0 };

#include "accel/internal/disk_packet_test.h"
#include "accel/internal/ray_packet_query.h"
#include "accel/internal/variants.h"

const struct pen_trace_ops ISA_NAMED(pen_trace_, PEN_ISA) = {
    .name = ISA_NAME(PEN_ISA),
    .nearest = nearest,
    .shadow = shadow,
    .nearest_packet = nearest_packet,
    .shadow_packet = shadow_packet,
    .disk_begin = disk_begin,
    .disk_test = disk_test,
    .disk_ray = disk_ray,
};
