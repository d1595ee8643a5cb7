/* SPDX-License-Identifier: MIT */
/* The kinds of jobs. All kinds but renders are studies: one batch, a report, and no picture. Only
 * POST /v1/explain makes jobs of kind "explain". */
#ifndef PEN_JOBS_INTERNAL_KIND_H
#define PEN_JOBS_INTERNAL_KIND_H

#include <stdbool.h>

/* In the order of the names in pen_job_kinds (jobs.h). */
enum pen_job_kind {
    PEN_KIND_RENDER,
    PEN_KIND_BENCHMARK,
    PEN_KIND_ACCURACY,
    PEN_KIND_EFFECTS,
    PEN_KIND_EXPLAIN,
    PEN_KIND_COUNT
};

/* Finds a kind by its name, which may be NULL. Returns false if no kind has it. */
bool pen_job_kind_of_name(const char *name, enum pen_job_kind *kind);

/* Returns true if a job of this kind has a report instead of pictures. */
static inline bool pen_job_kind_has_report(enum pen_job_kind kind)
{
    return kind != PEN_KIND_RENDER;
}

/* Returns true if a job of this kind is about a single view. */
static inline bool pen_job_kind_has_one_view(enum pen_job_kind kind)
{
    return kind == PEN_KIND_ACCURACY || kind == PEN_KIND_EFFECTS || kind == PEN_KIND_EXPLAIN;
}

#endif
