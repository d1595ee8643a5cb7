/* SPDX-License-Identifier: MIT */
#include "cmd/client/transport.h"

#include <string.h>

bool pen_transport_may_pass(const struct pen_transport *transport, CURLcode code)
{
    if (code == CURLE_SSL_CONNECT_ERROR)
        return transport->answered;
    return code != CURLE_OUT_OF_MEMORY && code != CURLE_WRITE_ERROR &&
           code != CURLE_UNSUPPORTED_PROTOCOL && code != CURLE_PEER_FAILED_VERIFICATION &&
           code != CURLE_SSL_CACERT_BADFILE;
}

/* Returns what to do about a certificate that libcurl refuses. It has one code for all reasons, so
 * its text decides. */
static const char *certificate_advice(const struct pen_transport *transport, const char *text)
{
    if (strstr(text, "subject name"))
        return "; --server must have a host name or address that the certificate has";
    if (strstr(text, "expir") || strstr(text, "not yet valid"))
        return "; the daemon needs a certificate that is valid today, or a clock is wrong";
    return transport->ca ? "; the authority in --ca or PENUMBRA_CA has not signed it"
                         : "; if the daemon is yours, give the authority that signed its "
                           "certificate: --ca FILE";
}

static const char *advice(const struct pen_transport *transport, CURLcode code, const char *text)
{
    if (transport->tls && code == CURLE_PEER_FAILED_VERIFICATION)
        return certificate_advice(transport, text);
    if (code == CURLE_SSL_CACERT_BADFILE)
        return "; --ca or PENUMBRA_CA must be a file of certificates in PEM";
    if (transport->answered)
        return "";
    if (transport->tls && code == CURLE_SSL_CONNECT_ERROR)
        return "; if the daemon has no TLS, give --server http://…";
    /* A server that expects a handshake closes the connection or answers with bytes of TLS. */
    const bool odd = code == CURLE_GOT_NOTHING || code == CURLE_RECV_ERROR ||
                     code == CURLE_UNSUPPORTED_PROTOCOL || code == CURLE_WEIRD_SERVER_REPLY;
    return !transport->tls && odd ? "; if the daemon has TLS, give --server https://…" : "";
}

void pen_transport_fail(const struct pen_transport *transport, CURLcode code, const char *text,
                        struct pen_status *st)
{
    pen_fail(st, code == CURLE_OUT_OF_MEMORY ? PEN_NO_MEMORY : PEN_NETWORK, "%s: %s%s",
             transport->server, text, advice(transport, code, text));
}
