/* SPDX-License-Identifier: MIT */
/* The kinds of jobs that the crash test submits, and how each must end. */
#ifndef TESTS_CRASH_KINDS_H
#define TESTS_CRASH_KINDS_H

#include "jobs/jobs.h"

enum { KINDS = 5, VIEWS = 3 };

/* The submit of a job of a kind; its name is the kind's. */
void kind_body(int kind, int priority, char *out, size_t bytes);
const char *kind_name(int kind);
int kind_of(const char *name); /* -1: none */

/* What a job came to: each view's pixels and picture, and the count of rays. */
struct outcome {
    struct pen_buf pfm[VIEWS], png[VIEWS];
    json_t *rays;
};

/* Ends the program when there is none. Owns: release it. */
struct outcome outcome_of(struct pen_jobs *jobs, const char *id, int kind);
void outcome_release(struct outcome *outcome);
bool outcome_same_pixels(const struct outcome *a, const struct outcome *b);

/* Ends the program unless ok. */
void must(bool ok, const struct pen_status *st, const char *what);

#endif
