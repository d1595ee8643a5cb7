/* SPDX-License-Identifier: MIT */
/* Queries that count their tests, for any processor. */
#define TRACE_ISA base
#include "accel/internal/isa_base.h"
#include "accel/internal/traverse_count_table.h"
