/* SPDX-License-Identifier: MIT */
/* The certificate of the server, read from PEM files and read again when they change. A process has
 * at most one, because GnuTLS asks for a certificate without naming the server. */
#ifndef PEN_ACCESS_TLS_H
#define PEN_ACCESS_TLS_H

#include <gnutls/abstract.h>

#include "base/status.h"

struct pen_tls;

/* TLS 1.2 and 1.3 with GnuTLS's default ciphers. */
extern const char pen_tls_priorities[];

/* Reads a certificate, or a chain that begins with it, and its private key. Both files are PEM, of
 * at most 1 MiB.
 * Owns: close it after the last connection.
 * Fails: PEN_NOT_FOUND, PEN_IO, PEN_FORBIDDEN (not a regular file), PEN_TOO_LARGE, PEN_SYNTAX,
 * PEN_CONFLICT (key and certificate do not fit), PEN_NO_MEMORY; the message names the file. */
struct pen_tls *pen_tls_open(const char *cert, const char *key, struct pen_status *st);
void pen_tls_close(struct pen_tls *tls); /* NULL is allowed */

/* Reads the files again if they have changed. If they cannot be read or do not fit, the log says so
 * and the former certificate stays. A connection keeps the certificate with which it began.
 * Threads: one. */
void pen_tls_refresh(struct pen_tls *tls);

/* The callback from which GnuTLS gets the certificate of the open struct pen_tls. */
gnutls_certificate_retrieve_function2 pen_tls_certificate;

#endif
