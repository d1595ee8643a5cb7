/* SPDX-License-Identifier: MIT */
#include "support/isa.h"

#include <stdio.h>
#include <stdlib.h>

int isa_count(void)
{
    static int count;
    if (count > 0)
        return count;
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++) {
        if (pen_cpu_runs((enum pen_isa)isa))
            count = isa + 1;
        else
            printf("not on this processor: %s\n", pen_isa_name((enum pen_isa)isa));
    }
    return count;
}

void isa_force(int isa)
{
    setenv("PENUMBRA_ISA", pen_isa_name((enum pen_isa)isa), 1);
}

void isa_release(void)
{
    unsetenv("PENUMBRA_ISA");
}
