/* SPDX-License-Identifier: MIT */
/* Vectors of four doubles or eight floats in the compiler's own vector types, which work on any
 * processor. The operations that these types lack are in lanes_base.h and lanes_avx2.h. */
#ifndef PEN_ACCEL_INTERNAL_LANES_H
#define PEN_ACCEL_INTERNAL_LANES_H

#include <stdint.h>

typedef double double4 __attribute__((vector_size(32), aligned(8), may_alias));
typedef int64_t mask4 __attribute__((vector_size(32)));
typedef float float8 __attribute__((vector_size(32), aligned(4), may_alias));
typedef int32_t mask8 __attribute__((vector_size(32)));

/* Lane by lane, a where m is set, else b. */
#define SELECT4(m, a, b) ((double4)(((mask4)(a) & (m)) | ((mask4)(b) & ~(m))))

#define ABS4(x) ((double4)((mask4)(x)&INT64_MAX))
#define ABS8(x) ((float8)((mask8)(x)&INT32_MAX))

#endif
