/* SPDX-License-Identifier: MIT */
/* Render settings on the command line: `--set KEY=VALUE`; for benchmarks `--matrix KEY=VALUE,…` and
 * `--baseline KEY=VALUE,…`; for accuracy studies `--ladder KEY=VALUE,…`. A value is JSON if it is
 * valid JSON, else a string. */
#ifndef PEN_CMD_CLIENT_SETTING_OPTIONS_H
#define PEN_CMD_CLIENT_SETTING_OPTIONS_H

#include <jansson.h>

#include "cmd/client/common_options.h"
#include "scene/settings.h"

/* Applies every --set to *settings.
 * Fails: PEN_USAGE, PEN_UNSUPPORTED, PEN_NO_MEMORY, naming the option. */
bool pen_set_options_apply(const struct pen_option_list *set, struct pen_settings *settings,
                           struct pen_status *st);

/* Adds every --set to the `render` object of a job, after the same checks.
 * Fails: as pen_set_options_apply. */
bool pen_set_options_add(json_t *job, const struct pen_option_list *set, struct pen_status *st);

/* Adds the members of a benchmark to a job, for the options that were given. Only baselines that
 * name a row, with a `=`, are added; other baselines are left to the caller.
 * Fails: PEN_USAGE, naming the option; PEN_NO_MEMORY. */
bool pen_bench_options_add(json_t *job, const struct pen_bench_values *values,
                           struct pen_status *st);

/* Finds the only baseline that names no row; NULL if there is none.
 * Fails: PEN_USAGE for several. */
bool pen_bench_options_report(const struct pen_bench_values *values, const char **report,
                              struct pen_status *st);

/* Adds the members of an accuracy study to a job, for the options that were given, without the
 * budget.
 * Fails: PEN_USAGE, naming the option; PEN_NO_MEMORY. */
bool pen_accuracy_options_add(json_t *job, const struct pen_accuracy_values *values,
                              struct pen_status *st);

/* Turns errors about these members into errors about the options. "/matrix/threads/1" becomes
 * "--matrix threads". */
void pen_bench_options_errors(struct pen_errors *errors);

#endif
