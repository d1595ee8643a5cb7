/* SPDX-License-Identifier: MIT */
/* The kinds of jobs that the crash test submits, and how each must end. */
#ifndef TESTS_CRASH_KINDS_H
#define TESTS_CRASH_KINDS_H

#include "jobs/jobs.h"

enum { KINDS = 6, VIEWS = 3 };

/* Writes the body of a submit of this kind. The job's name is the kind's. */
void kind_body(int kind, int priority, char *out, size_t bytes);
const char *kind_name(int kind);
int kind_of(const char *name); /* -1: none */

/* The results of a job: each view's pixels and picture, and the ray counts. */
struct outcome {
    struct pen_buf pfm[VIEWS], png[VIEWS];
    json_t *rays;
};

/* Reads the results of a job that has succeeded; ends the program if there are none.
 * Owns: release the outcome. */
struct outcome outcome_of(struct pen_jobs *jobs, const char *id, int kind);
void outcome_release(struct outcome *outcome);
bool outcome_same_pixels(const struct outcome *a, const struct outcome *b);

/* Ends the program with a message, unless `ok` is true. */
void must(bool ok, const struct pen_status *st, const char *what);

#endif
