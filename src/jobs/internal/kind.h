/* SPDX-License-Identifier: MIT */
/* The kinds of jobs. All but renders are studies: one batch, a report, and no picture. Jobs of kind
 * "explain" are made by POST /v1/explain alone. */
#ifndef PEN_JOBS_INTERNAL_KIND_H
#define PEN_JOBS_INTERNAL_KIND_H

#include <stdbool.h>

/* In the order of pen_job_kinds (jobs.h), which has their names. */
enum pen_job_kind {
    PEN_KIND_RENDER,
    PEN_KIND_BENCHMARK,
    PEN_KIND_ACCURACY,
    PEN_KIND_EFFECTS,
    PEN_KIND_EXPLAIN,
    PEN_KIND_COUNT
};

/* Returns false if no kind has this name; NULL is no name. */
bool pen_job_kind_of_name(const char *name, enum pen_job_kind *kind);

/* Whether a job of this kind has a report instead of pictures. */
static inline bool pen_job_kind_has_report(enum pen_job_kind kind)
{
    return kind != PEN_KIND_RENDER;
}

/* Whether a job of this kind is about a single view. */
static inline bool pen_job_kind_has_one_view(enum pen_job_kind kind)
{
    return kind == PEN_KIND_ACCURACY || kind == PEN_KIND_EFFECTS || kind == PEN_KIND_EXPLAIN;
}

#endif
