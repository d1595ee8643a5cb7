/* SPDX-License-Identifier: MIT */
/* The certificate of the server, read from PEM files and read again when they change. A process has
 * one at most: GnuTLS asks for it without saying whose server it is for. */
#ifndef PEN_HTTP_TLS_H
#define PEN_HTTP_TLS_H

#include <stdbool.h>

#include "base/status.h"

/* Checks that a file holds a certificate, or a chain that begins with it, another its private key,
 * both as PEM, and that they fit each other. Fails: PEN_NOT_FOUND, PEN_IO, PEN_SYNTAX,
 * PEN_CONFLICT (they do not fit), PEN_NO_MEMORY; the message names the file. */
bool pen_tls_check(const char *cert, const char *key, struct pen_status *st);

#endif
