/* SPDX-License-Identifier: MIT */
/* The process that starts and supervises the children that its role names: the api process, the
 * worker process, or both. It survives their crashes, because it does little itself. It has one
 * thread, parses only its configuration, and opens the store only once, to check it at the start.
 *
 *   - It owns the listening socket. While an api process is replaced, new connections wait in the
 *     socket's queue, and none is refused.
 *   - It restarts a child that has ended. If a child ends soon after each start, the pauses between
 *     the starts double. A crash that is charged to a job does not count for the pauses.
 *   - A child that meets an I/O error of the store ends. Until its successor works, the daemon is
 *     not ready, and /readyz says why.
 *   - The successor of a worker first releases the leases of its predecessor, and charges a crash.
 *   - The children end when the supervisor ends or dies, because their control channel closes.
 *   - SIGTERM and SIGINT drain the daemon within 10 s:
 *      1. the api refuses new jobs and answers all other requests;
 *      2. the worker finishes its batch, or gives it back;
 *      3. the api ends;
 *      4. this process ends, with exit code 0.
 *   - A second signal kills the children at once.
 *   - A worker that ends because of --until-idle drains the daemon like a signal.
 *   - SIGHUP reads the configuration again: the log's level, format and file, and the number of
 *     threads. It also opens the log file again. */
#ifndef PEN_CMD_DAEMON_SUPERVISOR_H
#define PEN_CMD_DAEMON_SUPERVISOR_H

#include "cmd/daemon/config.h"

/* Runs until drained. Returns the exit code. argc and argv are those of main, to read the
 * configuration again on SIGHUP. listen_fd is -1 without an api.
 * Owns: the caller keeps all of them. */
int pen_supervisor_run(const struct pen_config *config, int argc, char **argv, int listen_fd);

#endif
