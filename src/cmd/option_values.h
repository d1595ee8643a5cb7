/* SPDX-License-Identifier: MIT */
/* The values of options as text: to pass a whole configuration to another process, and to compare
 * two configurations. */
#ifndef PEN_CMD_OPTION_VALUES_H
#define PEN_CMD_OPTION_VALUES_H

#include "cmd/options.h"

/* Sets the environment variable of every row that has one to the row's value. So a program that is
 * started next begins with these values. The items of a list have spaces between them. The variable
 * of a row without a value is removed. Returns false when out of memory.
 * Threads: as setenv(3). */
bool pen_options_to_env(const struct pen_command *command, const void *values);

/* Returns true if an option has the same value in two structures of values, or when out of
 * memory. */
bool pen_option_same(const struct pen_option *option, const void *a, const void *b);

#endif
