/* SPDX-License-Identifier: MIT */
/* A backend for the test of the front. It answers every request with 200. It prints each request as
 * a line: `plain` or the fault of its form, a tab, and its bytes, with CR as \r and LF as \n.
 *
 *     record      prints `port N` first, then serves until it is killed
 *
 * A plain request can be read in one way only. It has a request line of three words, lines that end
 * in CRLF, no control bytes, no space before a colon, one Host, and either Content-Length or
 * chunks. */
#include <arpa/inet.h>
#include <ctype.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

enum { REQUEST_BYTES = 65536 };

struct form {
    int hosts, lengths, chunked;
    long body_bytes;
};

/* Returns the fault of a line of fields, NULL if there is none. */
static const char *check_field(const char *line, struct form *form)
{
    size_t name = strspn(line, "!#$%&'*+-.^_`|~0123456789abcdefghijklmnopqrstuvwxyz"
                               "ABCDEFGHIJKLMNOPQRSTUVWXYZ");
    if (name == 0 || line[name] != ':')
        return "field name";
    const char *value = line + name + 1 + strspn(line + name + 1, " ");
    if (name == 4 && strncasecmp(line, "host", name) == 0)
        form->hosts++;
    if (name == 17 && strncasecmp(line, "transfer-encoding", name) == 0)
        form->chunked += strcmp(value, "chunked") == 0 ? 1 : 2;
    if (name == 14 && strncasecmp(line, "content-length", name) == 0) {
        form->lengths++;
        form->body_bytes = strtol(value, NULL, 10);
        if (!*value || value[strspn(value, "0123456789")])
            return "length";
    }
    return NULL;
}

static const char *check_request_line(const char *line)
{
    char method[20], target[4096], version[20], more;
    if (sscanf(line, "%19s %4095s %19s %c", method, target, version, &more) != 3 ||
        strlen(method) + strlen(target) + strlen(version) + 2 != strlen(line))
        return "request line";
    if (target[0] != '/' || strncmp(version, "HTTP/1.", 7) != 0)
        return "target or version";
    return NULL;
}

/* Takes a head apart, without its last empty line; `head` is changed. */
static const char *check_head(char *head, size_t bytes, struct form *form)
{
    const char *fault = memchr(head, '\0', bytes) ? "zero byte" : NULL;
    int lines = 0;
    for (char *line = head, *end; !fault && *line; line = end + 2) {
        end = strstr(line, "\r\n");
        *end = '\0';
        for (const char *at = line; *at; at++)
            fault = iscntrl((unsigned char)*at) ? "control byte" : fault;
        if (!fault)
            fault = lines++ ? check_field(line, form) : check_request_line(line);
    }
    if (!fault && form->hosts != 1)
        fault = "hosts";
    if (!fault && form->lengths + form->chunked > 1)
        fault = "framing";
    return fault;
}

static void print_request(const char *fault, const char *text, size_t bytes)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* guards standard output */
    pthread_mutex_lock(&lock);
    printf("%s\t", fault ? fault : "plain");
    for (size_t i = 0; i < bytes; i++) {
        if (text[i] == '\r' || text[i] == '\n')
            printf("%s", text[i] == '\r' ? "\\r" : "\\n");
        else
            putchar(isprint((unsigned char)text[i]) ? text[i] : '?');
    }
    printf("\n");
    fflush(stdout);
    pthread_mutex_unlock(&lock);
}

/* Reads until the buffer has at least so many bytes behind the head, or a head if `bytes` is 0.
 * Returns the length of the head, 0 at the end of the connection. */
static size_t read_until(int fd, char *text, size_t *have, size_t bytes)
{
    for (;;) {
        text[*have] = '\0';
        char *end = memmem(text, *have, "\r\n\r\n", 4);
        if (end && (size_t)(end - text) + 4 + bytes <= *have)
            return (size_t)(end - text) + 4;
        ssize_t got =
            *have + 1 < REQUEST_BYTES ? recv(fd, text + *have, REQUEST_BYTES - 1 - *have, 0) : 0;
        if (got <= 0)
            return 0;
        *have += (size_t)got;
    }
}

static void *serve(void *arg)
{
    static const char answer[] = "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\n"
                                 "Content-Length: 8\r\n\r\n{\"ok\":1}";
    static _Thread_local char text[REQUEST_BYTES], copy[REQUEST_BYTES];
    int fd = (int)(intptr_t)arg;
    size_t have = 0, head;
    while ((head = read_until(fd, text, &have, 0)) > 0) {
        struct form form = {0};
        memcpy(copy, text, head);
        copy[head - 2] = '\0';
        const char *fault = check_head(copy, head - 2, &form);
        if (form.chunked && !fault)
            fault = "chunks"; /* a front that collects bodies knows their lengths */
        size_t all = head + (size_t)form.body_bytes;
        if (!fault && read_until(fd, text, &have, (size_t)form.body_bytes) == 0)
            fault = "body";
        print_request(fault, text, fault ? have : all);
        if (fault || send(fd, answer, sizeof answer - 1, MSG_NOSIGNAL) < 0)
            break;
        have -= all;
        memmove(text, text + all, have);
    }
    close(fd);
    return NULL;
}

int main(void)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t bytes = sizeof address;
    int listening = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (bind(listening, (struct sockaddr *)&address, bytes) != 0 || listen(listening, 64) != 0 ||
        getsockname(listening, (struct sockaddr *)&address, &bytes) != 0)
        return 2;
    printf("port %d\n", ntohs(address.sin_port));
    fflush(stdout);
    for (;;) {
        pthread_t thread;
        int fd = accept(listening, NULL, NULL);
        if (fd >= 0 && pthread_create(&thread, NULL, serve, (void *)(intptr_t)fd) == 0)
            pthread_detach(thread);
    }
}
