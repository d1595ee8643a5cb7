/* SPDX-License-Identifier: MIT */
/* The instruction sets that tests run. */
#ifndef TESTS_SUPPORT_ISA_H
#define TESTS_SUPPORT_ISA_H

#include "base/cpu.h"

/* How many of PEN_ISA_LIST this processor has: the first ones. The first call prints which it does
 * not have, so that tests that leave these out say so. */
int isa_count(void);

/* Makes pen_cpu_isa return this one, and then its own choice again. */
void isa_force(int isa);
void isa_release(void);

#endif
