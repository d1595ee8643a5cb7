/* SPDX-License-Identifier: MIT */
/* Parts of problem documents; pen_problem and pen_problem_list are in jobs.h. */
#ifndef PEN_JOBS_INTERNAL_PROBLEMS_H
#define PEN_JOBS_INTERNAL_PROBLEMS_H

#include <jansson.h>

#include "base/status.h"

/* The place of an error: {pointer, detail}, or {line, column, detail} if the input is text with
 * lines. Owns: the caller. Fails: NULL when out of memory. */
json_t *pen_problem_place(const struct pen_status *st);

#endif
