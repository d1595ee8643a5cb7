/* SPDX-License-Identifier: MIT */
/* Who may reach the daemon, and how: the part of the configuration for other machines. Its rules:
 *   - An address other than 127.0.0.1 and ::1 needs tokens.
 *   - Such an address also needs TLS, or a proxy that has TLS, or the operator's consent to plain
 *     HTTP. */
#ifndef PEN_CMD_DAEMON_ACCESS_H
#define PEN_CMD_DAEMON_ACCESS_H

#include <stdbool.h>

#include "base/status.h"
#include "cmd/daemon/listen.h"
#include "cmd/options.h"

struct pen_access {
    const char *tokens, *tls_cert, *tls_key; /* files; NULL: none */
    const char *trusted_proxy;               /* NULL: none */
    bool plain_http;
    struct pen_option_list origins; /* each item has one origin or more, with spaces between them */
    char *cors;                     /* all origins, with spaces between them; NULL: none */
};

/* Checks the values and sets `cors`. If `address` is not NULL, also checks the rules.
 * Owns: release *access in any case.
 * Fails: PEN_USAGE, PEN_NO_MEMORY. */
bool pen_access_check(struct pen_access *access, const struct pen_address *address,
                      struct pen_status *st);

/* Checks the files before a process uses them.
 * Fails: PEN_USAGE, like any wrong configuration. */
bool pen_access_check_files(const struct pen_access *access, struct pen_status *st);

/* Returns true if requests of other machines arrive without encryption. */
bool pen_access_is_open(const struct pen_access *access, const struct pen_address *address);

void pen_access_release(struct pen_access *access);

#endif
