/* SPDX-License-Identifier: MIT */
/* The daemon's configuration file: a JSON object whose keys are the names of options, with `_` for
 * `-`. */
#ifndef PEN_CMD_DAEMON_CONFIG_FILE_H
#define PEN_CMD_DAEMON_CONFIG_FILE_H

#include "cmd/daemon/config.h"
#include "cmd/report.h"

/* Reads config->file: checks all its values, sets those that `parsed` does not have yet, and marks
 * them in `parsed`.
 * Owns: the values point into config->document.
 * Fails: false, and all errors, as PEN_USAGE. */
bool pen_config_read_file(struct pen_config *config, struct pen_parsed *parsed,
                          struct pen_errors *errors);

#endif
