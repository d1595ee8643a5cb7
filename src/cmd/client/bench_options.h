/* SPDX-License-Identifier: MIT */
/* The options of a benchmark as the members of a job: `--matrix KEY=VALUE,…` and
 * `--baseline KEY=VALUE,…`. */
#ifndef PEN_CMD_CLIENT_BENCH_OPTIONS_H
#define PEN_CMD_CLIENT_BENCH_OPTIONS_H

#include <jansson.h>

#include "cmd/options.h"

/* Adds "matrix" and "baseline" to a job; without options neither. A value is JSON if it is JSON,
 * else a word. baseline may be NULL. Fails: PEN_USAGE, naming the option; PEN_NO_MEMORY. */
bool pen_bench_options_add(json_t *job, const struct pen_option_list *matrix, const char *baseline,
                           struct pen_status *st);

/* Turns errors about the members into errors about the options: pointers become their names. */
void pen_bench_options_errors(struct pen_errors *errors);

#endif
