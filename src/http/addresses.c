/* SPDX-License-Identifier: MIT */
/* Counts in a list, which is searched from its beginning: it is as long as there are addresses
 * whose requests wait. */
#include "http/internal/addresses.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>

#include "http/server.h"

static void map_ipv4(const void *address, unsigned char out[16])
{
    memset(out, 0, 10);
    out[10] = out[11] = 0xff;
    memcpy(out + 12, address, 4);
}

/* Writes an address as IPv6. */
static bool write_ipv6(const struct sockaddr *peer, unsigned char out[16])
{
    if (peer->sa_family == AF_INET6)
        memcpy(out, &((const struct sockaddr_in6 *)(const void *)peer)->sin6_addr, 16);
    else if (peer->sa_family == AF_INET)
        map_ipv4(&((const struct sockaddr_in *)(const void *)peer)->sin_addr, out);
    return peer->sa_family == AF_INET6 || peer->sa_family == AF_INET;
}

static bool is_ipv4(const unsigned char bytes[16])
{
    static const unsigned char prefix[12] = {[10] = 0xff, [11] = 0xff};
    return memcmp(bytes, prefix, sizeof prefix) == 0;
}

static bool is_loopback(const unsigned char bytes[16])
{
    static const unsigned char loopback[16] = {[15] = 1};
    return is_ipv4(bytes) ? bytes[12] == 127 : memcmp(bytes, loopback, sizeof loopback) == 0;
}

bool pen_http_address_parse(const char *text, unsigned char out[16])
{
    unsigned char v4[4];
    if (inet_pton(AF_INET6, text, out) == 1)
        return true;
    if (inet_pton(AF_INET, text, v4) != 1)
        return false;
    map_ipv4(v4, out);
    return true;
}

bool pen_http_is_address(const char *text)
{
    unsigned char ignored[16];
    return pen_http_address_parse(text, ignored);
}

/* Keeps of an IPv6 address its network. */
static void keep_network(unsigned char bytes[16])
{
    if (!is_ipv4(bytes) && !is_loopback(bytes))
        memset(bytes + 8, 0, 8);
}

struct pen_address_key pen_http_address_key(const struct sockaddr *peer,
                                            const unsigned char trusted[16], bool count_loopback)
{
    struct pen_address_key key = {0};
    if (!write_ipv6(peer, key.bytes))
        return (struct pen_address_key){.exempt = true};
    key.is_proxy = trusted && memcmp(key.bytes, trusted, sizeof key.bytes) == 0;
    key.exempt = (is_loopback(key.bytes) && !count_loopback) || key.is_proxy;
    keep_network(key.bytes);
    return key;
}

/* Leaves the address of one with a port: 192.0.2.1:80, [2001:db8::1]:80 or [2001:db8::1]. */
static char *without_port(char *text)
{
    char *end = strrchr(text, text[0] == '[' ? ']' : ':');
    if (end && (text[0] == '[' || strchr(text, ':') == end))
        *end = '\0';
    return text + (text[0] == '[');
}

bool pen_http_address_forwarded(const char *forwarded_for, struct pen_address_key *key)
{
    char text[PEER_BYTES + 10];
    const char *comma = strrchr(forwarded_for, ','), *at = comma ? comma + 1 : forwarded_for;
    at += strspn(at, " \t");
    const size_t length = strcspn(at, " \t");
    if (length >= sizeof text || at[length + strspn(at + length, " \t")] != '\0')
        return false;
    memcpy(text, at, length);
    text[length] = '\0';
    *key = (struct pen_address_key){0};
    if (!pen_http_address_parse(without_port(text), key->bytes))
        return false;
    keep_network(key->bytes);
    return true;
}

void pen_http_address_text(const struct pen_address_key *key, char text[PEER_BYTES])
{
    static const unsigned char unknown[16];
    const bool ipv4 = is_ipv4(key->bytes);
    const int family = ipv4 ? AF_INET : AF_INET6;
    const void *address = ipv4 ? key->bytes + 12 : key->bytes;
    if (memcmp(key->bytes, unknown, sizeof unknown) == 0 ||
        !inet_ntop(family, address, text, PEER_BYTES))
        text[0] = '\0';
}

bool pen_http_address_equal(const struct pen_address_key *a, const struct pen_address_key *b)
{
    return memcmp(a->bytes, b->bytes, sizeof a->bytes) == 0;
}

static struct address_count *find(struct addresses *addresses, const struct pen_address_key *key)
{
    for (int i = 0; i < addresses->count; i++) {
        if (memcmp(addresses->item[i].bytes, key->bytes, sizeof key->bytes) == 0)
            return &addresses->item[i];
    }
    return NULL;
}

bool pen_http_addresses_take(struct addresses *addresses, const struct pen_address_key *key,
                             int limit)
{
    if (key->exempt)
        return true;
    struct address_count *item = find(addresses, key);
    if (item)
        return item->waiting < limit && ++item->waiting > 0;
    if (addresses->count == ADDRESSES_MAX)
        return false;
    item = &addresses->item[addresses->count++];
    memcpy(item->bytes, key->bytes, sizeof item->bytes);
    item->waiting = 1;
    return true;
}

void pen_http_addresses_give(struct addresses *addresses, const struct pen_address_key *key)
{
    struct address_count *item = key->exempt ? NULL : find(addresses, key);
    if (item && --item->waiting == 0)
        *item = addresses->item[--addresses->count];
}
