/* SPDX-License-Identifier: MIT */
/* What an api process does that cannot open the store: instead of letting clients wait in the
 * socket's queue for a server that may never come, it tells them why. */
#ifndef PEN_CMD_DAEMON_STAND_IN_H
#define PEN_CMD_DAEMON_STAND_IN_H

#include <stdint.h>

#include "base/status.h"
#include "cmd/daemon/control.h"

/* Answers every request with 503 and the reason, as a problem document, until the time is up or the
 * process has to end. */
void pen_stand_in(int listen_fd, struct pen_event_source *events, const struct pen_status *reason,
                  int64_t ms);

#endif
