/* SPDX-License-Identifier: MIT */
/* The wait status of a process in words, and whether a worker's end was caused by its work. */
#ifndef PEN_CMD_DAEMON_WORKER_EXIT_H
#define PEN_CMD_DAEMON_WORKER_EXIT_H

#include <stdbool.h>
#include <stddef.h>

#include "store/store.h"

enum { PEN_EXEC_FAILED = 127 };

/* "signal 11 (SIGSEGV)", "exit code 3". */
void pen_exit_describe(int wait_status, char *out, size_t bytes);

/* PEN_WORKER_CRASHED if what was rendered caused the worker's end, else PEN_WORKER_DIED. oom: the
 * kernel's OOM killer ended processes while the worker lived. An exit with a store error is not
 * caused by what was rendered. */
enum pen_worker_end pen_exit_worker_end(int wait_status, bool oom);

#endif
