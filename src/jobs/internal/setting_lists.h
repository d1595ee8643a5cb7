/* SPDX-License-Identifier: MIT */
/* Reading the members of studies: objects of render settings, each with a list of values, and
 * numbers. All errors are collected, each with its place. */
#ifndef PEN_JOBS_INTERNAL_SETTING_LISTS_H
#define PEN_JOBS_INTERNAL_SETTING_LISTS_H

#include <jansson.h>

#include "base/status.h"

/* Checks an object such as {"light_samples": [1, 4]}, the member `name` of a job. Fails:
 * errors->count grows. */
bool pen_setting_lists_check(const json_t *lists, const char *name, struct pen_errors *errors);

/* Read the member `key`, and leave *out if there is none: an integer from lo to hi; a number above
 * 0, or from 0 on if `zero`, and at most `hi`. Fail: errors->count grows. */
bool pen_count_read(const json_t *members, const char *key, int lo, int hi, int *out,
                    struct pen_errors *errors);
bool pen_number_read(const json_t *members, const char *key, bool zero, double hi, double *out,
                     struct pen_errors *errors);

#endif
