/* SPDX-License-Identifier: MIT */
/* The process that starts and watches the others. It parses no input but its configuration, opens
 * the store only to see that it can, has one thread, and so outlives them.
 *
 *  - It owns the listening socket: while an api process is replaced, connections wait in its
 *    queue, none is refused.
 *  - A child that ends is started again, with a pause that doubles if it ends soon each time.
 *  - A worker's successor first takes back the leases of the dead.
 *  - Its own end, by whatever cause, ends the children: their control channel closes.
 *  - SIGTERM drains: the api refuses new jobs and answers the rest, the worker finishes or gives
 *    back its batch, then the api ends, then this process, with exit code 0, all within 10 s. */
#ifndef PEN_CMD_DAEMON_SUPERVISOR_H
#define PEN_CMD_DAEMON_SUPERVISOR_H

#include "cmd/daemon/config.h"

/* Runs until drained. argc and argv are those of main, to read the configuration again on SIGHUP.
 * Owns: *config and listen_fd stay the caller's. */
int pen_supervisor_run(const struct pen_config *config, int argc, char **argv, int listen_fd);

#endif
