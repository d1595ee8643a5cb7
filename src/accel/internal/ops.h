/* SPDX-License-Identifier: MIT */
/* The tables of the compiled variants. */
#ifndef PEN_ACCEL_INTERNAL_OPS_H
#define PEN_ACCEL_INTERNAL_OPS_H

#include "accel/accel.h"

extern const struct pen_trace_ops pen_trace_base, pen_trace_count_base;

/* NULL where the build lacks AVX2. */
const struct pen_trace_ops *pen_trace_avx2(void);
const struct pen_trace_ops *pen_trace_count_avx2(void);

#endif
