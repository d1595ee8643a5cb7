/* SPDX-License-Identifier: MIT */
#include "jobs/internal/kind.h"

#include <string.h>

#include "jobs/jobs.h"

const char *const pen_job_kinds[] = {
    [PEN_KIND_RENDER] = "render",     [PEN_KIND_BENCHMARK] = "benchmark",
    [PEN_KIND_ACCURACY] = "accuracy", [PEN_KIND_EFFECTS] = "effects",
    [PEN_KIND_EXPLAIN] = "explain",   [PEN_KIND_COUNT] = NULL};

bool pen_job_kind_of_name(const char *name, enum pen_job_kind *kind)
{
    for (int i = 0; name && i < PEN_KIND_COUNT; i++) {
        if (strcmp(name, pen_job_kinds[i]) != 0)
            continue;
        *kind = (enum pen_job_kind)i;
        return true;
    }
    return false;
}
