/* SPDX-License-Identifier: MIT */
/* Queries for processors with AVX2 and FMA. */
#define TRACE_ISA avx2
#include "accel/internal/isa_avx2.h"
#include "accel/internal/traverse_table.h"
