/* SPDX-License-Identifier: MIT */
/* The instruction sets that tests run. */
#ifndef TESTS_SUPPORT_ISA_H
#define TESTS_SUPPORT_ISA_H

#include "base/cpu.h"

/* Returns how many sets of PEN_ISA_LIST this processor has; they are the first ones. The first call
 * prints the missing sets, because tests leave these out. */
int isa_count(void);

/* Makes pen_cpu_isa return this set; then its own choice again. */
void isa_force(int isa);
void isa_release(void);

#endif
