/* SPDX-License-Identifier: MIT */
/* Code in lanes (math/lanes.h) as functions of arrays, compiled for each instruction set, so that
 * tests compare one lane with many. */
#ifndef TESTS_SUPPORT_LANES_H
#define TESTS_SUPPORT_LANES_H

#include "base/cpu.h"

enum { LANES_TEST_MAX = 8, LANES_TEST_FUNCTIONS = 7 };

/* Arrays are by lane. */
struct lanes_test {
    int lanes;
    /* exp(x), ln(x), pow(x, y), sine and cosine of x in radians, and of x in degrees. */
    void (*functions)(const double *x, const double *y,
                      double out[LANES_TEST_FUNCTIONS][LANES_TEST_MAX]);
};

/* NULL if this processor does not have the instruction set. */
const struct lanes_test *lanes_test_of(enum pen_isa isa);

#endif
