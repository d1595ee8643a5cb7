/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/access.h"

#include <stdlib.h>
#include <string.h>

#include "access/tls.h"
#include "access/tokens.h"
#include "base/buf.h"
#include "http/server.h"

/* Returns the length of a host at the start of a text: a name, or an IPv6 address in brackets. */
static size_t host_length(const char *text)
{
    if (text[0] != '[')
        return strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789.-_");
    const size_t inner = strspn(text + 1, "0123456789abcdef:.");
    return inner > 0 && text[1 + inner] == ']' ? inner + 2 : 0;
}

/* SCHEME://HOST[:PORT], in lower case. */
static bool is_origin(const char *text)
{
    const size_t scheme = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789+.-");
    if (scheme == 0 || strncmp(text + scheme, "://", 3) != 0)
        return false;
    const char *host = text + scheme + 3;
    const char *port = host + host_length(host);
    const size_t digits = port[0] == ':' ? strspn(port + 1, "0123456789") : 0;
    if (digits > 0 && digits <= 5 && atoi(port + 1) <= 65535)
        return port > host && port[1 + digits] == '\0';
    return port > host && port[0] == '\0';
}

/* Adds the origins of one text. */
static bool add_origins(struct pen_buf *all, const char *text, struct pen_status *st)
{
    char *copy = strdup(text), *rest = NULL;
    bool ok = copy || pen_fail(st, PEN_NO_MEMORY, "out of memory");
    for (char *word = ok ? strtok_r(copy, " ", &rest) : NULL; word && ok;
         word = strtok_r(NULL, " ", &rest)) {
        ok = is_origin(word) ||
             pen_fail(st, PEN_USAGE,
                      "cors: found \"%.80s\", allowed is SCHEME://HOST[:PORT] as a browser sends "
                      "it, such as https://example.org",
                      word);
        pen_buf_printf(all, "%s%s", all->bytes ? " " : "", word);
    }
    free(copy);
    return ok;
}

static bool join_origins(struct pen_access *access, struct pen_status *st)
{
    struct pen_buf all = {0};
    bool ok = true;
    for (int i = 0; i < access->origins.count && ok; i++)
        ok = add_origins(&all, access->origins.item[i], st);
    if (all.failed)
        ok = pen_fail(st, PEN_NO_MEMORY, "out of memory");
    access->cors = (char *)all.data;
    return ok;
}

static bool check_values(struct pen_access *access, struct pen_status *st)
{
    if (access->trusted_proxy && !pen_http_is_address(access->trusted_proxy))
        return pen_fail(st, PEN_USAGE,
                        "trusted-proxy: found \"%.60s\"; a numeric IPv4 or IPv6 address is allowed",
                        access->trusted_proxy);
    if (!access->tls_cert != !access->tls_key)
        return pen_fail(st, PEN_USAGE, "found %s without %s FILE; TLS needs both",
                        access->tls_cert ? "--tls-cert" : "--tls-key",
                        access->tls_cert ? "--tls-key" : "--tls-cert");
    return join_origins(access, st);
}

bool pen_access_check(struct pen_access *access, const struct pen_address *address,
                      struct pen_status *st)
{
    if (!check_values(access, st))
        return false;
    if (!address || pen_address_is_loopback(address))
        return true;
    if (!access->tokens)
        return pen_fail(st, PEN_USAGE,
                        "listen: other machines reach %s, which needs --tokens FILE (penumbrad "
                        "token add makes one); 127.0.0.1, localhost and [::1] need none",
                        address->host);
    return access->tls_cert || access->trusted_proxy || access->plain_http ||
           pen_fail(st, PEN_USAGE,
                    "listen: other machines reach %s, and tokens would travel unencrypted; give "
                    "--tls-cert FILE and --tls-key FILE, or --trusted-proxy ADDRESS of a proxy "
                    "that has TLS, or --plain-http to allow it",
                    address->host);
}

bool pen_access_check_files(const struct pen_access *access, struct pen_status *st)
{
    struct pen_tokens *tokens = access->tokens ? pen_tokens_open(access->tokens, st) : NULL;
    bool ok = tokens || !access->tokens;
    struct pen_tls *tls =
        ok && access->tls_cert ? pen_tls_open(access->tls_cert, access->tls_key, st) : NULL;
    ok = ok && (tls || !access->tls_cert);
    pen_tls_close(tls);
    pen_tokens_close(tokens);
    if (!ok)
        st->code = PEN_USAGE;
    return ok;
}

bool pen_access_is_open(const struct pen_access *access, const struct pen_address *address)
{
    return access->plain_http && !access->tls_cert && !pen_address_is_loopback(address);
}

void pen_access_release(struct pen_access *access)
{
    free(access->cors);
    *access = (struct pen_access){0};
}
