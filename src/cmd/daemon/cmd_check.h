/* SPDX-License-Identifier: MIT */
/* `penumbrad check`: looks for damage in the whole store, which a daemon may use meanwhile. */
#ifndef PEN_CMD_DAEMON_CMD_CHECK_H
#define PEN_CMD_DAEMON_CMD_CHECK_H

/* argv[0] is "check". Returns the exit code: that of PEN_STORAGE if there is damage. */
int pen_check_command(int argc, char **argv);

#endif
