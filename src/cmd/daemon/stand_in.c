/* SPDX-License-Identifier: MIT */
/* One connection after the other, each with one short answer: there is nothing else to serve. A
 * client that sends slowly, or nothing, or reads nothing holds up the others for CLIENT_MS. */
#include "cmd/daemon/stand_in.h"

#include <poll.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/buf.h"
#include "base/clock.h"
#include "jobs/jobs.h"

enum { STEP_MS = 100, CLIENT_MS = 200, REQUEST_BYTES = 8192 };

static bool make_answer(const struct pen_status *reason, struct pen_buf *answer)
{
    struct pen_status st;
    pen_fail(&st, PEN_UNAVAILABLE, "the store cannot be opened: %s", reason->msg);
    json_t *problem = pen_problem(&st);
    char *text = problem ? json_dumps(problem, JSON_COMPACT) : NULL;
    pen_buf_printf(answer,
                   "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/problem+json\r\n"
                   "Content-Length: %zu\r\nRetry-After: 5\r\nCache-Control: no-store\r\n"
                   "Connection: close\r\n\r\n%s",
                   text ? strlen(text) : 0, text ? text : "");
    json_decref(problem);
    free(text);
    return !answer->failed;
}

/* Waits until there is something to read from a client, but not beyond a time. */
static bool is_readable(int fd, int64_t until_ns)
{
    struct pollfd client = {.fd = fd, .events = POLLIN};
    const int64_t left_ms = (until_ns - pen_clock_ns()) / 1000000;
    return left_ms > 0 && poll(&client, 1, (int)left_ms) > 0;
}

/* Reads the head of the request, or what comes of it in time: a client whose request was not read
 * would see a reset instead of the answer. So does one that goes on sending for longer. */
static void answer_client(int fd, const struct pen_buf *answer)
{
    static char request[REQUEST_BYTES];
    const int64_t until_ns = pen_clock_ns() + CLIENT_MS * INT64_C(1000000);
    size_t have = 0;
    ssize_t got = 1;
    while (got > 0 && have < sizeof request && !memmem(request, have, "\r\n\r\n", 4)) {
        got = is_readable(fd, until_ns)
                  ? recv(fd, request + have, sizeof request - have, MSG_DONTWAIT)
                  : 0;
        have += got > 0 ? (size_t)got : 0;
    }
    /* The answer fits into an empty socket. */
    if (send(fd, answer->data, answer->bytes, MSG_NOSIGNAL | MSG_DONTWAIT) > 0) {
        shutdown(fd, SHUT_WR);
        while (is_readable(fd, until_ns) && recv(fd, request, sizeof request, MSG_DONTWAIT) > 0)
            continue;
    }
    close(fd);
}

/* Waits for a client or an event; returns false if the process has to end. */
static bool wait_for_client(int listen_fd, struct pen_event_source *events, bool *client)
{
    struct pollfd listening = {.fd = listen_fd, .events = POLLIN};
    struct pen_event event;
    *client = poll(&listening, 1, STEP_MS) > 0;
    pen_event_source_next(events, 0, &event);
    return event.kind != PEN_EVENT_STOP && event.kind != PEN_EVENT_LOST;
}

void pen_stand_in(int listen_fd, struct pen_event_source *events, const struct pen_status *reason,
                  int64_t ms)
{
    struct pen_buf answer = {0};
    int64_t until = pen_clock_ns() + ms * 1000000;
    bool client;
    if (make_answer(reason, &answer)) {
        while (pen_clock_ns() < until && wait_for_client(listen_fd, events, &client)) {
            int fd = client ? accept4(listen_fd, NULL, NULL, SOCK_CLOEXEC) : -1;
            if (fd >= 0)
                answer_client(fd, &answer);
        }
    }
    pen_buf_release(&answer);
}
