/* SPDX-License-Identifier: MIT */
/* A vanished member gets a socket filter that drops every packet from the server. It acknowledges
 * and sends nothing, as after a cable was pulled. */
#include "load/crowd.h"

#include <errno.h>
#include <linux/filter.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "load/client.h"

const char *const member_names[MEMBER_KINDS] = {
    [MEMBER_IDLE] = "idle",      [MEMBER_TRICKLE] = "trickling", [MEMBER_HALF] = "half",
    [MEMBER_UPLOAD] = "upload",  [MEMBER_VANISHED] = "vanished", [MEMBER_POLL] = "polls",
    [MEMBER_STREAM] = "streams", [MEMBER_READER] = "readers"};

enum { ANSWER_BYTES = 16 };

struct member {
    int fd; /* -1: closed */
    enum member_kind kind;
    bool again, vanished, refused;
    int number;
    size_t sent; /* of a text that is sent byte by byte */
    char answer[ANSWER_BYTES];
    size_t received;
};

struct crowd {
    struct crowd_options options;
    int epoll_fd;
    int64_t byte_ns; /* when the next bytes are sent and read */
    int count, capacity, kinds[MEMBER_KINDS];
    struct member *member;
};

static void fail(const char *what)
{
    fprintf(stderr, "load: %s: %s\n", what, strerror(errno));
    exit(2);
}

struct crowd *crowd_new(const struct crowd_options *options)
{
    struct crowd *crowd = calloc(1, sizeof *crowd);
    if (!crowd || (crowd->epoll_fd = epoll_create1(EPOLL_CLOEXEC)) < 0)
        fail("epoll");
    crowd->options = *options;
    return crowd;
}

static void send_text(const struct member *member, const char *text)
{
    (void)!send(member->fd, text, strlen(text), MSG_NOSIGNAL);
}

/* Sends what a member of this kind sends at its beginning. */
static void greet(const struct crowd *crowd, const struct member *member)
{
    char text[400];
    const char *path = "/healthz", *end = "\r\n";
    switch (member->kind) {
    case MEMBER_IDLE:
    case MEMBER_VANISHED:
        break;
    case MEMBER_HALF:
        end = "X-Half: ";
        break;
    case MEMBER_POLL:
    case MEMBER_STREAM:
        path = crowd->options.job;
        break;
    case MEMBER_READER:
        path = crowd->options.picture;
        break;
    case MEMBER_UPLOAD:
        send_text(member, "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                          "Content-Length: 1000000\r\n\r\n");
        return;
    case MEMBER_TRICKLE:
    case MEMBER_KINDS:
        return;
    }
    snprintf(text, sizeof text, "GET %s%s HTTP/1.1\r\nHost: localhost\r\n%s", path,
             member->kind == MEMBER_POLL     ? "?wait=60"
             : member->kind == MEMBER_STREAM ? "/events"
                                             : "",
             end);
    send_text(member, text);
}

static void open_member(struct crowd *crowd, int i)
{
    struct member *member = &crowd->member[i];
    member->fd = load_connect(crowd->options.port, member->kind == MEMBER_READER ? 4096 : 0);
    member->sent = member->received = 0;
    member->refused = false;
    greet(crowd, member);
    bool slow = member->kind == MEMBER_READER;
    struct epoll_event event = {.events = slow ? EPOLLRDHUP : EPOLLIN | EPOLLRDHUP,
                                .data.u32 = (uint32_t)i};
    if (epoll_ctl(crowd->epoll_fd, EPOLL_CTL_ADD, member->fd, &event) != 0)
        fail("epoll_ctl");
}

void crowd_add(struct crowd *crowd, enum member_kind kind, int count, bool again)
{
    for (int i = 0; i < count; i++) {
        if (crowd->count == crowd->capacity) {
            crowd->capacity = crowd->capacity ? 2 * crowd->capacity : 1024;
            crowd->member = realloc(crowd->member, (size_t)crowd->capacity * sizeof *crowd->member);
            if (!crowd->member)
                fail("members");
        }
        crowd->member[crowd->count] = (struct member){.kind = kind, .again = again};
        crowd->member[crowd->count].number = crowd->kinds[kind]++;
        open_member(crowd, crowd->count++);
        if (i % 64 == 63)
            crowd_run(crowd, 0);
    }
}

/* Drops all packets that come for a socket from now on. */
static void vanish(struct member *member)
{
    struct sock_filter nothing[] = {BPF_STMT(BPF_RET | BPF_K, 0)};
    struct sock_fprog program = {.len = 1, .filter = nothing};
    if (setsockopt(member->fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) != 0)
        fail("SO_ATTACH_FILTER");
    member->vanished = true;
}

static void close_member(struct member *member)
{
    if (member->fd >= 0)
        close(member->fd);
    member->fd = -1;
}

/* Reads what has come. Returns whether the connection is open. */
static bool read_some(struct member *member, size_t most)
{
    static char part[65536];
    ssize_t got = recv(member->fd, part, most < sizeof part ? most : sizeof part, MSG_DONTWAIT);
    if (got <= 0)
        return got < 0 && errno == EAGAIN;
    size_t room = ANSWER_BYTES - 1 - member->received;
    size_t kept = (size_t)got < room ? (size_t)got : room;
    memcpy(member->answer + member->received, part, kept);
    member->received += kept;
    member->answer[member->received] = '\0';
    if (member->received >= 12)
        member->refused = strncmp(member->answer + 9, "200", 3) != 0;
    return true;
}

static void serve(struct crowd *crowd, int i, uint32_t events)
{
    struct member *member = &crowd->member[i];
    if (member->fd < 0 || member->vanished)
        return;
    bool open = !(events & (EPOLLERR | EPOLLHUP)) && read_some(member, sizeof(char) << 16);
    if (!open) {
        close_member(member);
        if (member->again)
            open_member(crowd, i);
        return;
    }
    bool vanishes = member->kind == MEMBER_VANISHED ||
                    (member->kind == MEMBER_STREAM && member->number % 2 == 0);
    if (vanishes && member->received >= 12)
        vanish(member);
}

/* Sends one byte of a text, or reads a little of a picture. */
static void trickle(struct crowd *crowd, int i)
{
    static const char text[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX-Slow: ";
    struct member *member = &crowd->member[i];
    if (member->fd < 0)
        return;
    char c =
        member->kind == MEMBER_UPLOAD || member->sent >= sizeof text - 1 ? 'a' : text[member->sent];
    if (member->kind == MEMBER_TRICKLE || member->kind == MEMBER_UPLOAD) {
        (void)!send(member->fd, &c, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
        member->sent++;
    } else if (member->kind == MEMBER_READER && !read_some(member, 4096)) {
        close_member(member);
    }
}

void crowd_run(struct crowd *crowd, int ms)
{
    struct epoll_event events[256];
    int64_t until = pen_clock_ns() + ms * INT64_C(1000000), now;
    do {
        int n = epoll_wait(crowd->epoll_fd, events, 256, ms > 50 ? 50 : ms);
        for (int i = 0; i < n; i++)
            serve(crowd, (int)events[i].data.u32, events[i].events);
        now = pen_clock_ns();
        if (now < crowd->byte_ns)
            continue;
        crowd->byte_ns = now + crowd->options.trickle_ms * INT64_C(1000000);
        for (int i = 0; i < crowd->count; i++)
            trickle(crowd, i);
    } while (now < until);
}

int crowd_count(const struct crowd *crowd, enum member_kind kind)
{
    int count = 0;
    for (int i = 0; i < crowd->count; i++) {
        const struct member *member = &crowd->member[i];
        count += member->kind == kind && member->fd >= 0 && !member->refused;
    }
    return count;
}

int crowd_vanished(const struct crowd *crowd)
{
    int count = 0;
    for (int i = 0; i < crowd->count; i++)
        count += crowd->member[i].fd >= 0 && crowd->member[i].vanished;
    return count;
}

void crowd_leave(struct crowd *crowd)
{
    for (int i = 0; i < crowd->count; i++) {
        crowd->member[i].again = false;
        if (!crowd->member[i].vanished)
            close_member(&crowd->member[i]);
    }
}

void crowd_free(struct crowd *crowd)
{
    for (int i = 0; i < crowd->count; i++)
        close_member(&crowd->member[i]);
    close(crowd->epoll_fd);
    free(crowd->member);
    free(crowd);
}
