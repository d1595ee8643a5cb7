/* SPDX-License-Identifier: MIT */
#include "load/client.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"

int load_try(int port, int receive_bytes)
{
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)port),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return -1;
    if (receive_bytes)
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
    if (connect(fd, (struct sockaddr *)&address, sizeof address) == 0)
        return fd;
    int error = errno;
    close(fd);
    errno = error;
    return -1;
}

int load_connect(int port, int receive_bytes)
{
    int fd = load_try(port, receive_bytes);
    if (fd >= 0)
        return fd;
    fprintf(stderr, "load: no connection to port %d: %s\n", port, strerror(errno));
    exit(2);
}

bool load_send(int fd, const void *bytes, size_t count)
{
    for (const char *at = bytes; count > 0;) {
        ssize_t sent = send(fd, at, count, MSG_NOSIGNAL);
        if (sent <= 0)
            return false;
        at += sent;
        count -= (size_t)sent;
    }
    return true;
}

enum load_end load_read(int fd, int quiet_ms, const char *until, char *text, size_t room)
{
    char part[65536];
    struct pollfd readable = {.fd = fd, .events = POLLIN};
    text[0] = '\0';
    for (size_t kept = 0;;) {
        if (poll(&readable, 1, quiet_ms) <= 0)
            return LOAD_OPEN;
        ssize_t got = recv(fd, part, sizeof part, 0);
        if (got <= 0)
            return got < 0 ? LOAD_RESET : LOAD_CLOSED;
        size_t more = (size_t)got < room - 1 - kept ? (size_t)got : room - 1 - kept;
        for (size_t i = 0; i < more; i++)
            text[kept++] = (char)(part[i] ? part[i] : ' ');
        text[kept] = '\0';
        if (until && strstr(text, until))
            return LOAD_OPEN;
    }
}

int load_status(const char *text, const char **rest)
{
    int minor, status;
    for (const char *at = text; (at = strstr(at, "HTTP/1."));) {
        bool found = sscanf(at, "HTTP/1.%1d %3d ", &minor, &status) == 2;
        at += strlen("HTTP/1.");
        if (rest)
            *rest = at;
        if (found && status >= 200)
            return status;
    }
    return 0;
}

double load_seconds(void)
{
    return (double)pen_clock_ns() * 1e-9;
}
