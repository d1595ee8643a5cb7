/* SPDX-License-Identifier: MIT */
/* Which compiled variant answers queries. */
#include "ops.h"

const struct pen_trace_ops *pen_trace_ops_get(enum pen_isa isa)
{
    const struct pen_trace_ops *avx2 = isa == PEN_ISA_AVX2 ? pen_trace_avx2() : NULL;
    return avx2 ? avx2 : &pen_trace_base;
}
