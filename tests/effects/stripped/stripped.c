/* SPDX-License-Identifier: MIT */
/* The stripped kernels in one file, as the compiled ones are in kernel_isa.c, so that the compiler
 * inlines by the same rules: what several kernels call may remain a function. */
#include "effects/stripped/stripped.h"

#include "effects/stripped/kernel_hard.h"
#include "effects/stripped/kernel_mirror.h"
#include "effects/stripped/kernel_none.h"
#include "effects/stripped/kernel_soft.h"
