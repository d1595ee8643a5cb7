/* SPDX-License-Identifier: MIT */
/* The processor: its instruction sets, how many cores this process may use, its model. */
#ifndef PEN_BASE_CPU_H
#define PEN_BASE_CPU_H

#include <stdbool.h>

/* The instruction sets that performance-critical files are compiled for, the preferred one last:
 *   X(NAME, name, whether this processor runs it)
 * BASE is the compiler's baseline. The Makefile reads the names here, has flags for each, and
 * compiles each file *_isa.c once for each, with PEN_ISA defined as the name. Token pasting makes
 * PEN_ISA_<NAME> here, the names of the tables of each room that has such files, as their headers
 * state, and the names that statistics show. */
#define PEN_ISA_LIST(X)                                                                            \
    X(BASE, base, true)                                                                            \
    X(AVX2, avx2, PEN_CPU_HAS("avx2") && PEN_CPU_HAS("fma"))

#if defined(__x86_64__) && defined(__GNUC__)
#define PEN_CPU_HAS(feature) __builtin_cpu_supports(feature)
#else
#define PEN_CPU_HAS(feature) false
#endif

#define PEN_ISA_ENUMERATOR(UPPER, ...) PEN_ISA_##UPPER,
enum pen_isa { PEN_ISA_LIST(PEN_ISA_ENUMERATOR) };
#undef PEN_ISA_ENUMERATOR

#define PEN_ISA_COUNT_ONE(...) +1
enum { PEN_ISA_COUNT = 0 PEN_ISA_LIST(PEN_ISA_COUNT_ONE) };
#undef PEN_ISA_COUNT_ONE

/* The preferred instruction set among those that this processor has. The environment variable
 * PENUMBRA_ISA=NAME, for tests, rules out those after that one in the list; the pictures are the
 * same. */
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
