/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool fail_form(const char *text, struct pen_status *st)
{
    return pen_fail(
        st, PEN_USAGE,
        "listen: found \"%s\", allowed is HOST:PORT with a numeric address or localhost, "
        "such as 127.0.0.1:8080, localhost:0, 0.0.0.0:8080 or [::]:8080",
        text);
}

static bool read_port(const char *text, int *port)
{
    size_t length = strlen(text);
    if (length == 0 || length > 5 || strspn(text, "0123456789") != length)
        return false;
    *port = atoi(text);
    return *port <= 65535;
}

static bool make_ipv4(const char *host, int port, struct pen_address *address)
{
    struct sockaddr_in in = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    if (inet_pton(AF_INET, strcmp(host, "localhost") == 0 ? "127.0.0.1" : host, &in.sin_addr) != 1)
        return false;
    memcpy(&address->socket, &in, sizeof in);
    address->bytes = sizeof in;
    return true;
}

static bool make_ipv6(const char *host, int port, struct pen_address *address)
{
    struct sockaddr_in6 in = {.sin6_family = AF_INET6, .sin6_port = htons((uint16_t)port)};
    char bare[64];
    size_t length = strlen(host);
    if (length < 4 || host[0] != '[' || host[length - 1] != ']')
        return false;
    memcpy(bare, host + 1, length - 2);
    bare[length - 2] = '\0';
    if (inet_pton(AF_INET6, bare, &in.sin6_addr) != 1)
        return false;
    memcpy(&address->socket, &in, sizeof in);
    address->bytes = sizeof in;
    return true;
}

bool pen_address_is_loopback(const struct pen_address *address)
{
    if (address->socket.ss_family == AF_INET6) {
        struct sockaddr_in6 in;
        memcpy(&in, &address->socket, sizeof in);
        return IN6_IS_ADDR_LOOPBACK(&in.sin6_addr);
    }
    struct sockaddr_in in;
    memcpy(&in, &address->socket, sizeof in);
    return ntohl(in.sin_addr.s_addr) == INADDR_LOOPBACK;
}

bool pen_address_parse(const char *text, struct pen_address *address, struct pen_status *st)
{
    int port;
    const char *colon = strrchr(text, ':');
    size_t length = colon ? (size_t)(colon - text) : 0;
    *address = (struct pen_address){0};
    if (length == 0 || length >= sizeof address->host || !read_port(colon + 1, &port))
        return fail_form(text, st);
    memcpy(address->host, text, length);
    return make_ipv4(address->host, port, address) || make_ipv6(address->host, port, address) ||
           fail_form(text, st);
}

static int port_in(const struct sockaddr_storage *socket)
{
    if (socket->ss_family == AF_INET6) {
        struct sockaddr_in6 in;
        memcpy(&in, socket, sizeof in);
        return ntohs(in.sin6_port);
    }
    struct sockaddr_in in;
    memcpy(&in, socket, sizeof in);
    return ntohs(in.sin_port);
}

static int port_of(int fd)
{
    struct sockaddr_storage bound;
    socklen_t bytes = sizeof bound;
    return getsockname(fd, (struct sockaddr *)&bound, &bytes) == 0 ? port_in(&bound) : -1;
}

/* Returns what to do about an error of socket() or bind(). */
static const char *advice(int error)
{
    switch (error) {
    case EADDRINUSE:
        return "; another program listens there, perhaps another penumbrad: stop it, or give "
               "another port with --listen (HOST:0 takes any free one)";
    case EADDRNOTAVAIL:
        return "; this machine does not have that address: give one that it has with --listen "
               "(0.0.0.0 or [::] for all)";
    case EACCES:
        return "; this user may not take that port: give one from 1024 on with --listen";
    default:
        return "";
    }
}

int pen_address_listen(const struct pen_address *address, int *port, struct pen_status *st)
{
    int on = 1;
    int fd = socket(address->socket.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
        bind(fd, (const struct sockaddr *)&address->socket, address->bytes) == 0 &&
        listen(fd, SOMAXCONN) == 0 && (*port = port_of(fd)) > 0)
        return fd;
    pen_fail(st, PEN_UNAVAILABLE, "cannot listen on %s:%d: %s%s", address->host,
             port_in(&address->socket), strerror(errno), advice(errno));
    if (fd >= 0)
        close(fd);
    return -1;
}
