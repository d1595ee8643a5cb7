/* SPDX-License-Identifier: MIT */
/* The processor: its instruction sets, the number of cores that this process may use, its model. */
#ifndef PEN_BASE_CPU_H
#define PEN_BASE_CPU_H

#include <stdbool.h>

/* The instruction sets for which performance-critical files are compiled:
 *   X(NAME, name, whether this processor runs it, whether that is faster than those before)
 * BASE is the compiler's baseline; a processor that runs one set runs the sets before it. The
 * Makefile reads the names here and has flags for each. It compiles each file *_isa.c once for each
 * set, with PEN_ISA defined as the name. Token pasting makes PEN_ISA_<NAME> here, and the names of
 * the tables of each module with such files, as their headers state. Statistics show these names
 * too.
 *
 * The first processors with AVX-512 lower their clock while they use it, a Cascade Lake Xeon by 12
 * % as measured. That cancels the gain of wider vectors. AVX512_VBMI2 identifies later processors
 * (from Ice Lake and Zen 4 on). */
#define PEN_ISA_LIST(X)                                                                            \
    X(BASE, base, true, true)                                                                      \
    X(AVX2, avx2, PEN_CPU_HAS("avx2") && PEN_CPU_HAS("fma"), true)                                 \
    X(AVX512, avx512,                                                                              \
      PEN_CPU_HAS("avx2") && PEN_CPU_HAS("fma") && PEN_CPU_HAS("avx512f") &&                       \
          PEN_CPU_HAS("avx512vl") && PEN_CPU_HAS("avx512bw") && PEN_CPU_HAS("avx512dq"),           \
      PEN_CPU_HAS("avx512vbmi2"))

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

/* Whether this processor, and its operating system, run an instruction set. */
bool pen_cpu_runs(enum pen_isa isa);

/* The fastest instruction set of this processor. The environment variable PENUMBRA_ISA=NAME selects
 * that set, or the last one before it that the processor runs. The pictures are the same. */
enum pen_isa pen_cpu_isa(void);

/* The name in PEN_ISA_LIST: "base", "avx2" or "avx512". */
const char *pen_isa_name(enum pen_isa isa);

/* Whether this thread computes in the default arithmetic of IEEE 754: rounding to nearest, with
 * subnormal results and operands not replaced by zero. The function tests this by computing, so it
 * covers every register that may change the arithmetic (MXCSR, FPCR). */
bool pen_float_is_default(void);

/* The number of processors that this process may run on, at least 1. */
int pen_cpu_count(void);

/* The processor's model name, or "unknown" if the system does not state it. */
void pen_cpu_model(char *out, int bytes);

#endif
