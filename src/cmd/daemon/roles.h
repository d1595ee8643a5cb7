/* SPDX-License-Identifier: MIT */
/* What the daemon's processes do: the api serves HTTP and never renders, the worker renders and
 * serves nothing. Each runs alone (`--role api`, `--role worker`) or as a child of the supervisor;
 * then it ends when the supervisor does, however that died: within PEN_LOST_MS. */
#ifndef PEN_CMD_DAEMON_ROLES_H
#define PEN_CMD_DAEMON_ROLES_H

#include "cmd/daemon/config.h"

enum {
    PEN_LOST_MS = 1000,        /* a child whose supervisor is gone */
    PEN_DRAIN_WORKER_MS = 6000 /* for the batch in hand; then it is given back */
};

/* What the kernel lists a worker process as. */
#define PEN_WORKER_PROCESS "penumbrad-work"

/* Serves until told to stop. Returns the exit code. */
int pen_role_api(const struct pen_config *config, int listen_fd);

/* Works until told to stop. Returns the exit code. */
int pen_role_worker(const struct pen_config *config);

#endif
