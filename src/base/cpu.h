/* SPDX-License-Identifier: MIT */
/* What processor this is, and which compiled variant of the hot files it may enter. */
#ifndef PEN_BASE_CPU_H
#define PEN_BASE_CPU_H

#include <stdbool.h>

/* The instruction sets that hot files are compiled for, in order of preference: X(name in capitals,
 * name). BASE is the compiler's baseline. The files *_avx2.c are compiled for AVX2 and FMA.
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

/* The best variant this processor runs. The environment variable PENUMBRA_ISA=base forces the
 * baseline, for tests; the pictures are the same. */
enum pen_isa pen_cpu_isa(void);

/* The name in PEN_ISA_LIST: "base" or "avx2". */
const char *pen_isa_name(enum pen_isa isa);

/* Whether this thread's arithmetic is IEEE 754's default: it rounds to nearest, and neither flushes
 * subnormal results to zero nor takes subnormal operands for it. Found out by computing, so it
 * holds for whatever way the processor has to change that (MXCSR, FPCR). */
bool pen_float_is_default(void);

/* Processors this process may run on, at least 1. */
int pen_cpu_count(void);

/* The processor's model name, "unknown" if the system does not tell. */
void pen_cpu_model(char *out, int bytes);

#endif
