/* SPDX-License-Identifier: MIT */
/* Where the daemon listens: reading HOST:PORT, and the socket itself. Loopback only, as long as
 * there are no tokens: whoever reaches the port may do everything. */
#ifndef PEN_CMD_DAEMON_LISTEN_H
#define PEN_CMD_DAEMON_LISTEN_H

#include <stdbool.h>
#include <sys/socket.h>

#include "base/status.h"

struct pen_address {
    char host[64]; /* as given: "127.0.0.1", "localhost", "[::1]" */
    struct sockaddr_storage socket;
    socklen_t bytes;
};

/* Reads HOST:PORT; HOST is an address or localhost, an IPv6 address in brackets, PORT 0…65535.
 * Fails: PEN_USAGE, also for what is not loopback. */
bool pen_address_parse(const char *text, struct pen_address *address, struct pen_status *st);

/* A listening socket, closed on exec; *port is the one it got. Fails: PEN_UNAVAILABLE, returning
 * -1. */
int pen_address_listen(const struct pen_address *address, int *port, struct pen_status *st);

#endif
