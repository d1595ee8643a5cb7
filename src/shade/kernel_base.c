/* SPDX-License-Identifier: MIT */
/* The kernels for any processor. */
#define KERNEL_ISA base
#include "shade/internal/kernel_table.h"
