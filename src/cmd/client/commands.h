/* SPDX-License-Identifier: MIT */
/* The subcommands of `penumbra`. Each is defined in its file cmd_NAME.c; wait, fetch, stats, cancel
 * and delete are in cmd_jobs.c. */
#ifndef PEN_CMD_CLIENT_COMMANDS_H
#define PEN_CMD_CLIENT_COMMANDS_H

#include "cmd/options.h"

extern const struct pen_command pen_command_render;
extern const struct pen_command pen_command_validate;
extern const struct pen_command pen_command_compare;
extern const struct pen_command pen_command_scenes;
extern const struct pen_command pen_command_bench;
extern const struct pen_command pen_command_effects;
extern const struct pen_command pen_command_explain;
extern const struct pen_command pen_command_accuracy;
extern const struct pen_command pen_command_audit;
extern const struct pen_command pen_command_convert;
extern const struct pen_command pen_command_submit;
extern const struct pen_command pen_command_wait;
extern const struct pen_command pen_command_fetch;
extern const struct pen_command pen_command_list;
extern const struct pen_command pen_command_top;
extern const struct pen_command pen_command_stats;
extern const struct pen_command pen_command_cancel;
extern const struct pen_command pen_command_delete;

#endif
