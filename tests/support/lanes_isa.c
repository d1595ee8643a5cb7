/* SPDX-License-Identifier: MIT */
/* Compiled once for each instruction set, PEN_ISA (base/cpu.h). */
#include "support/lanes.h"

#include "math/lanes_fn.h"

_Static_assert((int)LANES <= (int)LANES_TEST_MAX, "arrays are as long as the widest vector");

static void functions(const double *x, const double *y,
                      double out[LANES_TEST_FUNCTIONS][LANES_TEST_MAX])
{
    const lanes a = lanes_load(x);
    lanes sine, cosine;
    lanes_store(out[0], lanes_exp(a));
    lanes_store(out[1], lanes_ln(a));
    lanes_store(out[2], lanes_pow(a, lanes_load(y)));
    lanes_sincos(a, &sine, &cosine);
    lanes_store(out[3], sine);
    lanes_store(out[4], cosine);
    lanes_sincos_deg(a, &sine, &cosine);
    lanes_store(out[5], sine);
    lanes_store(out[6], cosine);
}

#define NAME_OF_ISA(isa) NAME_OF_TOKEN(isa)
#define NAME_OF_TOKEN(token) lanes_test_##token
extern const struct lanes_test NAME_OF_ISA(PEN_ISA);
const struct lanes_test NAME_OF_ISA(PEN_ISA) = {.lanes = LANES, .functions = functions};
