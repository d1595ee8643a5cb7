/* SPDX-License-Identifier: MIT */
/* Messages to the service manager that has started the daemon (sd_notify(3)): datagrams to the
 * socket in $NOTIFY_SOCKET. Without that variable every call does nothing. */
#ifndef PEN_CMD_DAEMON_NOTIFY_H
#define PEN_CMD_DAEMON_NOTIFY_H

#include <stdbool.h>
#include <stdint.h>

struct pen_notify {
    int fd;              /* connected to the manager's socket; -1: none */
    int64_t watchdog_ns; /* the longest time between two "WATCHDOG=1"; 0: no watchdog */
};

/* Reads the environment, and removes from it the variables that are only for this process. A socket
 * that cannot be used is logged.
 * Owns: close with pen_notify_close. */
void pen_notify_open(struct pen_notify *notify);
void pen_notify_close(struct pen_notify *notify);

/* Sends a message such as "READY=1". Returns false if the manager's queue is full, so that it must
 * be sent again. */
bool pen_notify_send(const struct pen_notify *notify, const char *message);

#endif
