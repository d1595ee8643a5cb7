/* SPDX-License-Identifier: MIT */
/* Slow clients, all at once, and the seconds after which the server closes each: 50 s.
 *
 *     deadlines PORT PICTURE [check]
 *         PICTURE is the path of an answer of some MB. With check, exit 1 if a client that is too
 *         slow was kept for too long, or if a client that is fast enough was closed within 40 s. */
#include <errno.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "load/cases.h"
#include "load/client.h"

enum { LAST_S = 50, KEPT_S = 40, TICK_MS = 50, WINDOW_BYTES = 4096, PIECE_BYTES = 3072 };

#define POST "POST /v1/jobs HTTP/1.1\r\n" LOAD_HOST
#define BODY POST "Content-Length: 1000000\r\n\r\n"

static const struct slow {
    const char *name, *first; /* what is sent at once; NULL: the request for the picture */
    int every_ms, bytes;      /* after it: as many bytes every so often; 0: nothing */
    int read_rate;            /* of the picture, bytes per second; -1: none, 0: reads all */
    int most_s;               /* it must be closed by then; KEPT_S: it must be open */
} clients[] = {
    {"connects only", "", 0, 0, 0, 12},
    {"request line, a byte in 0.9 s", "GET /", 900, 1, 0, 12},
    {"head, a byte in 0.9 s", LOAD_GET LOAD_HOST "X: ", 900, 1, 0, 12},
    {"idle after an answer", LOAD_GOOD, 0, 0, 0, 32},
    {"body, nothing comes", BODY, 0, 0, 0, 22},
    {"body, a byte in 0.9 s", BODY, 900, 1, 0, 22},
    {"body, 6 KiB/s", BODY, 500, PIECE_BYTES, 0, KEPT_S},
    {"chunked body, a byte in 0.9 s", POST "Transfer-Encoding: chunked\r\n\r\nffff\r\n", 900, 1, 0,
     22},
    {"reader, nothing taken", NULL, 0, 0, -1, 45},
    {"reader, 1 KiB/s", NULL, 0, 0, 1024, 45},
    {"reader, 8 KiB/s", NULL, 0, 0, 8192, KEPT_S},
};
enum { COUNT = sizeof clients / sizeof clients[0] };

struct state {
    int fd;
    double begun, sent_at, closed_s; /* closed_s: 0 while it is open */
    long taken;
    char answer[16];
};

static void begin(struct state *state, const struct slow *slow, int port, const char *picture)
{
    char request[1000];
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\n" LOAD_HOST "\r\n", picture);
    *state = (struct state){.fd = load_connect(port, slow->read_rate ? WINDOW_BYTES : 0)};
    const char *first = slow->first ? slow->first : request;
    load_send(state->fd, first, strlen(first));
    state->begun = state->sent_at = load_seconds();
}

/* Takes what its rate allows. Returns false if the connection has ended. */
static bool take(struct state *state, const struct slow *slow, double now)
{
    char part[65536];
    size_t most = sizeof part;
    struct pollfd ended = {.fd = state->fd, .events = POLLRDHUP};
    if (slow->read_rate < 0)
        return poll(&ended, 1, 0) == 0;
    if (slow->read_rate > 0) {
        long allowed = (long)((now - state->begun) * slow->read_rate) - state->taken;
        most = allowed > 0 ? (size_t)allowed : 0;
    }
    if (!most)
        return true;
    ssize_t got = recv(state->fd, part, most < sizeof part ? most : sizeof part, MSG_DONTWAIT);
    if (got <= 0)
        return got < 0 && errno == EAGAIN;
    if (state->taken == 0 && got > 12)
        snprintf(state->answer, sizeof state->answer, "%.3s", part + 9);
    state->taken += got;
    return true;
}

static bool give(struct state *state, const struct slow *slow, double now)
{
    static const char piece[PIECE_BYTES] = "a";
    if (!slow->every_ms || now - state->sent_at < slow->every_ms * 1e-3)
        return true;
    state->sent_at = now;
    return load_send(state->fd, piece, (size_t)slow->bytes);
}

static bool is_due(const struct state *state, const struct slow *slow)
{
    if (slow->most_s == KEPT_S)
        return state->closed_s == 0 || state->closed_s >= KEPT_S;
    return state->closed_s > 0 && state->closed_s <= slow->most_s;
}

static bool print(const struct state *state, const struct slow *slow, bool judged)
{
    char when[40] = "open after 50 s";
    bool due = !judged || is_due(state, slow);
    if (state->closed_s > 0)
        snprintf(when, sizeof when, "%.1f s", state->closed_s);
    printf("%-32s%-18s%-5s", slow->name, when, state->answer);
    if (slow->read_rate)
        printf("%ld KiB taken", state->taken >> 10);
    printf("%s\n", due ? "" : " wrong");
    return due;
}

int main(int argc, char **argv)
{
    static struct state states[COUNT];
    if (argc < 3 || argc > 4) {
        fprintf(stderr, "usage: deadlines PORT PICTURE [check]\n");
        return 2;
    }
    double begun = load_seconds(), now = begun;
    int wrong = 0;
    for (int i = 0; i < COUNT; i++)
        begin(&states[i], &clients[i], atoi(argv[1]), argv[2]);
    while (now - begun < LAST_S) {
        poll(NULL, 0, TICK_MS);
        now = load_seconds();
        for (int i = 0; i < COUNT; i++) {
            struct state *state = &states[i];
            if (state->closed_s == 0 &&
                !(give(state, &clients[i], now) && take(state, &clients[i], now)))
                state->closed_s = now - state->begun;
        }
    }
    for (int i = 0; i < COUNT; i++)
        wrong += !print(&states[i], &clients[i], argc > 3);
    return wrong > 0;
}
