/* SPDX-License-Identifier: MIT */
/* `penumbrad backup`, see cmd_backup.c. */
#ifndef PEN_CMD_DAEMON_CMD_BACKUP_H
#define PEN_CMD_DAEMON_CMD_BACKUP_H

/* argv[0] is "backup". Returns the exit code. */
int pen_backup_command(int argc, char **argv);

#endif
