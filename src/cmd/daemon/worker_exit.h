/* SPDX-License-Identifier: MIT */
/* What the end of a process means. */
#ifndef PEN_CMD_DAEMON_WORKER_EXIT_H
#define PEN_CMD_DAEMON_WORKER_EXIT_H

#include <stdbool.h>
#include <stddef.h>

#include "store/store.h"

enum { PEN_EXEC_FAILED = 127 };

/* "signal 11 (SIGSEGV)", "exit code 3". */
void pen_exit_describe(int wait_status, char *out, size_t bytes);

/* Whose doing the end of a worker was. oom: the kernel ended processes for want of memory
 * meanwhile. An end that the store has caused is not the doing of what was rendered. */
enum pen_worker_end pen_exit_worker_end(int wait_status, bool oom);

#endif
