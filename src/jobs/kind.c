/* SPDX-License-Identifier: MIT */
#include "jobs/internal/kind.h"

#include "jobs/internal/members.h"
#include "jobs/jobs.h"

const char *const pen_job_kinds[] = {
    [PEN_KIND_RENDER] = "render",     [PEN_KIND_BENCHMARK] = "benchmark",
    [PEN_KIND_ACCURACY] = "accuracy", [PEN_KIND_EFFECTS] = "effects",
    [PEN_KIND_EXPLAIN] = "explain",   [PEN_KIND_COUNT] = NULL};

bool pen_job_kind_of_name(const char *name, enum pen_job_kind *kind)
{
    const int i = pen_name_index(name, pen_job_kinds);
    if (i >= 0)
        *kind = (enum pen_job_kind)i;
    return i >= 0;
}
