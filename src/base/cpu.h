/* SPDX-License-Identifier: MIT */
/* The processor: its instruction sets, how many cores this process may use, its model. */
#ifndef PEN_BASE_CPU_H
#define PEN_BASE_CPU_H

#include <stdbool.h>

/* The instruction sets that performance-critical files are compiled for, the preferred one last:
 * X(name in capitals, name). BASE is the compiler's baseline. The files *_avx2.c are compiled for
 * AVX2 and FMA.
 * Token pasting makes PEN_ISA_<name in capitals> here, the names of the tables of each room that
 * has such files, as their headers state, and the names that statistics show. */
#define PEN_ISA_LIST(X)                                                                            \
    X(BASE, base)                                                                                  \
    X(AVX2, avx2)

#define PEN_ISA_ENUMERATOR(UPPER, lower) PEN_ISA_##UPPER,
enum pen_isa { PEN_ISA_LIST(PEN_ISA_ENUMERATOR) };
#undef PEN_ISA_ENUMERATOR

#define PEN_ISA_COUNT_ONE(UPPER, lower) +1
enum { PEN_ISA_COUNT = 0 PEN_ISA_LIST(PEN_ISA_COUNT_ONE) };
#undef PEN_ISA_COUNT_ONE

/* The preferred instruction set among those that this processor has. The environment variable
 * PENUMBRA_ISA=base forces the baseline, for tests; the pictures are the same. */
enum pen_isa pen_cpu_isa(void);

/* The name in PEN_ISA_LIST: "base" or "avx2". */
const char *pen_isa_name(enum pen_isa isa);

/* Whether this thread computes in the default arithmetic of IEEE 754: rounding to nearest, with
 * subnormal results and operands not replaced by zero. The function computes to find out, so it
 * covers every register that may change the arithmetic (MXCSR, FPCR). */
bool pen_float_is_default(void);

/* The number of processors that this process may run on, at least 1. */
int pen_cpu_count(void);

/* The processor's model name, or "unknown" if the system does not state it. */
void pen_cpu_model(char *out, int bytes);

#endif
