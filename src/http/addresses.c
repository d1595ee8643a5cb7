/* SPDX-License-Identifier: MIT */
#include "http/internal/addresses.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>

#include "http/server.h"

enum { TEXT_BYTES = 46 };

static void map_ipv4(const void *address, unsigned char out[16])
{
    memset(out, 0, 10);
    out[10] = out[11] = 0xff;
    memcpy(out + 12, address, 4);
}

bool pen_http_address_of(const struct sockaddr *peer, unsigned char out[16])
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

bool pen_http_address_is_loopback(const unsigned char address[16])
{
    static const unsigned char loopback[16] = {[15] = 1};
    return is_ipv4(address) ? address[12] == 127 : memcmp(address, loopback, sizeof loopback) == 0;
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

/* Removes the port from an address: 192.0.2.1:80, [2001:db8::1]:80 or [2001:db8::1]. */
static char *without_port(char *text)
{
    char *end = strrchr(text, text[0] == '[' ? ']' : ':');
    if (end && (text[0] == '[' || strchr(text, ':') == end))
        *end = '\0';
    return text + (text[0] == '[');
}

bool pen_http_address_forwarded(const char *forwarded_for, unsigned char out[16])
{
    char text[TEXT_BYTES + 10];
    const char *comma = strrchr(forwarded_for, ','), *at = comma ? comma + 1 : forwarded_for;
    at += strspn(at, " \t");
    const size_t length = strcspn(at, " \t");
    if (length >= sizeof text || at[length + strspn(at + length, " \t")] != '\0')
        return false;
    memcpy(text, at, length);
    text[length] = '\0';
    return pen_http_address_parse(without_port(text), out);
}

void pen_http_address_text(const unsigned char address[16], char *text, size_t bytes)
{
    static const unsigned char unknown[16];
    unsigned char kept[16];
    char ip[TEXT_BYTES];
    const bool ipv4 = is_ipv4(address);
    memcpy(kept, address, sizeof kept);
    if (!ipv4 && !pen_http_address_is_loopback(address))
        memset(kept + 8, 0, 8); /* the network alone */
    text[0] = '\0';
    if (memcmp(kept, unknown, sizeof kept) != 0 &&
        inet_ntop(ipv4 ? AF_INET : AF_INET6, ipv4 ? kept + 12 : kept, ip, sizeof ip))
        snprintf(text, bytes, "address:%s", ip);
}
