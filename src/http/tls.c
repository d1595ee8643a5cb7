/* SPDX-License-Identifier: MIT */
#include "http/tls.h"

#include <errno.h>
#include <fcntl.h>
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <string.h>
#include <unistd.h>

/* gnutls tells neither which file it cannot open nor why. */
static bool check_readable(const char *path, struct pen_status *st)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0)
        return pen_fail(st, errno == ENOENT ? PEN_NOT_FOUND : PEN_IO, "%s: cannot open: %s", path,
                        strerror(errno));
    close(fd);
    return true;
}

/* Whether the first of the two files is at fault, which gnutls does not tell either. */
static bool has_certificate(const char *path)
{
    gnutls_x509_crt_t *list = NULL;
    unsigned count = 0;
    gnutls_datum_t text = {0};
    const bool ok = gnutls_load_file(path, &text) == 0 &&
                    gnutls_x509_crt_list_import2(&list, &count, &text, GNUTLS_X509_FMT_PEM, 0) >= 0;
    for (unsigned i = 0; ok && i < count; i++)
        gnutls_x509_crt_deinit(list[i]);
    gnutls_free(list);
    gnutls_free(text.data);
    return ok;
}

bool pen_tls_check(const char *cert, const char *key, struct pen_status *st)
{
    gnutls_certificate_credentials_t credentials;
    if (!check_readable(cert, st) || !check_readable(key, st))
        return false;
    if (!has_certificate(cert))
        return pen_fail(st, PEN_SYNTAX, "%s: found no certificate, allowed is PEM", cert);
    if (gnutls_certificate_allocate_credentials(&credentials) != 0)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    const int code =
        gnutls_certificate_set_x509_key_file(credentials, cert, key, GNUTLS_X509_FMT_PEM);
    gnutls_certificate_free_credentials(credentials);
    if (code == GNUTLS_E_CERTIFICATE_KEY_MISMATCH)
        return pen_fail(st, PEN_CONFLICT, "%s: this key does not fit the certificate %s", key,
                        cert);
    return code >= 0 || pen_fail(st, PEN_SYNTAX,
                                 "%s: found no private key, allowed is PEM without a password (%s)",
                                 key, gnutls_strerror(code));
}
