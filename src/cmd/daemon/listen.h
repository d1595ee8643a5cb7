/* SPDX-License-Identifier: MIT */
/* The daemon's listening socket: reading HOST:PORT, and opening it. */
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

/* Reads HOST:PORT. HOST is localhost, an IPv4 address, or an IPv6 address in brackets. PORT is
 * 0…65535; 0 stands for any free port.
 * Fails: PEN_USAGE. */
bool pen_address_parse(const char *text, struct pen_address *address, struct pen_status *st);

/* Returns true for 127.0.0.1 and ::1, the addresses that a server without tokens accepts in the
 * header Host. On any other address of 127/8 it would answer 403 to every request. */
bool pen_address_is_loopback(const struct pen_address *address);

/* Opens a listening socket, closed on exec; *port becomes its port.
 * Fails: -1 and PEN_UNAVAILABLE. */
int pen_address_listen(const struct pen_address *address, int *port, struct pen_status *st);

#endif
