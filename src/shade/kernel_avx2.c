/* SPDX-License-Identifier: MIT */
/* The kernels for processors with AVX2 and FMA. */
#define KERNEL_ISA avx2
#include "shade/internal/kernel_table.h"
