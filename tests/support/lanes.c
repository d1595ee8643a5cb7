/* SPDX-License-Identifier: MIT */
#include "support/lanes.h"

#include <stddef.h>

#define DECLARE(UPPER, lower, ...) extern const struct lanes_test lanes_test_##lower;
PEN_ISA_LIST(DECLARE)

const struct lanes_test *lanes_test_of(enum pen_isa isa)
{
#define ROW(UPPER, lower, ...) [PEN_ISA_##UPPER] = &lanes_test_##lower,
    static const struct lanes_test *const all[] = {PEN_ISA_LIST(ROW)};
    return pen_cpu_runs(isa) ? all[isa] : NULL;
}
