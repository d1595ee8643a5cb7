/* SPDX-License-Identifier: MIT */
/* What processor this is, and which compiled variant of the hot files it may enter. */
#ifndef PEN_BASE_CPU_H
#define PEN_BASE_CPU_H

#include <stdbool.h>

enum pen_isa {
    PEN_ISA_BASE, /* the compiler's baseline */
    PEN_ISA_AVX2  /* AVX2 and FMA: the *_avx2.c files */
};

/* The best variant this processor runs. The environment variable PENUMBRA_ISA=base forces the
 * baseline, for tests; the pictures are the same. */
enum pen_isa pen_cpu_isa(void);

/* "base" or "avx2". */
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
