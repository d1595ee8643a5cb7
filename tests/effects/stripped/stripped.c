/* SPDX-License-Identifier: MIT */
/* The stripped kernels in one file, like the compiled ones in kernel_isa.c. So the compiler inlines
 * by the same rules: a function that several kernels call may remain a function. */
#include "effects/stripped/stripped.h"

#include "effects/stripped/kernel_hard.h"
#include "effects/stripped/kernel_mirror.h"
#include "effects/stripped/kernel_none.h"
#include "effects/stripped/kernel_soft.h"
