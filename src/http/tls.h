/* SPDX-License-Identifier: MIT */
/* The certificate of the server, read from PEM files and read again when they change. A process has
 * one at most: GnuTLS asks for it without saying whose server it is for. */
#ifndef PEN_HTTP_TLS_H
#define PEN_HTTP_TLS_H

#include <stdbool.h>

#include "base/status.h"

/* Reads a certificate (with its chain) and its key, and forgets them. Fails: PEN_USAGE, naming the
 * file that is at fault; also if the key is not the certificate's. */
bool pen_tls_check(const char *cert, const char *key, struct pen_status *st);

#endif
