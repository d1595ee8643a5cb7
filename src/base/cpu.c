/* SPDX-License-Identifier: MIT */
/* Asks the compiler's runtime, the scheduler and /proc about the processor. */
#include "base/cpu.h"

#include <sched.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/utf8.h"

bool pen_cpu_runs(enum pen_isa isa)
{
#define RUNS(UPPER, lower, runs, ...)                                                              \
    if (isa == PEN_ISA_##UPPER)                                                                    \
        return runs;
    PEN_ISA_LIST(RUNS)
#undef RUNS
    return false;
}

enum pen_isa pen_cpu_isa(void)
{
    const char *wanted = getenv("PENUMBRA_ISA");
    enum pen_isa best = PEN_ISA_BASE;
#define TRY(UPPER, lower, runs, faster)                                                            \
    {                                                                                              \
        const bool is_wanted = wanted && strcmp(wanted, #lower) == 0;                              \
        if ((runs) && ((faster) || is_wanted))                                                     \
            best = PEN_ISA_##UPPER;                                                                \
        if (is_wanted)                                                                             \
            return best;                                                                           \
    }
    PEN_ISA_LIST(TRY)
#undef TRY
    return best;
}

bool pen_float_is_default(void)
{
    static const volatile double one = 1, little = 0x1p-60, least = 0x1p-1022,
                                 subnormal = 0x1p-1050;
    volatile double up = one + little, down = one - little, below = -one - little;
    volatile double result = least * 0.5, operand = subnormal * 0x1p100;
    return up == one && down == one && below == -one && result != 0 && operand != 0;
}

const char *pen_isa_name(enum pen_isa isa)
{
#define NAME(UPPER, lower, ...) [PEN_ISA_##UPPER] = #lower,
    static const char *const name[PEN_ISA_COUNT] = {PEN_ISA_LIST(NAME)};
#undef NAME
    return name[isa];
}

int pen_cpu_count(void)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof set, &set) == 0 && CPU_COUNT(&set) > 0)
        return CPU_COUNT(&set);
    /* There are more processors than a cpu_set_t holds. */
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (int)online : 1;
}

void pen_cpu_model(char *out, int bytes)
{
    if (bytes <= 0)
        return;
    pen_utf8_copy(out, (size_t)bytes, "unknown");
    FILE *file = fopen("/proc/cpuinfo", "re");
    if (!file)
        return;
    char line[512];
    while (fgets(line, sizeof line, file)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon)
            continue;
        line[strcspn(line, "\n")] = '\0';
        pen_utf8_copy(out, (size_t)bytes, colon + 1 + strspn(colon + 1, " \t"));
        break;
    }
    fclose(file);
}
