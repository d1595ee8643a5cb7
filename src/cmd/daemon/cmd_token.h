/* SPDX-License-Identifier: MIT */
/* `penumbrad token`, see cmd_token.c. */
#ifndef PEN_CMD_DAEMON_CMD_TOKEN_H
#define PEN_CMD_DAEMON_CMD_TOKEN_H

/* argv[0] is "token". Returns the exit code. */
int pen_token_command(int argc, char **argv);

#endif
