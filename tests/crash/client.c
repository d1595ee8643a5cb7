/* SPDX-License-Identifier: MIT */
#include "client.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

/* So long that no answer is given up that comes: what was asked for would be done later. */
enum { TIMEOUT_S = 20, REQUEST_BYTES = 8192 };

static int connect_to(int port)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    struct timeval timeout = {.tv_sec = TIMEOUT_S};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
    if (fd >= 0 && connect(fd, (struct sockaddr *)&address, sizeof address) == 0)
        return fd;
    close(fd);
    return -1;
}

/* Receives until the other side closes the connection. Returns the length. */
static size_t receive(int fd, char *text, size_t bytes)
{
    size_t length = 0;
    for (ssize_t got; length + 1 < bytes; length += (size_t)got) {
        got = recv(fd, text + length, bytes - 1 - length, 0);
        if (got <= 0)
            break;
    }
    text[length] = '\0';
    return length;
}

/* Takes the answer if it is complete: its head, and as many bytes as Content-Length says. */
static void take_answer(const char *text, struct answer *answer)
{
    const char *head_end = strstr(text, "\r\n\r\n"),
               *length = strcasestr(text, "\r\nContent-Length:");
    int status = 0;
    if (sscanf(text, "HTTP/1.1 %d", &status) != 1 || !head_end)
        return;
    size_t bytes = length && length < head_end ? strtoul(length + 17, NULL, 10) : 0;
    if (strlen(head_end + 4) < bytes)
        return;
    answer->status = status;
    snprintf(answer->body, sizeof answer->body, "%s", head_end + 4);
}

int client_call(int port, const char *method, const char *path, const char *key, const char *from,
                const char *body, struct answer *answer)
{
    char request[REQUEST_BYTES], text[ANSWER_BYTES];
    *answer = (struct answer){0};
    int fd = connect_to(port);
    if (fd < 0)
        return 0;
    int bytes =
        snprintf(request, sizeof request,
                 "%s %s HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n"
                 "Content-Type: application/json\r\nContent-Length: %zu\r\n%s%s%s%s%s%s\r\n%s",
                 method, path, port, body ? strlen(body) : 0, key ? "Idempotency-Key: " : "",
                 key ? key : "", key ? "\r\n" : "", from ? "X-Forwarded-For: " : "",
                 from ? from : "", from ? "\r\n" : "", body ? body : "");
    if (send(fd, request, (size_t)bytes, MSG_NOSIGNAL) == bytes && receive(fd, text, sizeof text))
        take_answer(text, answer);
    close(fd);
    return answer->status;
}
