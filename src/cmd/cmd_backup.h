/* SPDX-License-Identifier: MIT */
/* `penumbrad backup`, see cmd_backup.c. */
#ifndef CMD_CMD_BACKUP_H
#define CMD_CMD_BACKUP_H

/* argv[0] is "backup". Returns the exit code. */
int pen_backup_command(int argc, char **argv);

#endif
