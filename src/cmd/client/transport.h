/* SPDX-License-Identifier: MIT */
/* Faults between client and daemon: what libcurl's codes mean to the user, and which faults may
 * pass. */
#ifndef PEN_CMD_CLIENT_TRANSPORT_H
#define PEN_CMD_CLIENT_TRANSPORT_H

#include <curl/curl.h>
#include <stdbool.h>

#include "base/status.h"

struct pen_transport {
    const char *server;
    const char *ca; /* --ca; NULL: the system's authorities */
    bool tls;
    bool answered; /* the server has answered this client before */
};

/* Returns true if the same request may succeed later. A wrong certificate stays wrong, and so does
 * a server that has never completed a handshake. */
bool pen_transport_may_pass(const struct pen_transport *transport, CURLcode code);

/* Fills *st with the fault, which is libcurl's `text`, and with what to do about it. */
void pen_transport_fail(const struct pen_transport *transport, CURLcode code, const char *text,
                        struct pen_status *st);

#endif
