/* SPDX-License-Identifier: MIT */
/* A replaced certificate is kept until the end, because a handshake may still use it. */
#include "access/tls.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "access/internal/small_file.h"
#include "base/log.h"

enum { CHAIN_MOST = 16 };

const char pen_tls_priorities[] = "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2";

/* A certificate, as read at one time. */
struct identity {
    gnutls_pcert_st chain[CHAIN_MOST];
    unsigned length;
    gnutls_privkey_t key;
    struct identity *before; /* the identity that it has replaced */
};

struct pen_tls {
    char *cert, *key;
    struct stat cert_seen, key_seen; /* the files at the last read */
    struct pen_status fault;         /* PEN_OK, or why the files are broken */
    struct identity *identity;       /* the last good one */
};

/* The certificate of the open struct pen_tls. Atomic, so that a handshake sees a complete
 * identity. */
static _Atomic(struct identity *) in_force;

static void identity_free(struct identity *identity)
{
    if (!identity)
        return;
    for (unsigned i = 0; i < identity->length; i++)
        gnutls_pcert_deinit(&identity->chain[i]);
    if (identity->key)
        gnutls_privkey_deinit(identity->key);
    identity_free(identity->before);
    free(identity);
}

static bool import_chain(struct identity *identity, const gnutls_datum_t *pem,
                         struct pen_status *st)
{
    unsigned length = CHAIN_MOST;
    const int code =
        gnutls_pcert_list_import_x509_raw(identity->chain, &length, pem, GNUTLS_X509_FMT_PEM, 0);
    identity->length = code < 0 ? 0 : length;
    return identity->length > 0 || pen_fail(st, PEN_SYNTAX, "found no certificate, allowed is PEM");
}

static bool import_key(struct identity *identity, const gnutls_datum_t *pem, struct pen_status *st)
{
    int code = gnutls_privkey_init(&identity->key);
    if (code == 0)
        code = gnutls_privkey_import_x509_raw(identity->key, pem, GNUTLS_X509_FMT_PEM, NULL, 0);
    return code == 0 ||
           pen_fail(st, PEN_SYNTAX, "found no private key, allowed is PEM without a password (%s)",
                    gnutls_strerror(code));
}

static bool import_file(const char *path,
                        bool (*import)(struct identity *, const gnutls_datum_t *,
                                       struct pen_status *),
                        struct identity *identity, struct pen_status *st)
{
    struct pen_small_file file;
    bool ok = pen_small_file_read(&file, path, st);
    const gnutls_datum_t pem = {(unsigned char *)file.text, (unsigned)file.bytes};
    ok = ok && import(identity, &pem, st);
    pen_small_file_release(&file);
    return ok || pen_small_file_name(path, st);
}

/* Returns true if the key belongs to the first certificate. */
static bool fits(const struct identity *identity)
{
    gnutls_pubkey_t own;
    unsigned char a[32], b[32]; /* hashes of the public keys */
    size_t bytes = sizeof a;
    if (gnutls_pubkey_init(&own) != 0)
        return false;
    const bool same = gnutls_pubkey_import_privkey(own, identity->key, 0, 0) == 0 &&
                      gnutls_pubkey_get_key_id(own, GNUTLS_KEYID_USE_SHA256, a, &bytes) == 0 &&
                      gnutls_pubkey_get_key_id(identity->chain[0].pubkey, GNUTLS_KEYID_USE_SHA256,
                                               b, &bytes) == 0 &&
                      memcmp(a, b, sizeof a) == 0;
    gnutls_pubkey_deinit(own);
    return same;
}

static struct identity *read_identity(const char *cert, const char *key, struct pen_status *st)
{
    struct identity *identity = calloc(1, sizeof *identity);
    if (!identity) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the certificate");
        return NULL;
    }
    if (import_file(cert, import_chain, identity, st) &&
        import_file(key, import_key, identity, st) &&
        (fits(identity) ||
         pen_fail(st, PEN_CONFLICT, "%s: this key does not fit the certificate %s", key, cert)))
        return identity;
    identity_free(identity);
    return NULL;
}

struct pen_tls *pen_tls_open(const char *cert, const char *key, struct pen_status *st)
{
    struct pen_tls *tls = calloc(1, sizeof *tls);
    if (!tls || !(tls->cert = strdup(cert)) || !(tls->key = strdup(key))) {
        pen_tls_close(tls);
        pen_fail(st, PEN_NO_MEMORY, "no memory for the certificate");
        return NULL;
    }
    pen_small_file_has_changed(cert, &tls->cert_seen);
    pen_small_file_has_changed(key, &tls->key_seen);
    tls->identity = read_identity(cert, key, st);
    if (!tls->identity) {
        pen_tls_close(tls);
        return NULL;
    }
    atomic_store(&in_force, tls->identity);
    return tls;
}

void pen_tls_close(struct pen_tls *tls)
{
    if (!tls)
        return;
    struct identity *own = tls->identity;
    atomic_compare_exchange_strong(&in_force, &own, NULL);
    identity_free(tls->identity);
    free(tls->cert);
    free(tls->key);
    free(tls);
}

void pen_tls_refresh(struct pen_tls *tls)
{
    struct pen_status st = {.code = PEN_OK};
    const bool cert = pen_small_file_has_changed(tls->cert, &tls->cert_seen),
               key = pen_small_file_has_changed(tls->key, &tls->key_seen);
    if (!cert && !key && tls->fault.code == PEN_OK)
        return;
    struct identity *identity = read_identity(tls->cert, tls->key, &st);
    const bool is_new = cert || key || strcmp(st.msg, tls->fault.msg) != 0;
    tls->fault = st;
    if (!identity) {
        if (is_new)
            pen_log(PEN_LOG_ERROR, "the certificate stays as it was: %s", st.msg);
        return;
    }
    identity->before = tls->identity;
    tls->identity = identity;
    atomic_store(&in_force, identity);
    pen_log(PEN_LOG_INFO, "the certificate was read again");
}

int pen_tls_certificate(gnutls_session_t session, const gnutls_datum_t *req_ca_dn, int nreqs,
                        const gnutls_pk_algorithm_t *pk_algos, int pk_algos_length,
                        gnutls_pcert_st **pcert, unsigned int *pcert_length,
                        gnutls_privkey_t *privkey)
{
    (void)session, (void)req_ca_dn, (void)nreqs, (void)pk_algos, (void)pk_algos_length;
    struct identity *identity = atomic_load(&in_force);
    if (!identity)
        return -1;
    *pcert = identity->chain;
    *pcert_length = identity->length;
    *privkey = identity->key;
    return 0;
}
