/* SPDX-License-Identifier: MIT */
/* Queries for any processor. */
#define TRACE_ISA base
#include "accel/internal/isa_base.h"
#include "accel/internal/traverse_table.h"
