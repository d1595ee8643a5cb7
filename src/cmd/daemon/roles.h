/* SPDX-License-Identifier: MIT */
/* The processes that do the daemon's work, children of the supervisor. The api process serves HTTP
 * and never renders. The worker process renders and never serves. A child ends within PEN_LOST_MS
 * after the end of its supervisor. */
#ifndef PEN_CMD_DAEMON_ROLES_H
#define PEN_CMD_DAEMON_ROLES_H

#include "cmd/daemon/config.h"

enum {
    PEN_LOST_MS = 1000,        /* from the end of the supervisor to the end of a child */
    PEN_DRAIN_WORKER_MS = 6000 /* from "stop" until a worker gives its unfinished batch back */
};

/* Serves until it is asked to stop. Returns the exit code. */
int pen_role_api(const struct pen_config *config);

/* Renders until it is asked to stop, or had no work for config->until_idle. Returns the exit
 * code. */
int pen_role_worker(const struct pen_config *config);

#endif
