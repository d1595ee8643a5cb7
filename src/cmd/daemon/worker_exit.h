/* SPDX-License-Identifier: MIT */
/* The meaning of a process's wait status: as text, and whether its work crashed a worker. */
#ifndef PEN_CMD_DAEMON_WORKER_EXIT_H
#define PEN_CMD_DAEMON_WORKER_EXIT_H

#include <stdbool.h>
#include <stddef.h>

#include "store/store.h"

/* The exit code of a child in which execv failed. */
enum { PEN_EXEC_FAILED = 127 };

/* Writes "signal 11 (SIGSEGV)" or "exit code 3". */
void pen_exit_describe(int wait_status, char *out, size_t bytes);

/* Returns PEN_WORKER_CRASHED if rendering caused the worker's end, otherwise PEN_WORKER_DIED.
 * `oom`: the kernel's OOM killer has ended processes during the worker's life.
 *
 *   SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT     crashed
 *   SIGKILL, SIGTERM                             crashed if oom, otherwise died: killed by another
 *                                                process
 *   other signals                                died
 *   exit code 0, PEN_EXEC_FAILED, or the code of PEN_STORAGE or PEN_UNAVAILABLE (store errors)
 *                                                died
 *   other exit codes                             crashed */
enum pen_worker_end pen_exit_worker_end(int wait_status, bool oom);

#endif
