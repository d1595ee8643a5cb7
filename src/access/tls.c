/* SPDX-License-Identifier: MIT */
/* A certificate that has been replaced is kept until the end: a handshake may still use it. */
#include "access/tls.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/log.h"

enum { CHAIN_MOST = 16 };

const char pen_tls_priorities[] = "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2";

/* A certificate as it was read once. */
struct identity {
    gnutls_pcert_st chain[CHAIN_MOST];
    unsigned length;
    gnutls_privkey_t key;
    struct identity *before; /* the one that it has replaced */
};

/* What tells that a file has changed. */
struct file_state {
    ino_t inode;
    off_t bytes;
    struct timespec changed; /* its contents or its rights */
};

struct pen_tls {
    char *cert, *key;
    struct file_state cert_state, key_state;
    char fault[PEN_MSG_BYTES]; /* why the files could not be read; "": they were */
    struct identity *identity; /* guarded by the lock below */
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct pen_tls *opened; /* guarded by lock */

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

/* GnuTLS does not tell why it cannot open a file. */
static bool load_file(const char *path, gnutls_datum_t *data, struct pen_status *st)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0)
        return pen_fail(st, errno == ENOENT ? PEN_NOT_FOUND : PEN_IO, "%s: cannot open: %s", path,
                        strerror(errno));
    close(fd);
    const int code = gnutls_load_file(path, data);
    return code == 0 || pen_fail(st, PEN_IO, "%s: cannot read: %s", path, gnutls_strerror(code));
}

static bool read_chain(const char *path, struct identity *identity, struct pen_status *st)
{
    gnutls_datum_t data;
    unsigned length = CHAIN_MOST;
    if (!load_file(path, &data, st))
        return false;
    const int code =
        gnutls_pcert_list_import_x509_raw(identity->chain, &length, &data, GNUTLS_X509_FMT_PEM, 0);
    gnutls_free(data.data);
    identity->length = code < 0 ? 0 : length;
    return identity->length > 0 ||
           pen_fail(st, PEN_SYNTAX, "%s: found no certificate, allowed is PEM", path);
}

static bool read_key(const char *path, struct identity *identity, struct pen_status *st)
{
    gnutls_datum_t data;
    if (!load_file(path, &data, st))
        return false;
    int code = gnutls_privkey_init(&identity->key);
    if (code == 0)
        code = gnutls_privkey_import_x509_raw(identity->key, &data, GNUTLS_X509_FMT_PEM, NULL, 0);
    gnutls_memset(data.data, 0, data.size);
    gnutls_free(data.data);
    return code == 0 || pen_fail(st, PEN_SYNTAX,
                                 "%s: found no private key, allowed is PEM without a password (%s)",
                                 path, gnutls_strerror(code));
}

/* Whether the key is that of the first certificate. */
static bool fits(const struct identity *identity)
{
    gnutls_pubkey_t own;
    unsigned char a[64], b[64];
    size_t a_bytes = sizeof a, b_bytes = sizeof b;
    if (gnutls_pubkey_init(&own) != 0)
        return false;
    const bool same = gnutls_pubkey_import_privkey(own, identity->key, 0, 0) == 0 &&
                      gnutls_pubkey_get_key_id(own, GNUTLS_KEYID_USE_SHA256, a, &a_bytes) == 0 &&
                      gnutls_pubkey_get_key_id(identity->chain[0].pubkey, GNUTLS_KEYID_USE_SHA256,
                                               b, &b_bytes) == 0 &&
                      a_bytes == b_bytes && memcmp(a, b, a_bytes) == 0;
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
    if (read_chain(cert, identity, st) && read_key(key, identity, st) &&
        (fits(identity) ||
         pen_fail(st, PEN_CONFLICT, "%s: this key does not fit the certificate %s", key, cert)))
        return identity;
    identity_free(identity);
    return NULL;
}

bool pen_tls_check(const char *cert, const char *key, struct pen_status *st)
{
    struct identity *identity = read_identity(cert, key, st);
    identity_free(identity);
    return identity != NULL;
}

/* Whether a file has changed since the last look. */
static bool has_changed(const char *path, struct file_state *last)
{
    struct stat info;
    struct file_state now = {0};
    if (stat(path, &info) == 0) {
        now.inode = info.st_ino;
        now.bytes = info.st_size;
        now.changed = info.st_ctim;
    }
    const bool changed = memcmp(&now, last, sizeof now) != 0;
    *last = now;
    return changed;
}

struct pen_tls *pen_tls_open(const char *cert, const char *key, struct pen_status *st)
{
    struct pen_tls *tls = calloc(1, sizeof *tls);
    if (!tls || !(tls->cert = strdup(cert)) || !(tls->key = strdup(key))) {
        pen_tls_close(tls);
        pen_fail(st, PEN_NO_MEMORY, "no memory for the certificate");
        return NULL;
    }
    has_changed(cert, &tls->cert_state);
    has_changed(key, &tls->key_state);
    tls->identity = read_identity(cert, key, st);
    if (!tls->identity) {
        pen_tls_close(tls);
        return NULL;
    }
    pthread_mutex_lock(&lock);
    opened = tls;
    pthread_mutex_unlock(&lock);
    return tls;
}

void pen_tls_close(struct pen_tls *tls)
{
    if (!tls)
        return;
    pthread_mutex_lock(&lock);
    if (opened == tls)
        opened = NULL;
    pthread_mutex_unlock(&lock);
    identity_free(tls->identity);
    free(tls->cert);
    free(tls->key);
    free(tls);
}

void pen_tls_refresh(struct pen_tls *tls)
{
    struct pen_status st;
    const bool cert = has_changed(tls->cert, &tls->cert_state),
               key = has_changed(tls->key, &tls->key_state);
    if (!cert && !key && !tls->fault[0])
        return;
    struct identity *identity = read_identity(tls->cert, tls->key, &st);
    if (!identity) {
        if (strcmp(st.msg, tls->fault) != 0)
            pen_log(PEN_LOG_ERROR, "the certificate stays as it was: %s", st.msg);
        memcpy(tls->fault, st.msg, sizeof tls->fault);
        return;
    }
    tls->fault[0] = '\0';
    pthread_mutex_lock(&lock);
    identity->before = tls->identity;
    tls->identity = identity;
    pthread_mutex_unlock(&lock);
    pen_log(PEN_LOG_INFO, "the certificate was read again");
}

int pen_tls_certificate(gnutls_session_t session, const gnutls_datum_t *req_ca_dn, int nreqs,
                        const gnutls_pk_algorithm_t *pk_algos, int pk_algos_length,
                        gnutls_pcert_st **pcert, unsigned int *pcert_length,
                        gnutls_privkey_t *privkey)
{
    (void)session, (void)req_ca_dn, (void)nreqs, (void)pk_algos, (void)pk_algos_length;
    pthread_mutex_lock(&lock);
    struct identity *identity = opened ? opened->identity : NULL;
    pthread_mutex_unlock(&lock);
    if (!identity)
        return -1;
    *pcert = identity->chain;
    *pcert_length = identity->length;
    *privkey = identity->key;
    return 0;
}
