/* SPDX-License-Identifier: MIT */
/* Clients that hold connections without using them: they are sent away, or give way, or are found
 * to be gone, and others are answered meanwhile. */
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "http/internal/http.h"
#include "support/server.h"
#include "support/suite.h"

/* A client that sends a little now and then is never idle, but has not longer for it. */
START_TEST(test_connections__slow_requests_are_ended)
{
    static const char *const beginnings[] = {
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: ",
        ("POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n"),
        ("POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: "
         "chunked\r\n\r\nffff\r\n")};
    struct server server;
    struct pollfd open[3];
    server_start(&server, &(struct server_options){.idle_seconds = 4 * client_patience()});
    for (int i = 0; i < 3; i++) {
        open[i] = (struct pollfd){.fd = server_connect(&server), .events = POLLIN};
        client_send(open[i].fd, beginnings[i]);
    }
    for (int parts = 0, left = 3; parts < 400 && left > 0; parts++) {
        client_pause(100);
        left = 0;
        for (int i = 0; i < 3; i++) {
            const bool waits = poll(&open[i], 1, 0) == 0;
            left += waits && client_send(open[i].fd, "a");
        }
    }
    for (int i = 0; i < 3; i++) {
        struct answer answer;
        client_read(open[i].fd, false, &answer);
        ck_assert_msg(answer.status == 408, "%d: %d", i, answer.status);
        answer_release(&answer);
        ck_assert(client_sees_end(open[i].fd));
        close(open[i].fd);
    }
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

/* What a body has brought early does not let it be slow later. */
START_TEST(test_connections__early_bytes_buy_no_time)
{
    enum { EARLY = 1000000, PARTS = 16, PART = 16384 }; /* at this rate a part comes every 4 s */
    struct server server;
    struct answer answer;
    char head[120], *early = malloc(EARLY + 1);
    server_start(&server, &(struct server_options){.idle_seconds = 10});
    memset(early, ' ', EARLY);
    early[EARLY] = '\0';
    const int slow = server_connect(&server), fd = server_connect(&server);
    snprintf(head, sizeof head,
             "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n", EARLY + 1);
    ck_assert(client_send(slow, head) && client_send(slow, early));
    early[PART] = '\0';
    snprintf(head, sizeof head,
             "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n",
             PARTS * PART);
    client_send(fd, head);
    for (int i = 0; i < PARTS; i++) { /* longer than the time, and faster than the rate */
        client_pause(700);
        ck_assert(client_send(fd, early));
    }
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 400); /* spaces are no JSON */
    answer_release(&answer);
    close(fd);
    client_read(slow, false, &answer);
    ck_assert_int_eq(answer.status, 408);
    answer_release(&answer);
    close(slow);
    free(early);
    server_stop(&server);
}
END_TEST

/* Submits a job and opens `count` long polls of it. Returns when all of them are at work. */
static void fill_with_polls(const struct server *server, char path[80], int *fds, int count)
{
    server_submit(server, path);
    for (int i = 0; i < 400 && atomic_load(&server->http->connections) > 0; i++)
        client_pause(50);
    server_open_polls(server, path, "", fds, count);
    for (int i = 0; i < 400 && atomic_load(&server->http->active) < count; i++)
        client_pause(50);
}

/* Waits until the server has looked at all connections that were opened, and then until none of
 * them is fresh any more. */
static void let_them_grow_old(struct server *server)
{
    for (int i = 0; i < 400 && atomic_load(&server->http->arriving) > 0; i++)
        client_pause(50);
    client_pause(1500);
}

START_TEST(test_connections__idle_connections_give_way)
{
    enum { OPEN = 20, ALLOWED = OPEN + RESERVED_SLOTS, ALL = 2 * ALLOWED };
    struct server server;
    server_start(&server, &(struct server_options){.connections = OPEN});
    int fds[ALL];
    for (int i = 0; i < ALL; i++) {
        fds[i] = server_connect(&server);
        client_send(fds[i], i % 2 ? "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n" : "GET /");
    }
    let_them_grow_old(&server);
    for (int i = 0; i < 2 * OPEN; i++)
        server_expect_alive(&server);
    int open = 0;
    for (int i = 0; i < ALL; i++) {
        open += !client_has_seen_end(fds[i]);
        close(fds[i]);
    }
    ck_assert_int_le(open, ALLOWED);
    server_stop(&server);
}
END_TEST

/* All but one connection are at work. Whoever takes the last place does not lose it to the next one
 * before it could send anything: there are reserved slots for that one. */
START_TEST(test_connections__fresh_connections_keep_their_place)
{
    enum { OPEN = 20, ROUNDS = 10, TRIES = 50 };
    static const char head[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    struct server server;
    server_start(&server, &(struct server_options){.connections = OPEN});
    char path[80];
    int polls[OPEN - 1], judged = 0;
    fill_with_polls(&server, path, polls, OPEN - 1);
    for (int i = 0; i < TRIES && judged < ROUNDS; i++) {
        struct answer answer;
        const int64_t begun_ns = pen_clock_ns();
        const int fresh = server_connect(&server);
        for (int k = 0; k < 4; k++)
            ck_assert_int_eq(server_status(&server, "GET /healthz HTTP/1.1", NULL), 200);
        client_send(fresh, head);
        client_read(fresh, false, &answer);
        const bool was_fresh = pen_clock_ns() - begun_ns < 900000000;
        ck_assert_msg(answer.status == 200 || !was_fresh, "round %d: no answer", i);
        judged += was_fresh;
        answer_release(&answer);
        close(fresh);
    }
    ck_assert_timed(judged == ROUNDS);
    for (int i = 0; i < OPEN - 1; i++)
        close(polls[i]);
    server_stop(&server);
}
END_TEST

/* Whoever holds all reserved slots with connections of one thread does not silence the others.
 * Connections are dealt out to as many threads as there are CPUs, two to four, in turn. */
START_TEST(test_connections__reserved_slots_of_one_thread_serve_all)
{
    enum { OPEN = 20, PROBES = 4 };
    static const char head[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    struct server server;
    server_start(&server, &(struct server_options){.connections = OPEN});
    char path[80];
    int polls[OPEN], silent[RESERVED_SLOTS], probes[PROBES];
    fill_with_polls(&server, path, polls, OPEN);
    const int cpus = pen_cpu_count(), threads = cpus < 2 ? 2 : cpus > 4 ? 4 : cpus;
    for (int i = 0; i < threads * RESERVED_SLOTS; i++) {
        const int fd = server_connect(&server), kept = (i + 1) / threads;
        if ((i + 1) % threads == 0) {
            silent[kept - 1] = fd;
        } else {
            shutdown(fd, SHUT_WR);
            ck_assert(client_sees_end(fd));
            close(fd);
        }
        for (int k = 0; k < 2000 && atomic_load(&server.http->reserved) != kept; k++)
            client_pause(1);
    }
    let_them_grow_old(&server);
    ck_assert_int_eq(atomic_load(&server.http->reserved), RESERVED_SLOTS);
    for (int i = 0; i < PROBES; i++)
        probes[i] = server_connect(&server);
    for (int i = 0; i < PROBES; i++)
        client_send(probes[i], head);
    for (int i = 0; i < PROBES; i++) {
        struct answer answer;
        client_read(probes[i], false, &answer);
        ck_assert_msg(answer.status == 200, "probe %d: %d", i, answer.status);
        answer_release(&answer);
    }
    for (int i = 0; i < PROBES; i++)
        close(probes[i]);
    for (int i = 0; i < RESERVED_SLOTS; i++)
        close(silent[i]);
    for (int i = 0; i < OPEN; i++)
        close(polls[i]);
    server_stop(&server);
}
END_TEST

/* A body of which no more comes is as idle as a head, also for new connections that come to other
 * threads: connections are dealt out to two to four of these in turn. */
START_TEST(test_connections__half_bodies_give_way)
{
    enum { OPEN = 20, THREADS = 4 };
    struct server server;
    char path[80];
    int fds[OPEN];
    server_start(&server, &(struct server_options){.connections = OPEN});
    for (int i = 0; i < THREADS * OPEN; i++) {
        int fd = server_connect(&server);
        if (i % THREADS) {
            close(fd);
            continue;
        }
        client_send(fd, "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                        "Content-Length: 1000\r\n\r\n{");
        fds[i / THREADS] = fd;
    }
    let_them_grow_old(&server);
    for (int i = 0; i < OPEN; i++)
        server_submit(&server, path);
    for (int i = 0; i < OPEN; i++)
        close(fds[i]);
    server_stop(&server);
}
END_TEST

/* When all connections are at work, some are kept for requests that are answered soon. */
START_TEST(test_connections__short_requests_have_slots_of_their_own)
{
    enum { OPEN = 20 };
    struct server server;
    server_start(&server, &(struct server_options){.connections = OPEN});
    char path[80], head[160];
    int fds[OPEN];
    fill_with_polls(&server, path, fds, OPEN);
    int more[2 * RESERVED_SLOTS];
    for (int i = 0; i < 2 * RESERVED_SLOTS; i++) { /* they do not wait, nor get other slots */
        struct answer answer;
        server_open_polls(&server, path, "", &more[i], 1);
        client_read(more[i], false, &answer);
        ck_assert_int_eq(answer.status, 200);
        answer_release(&answer);
    }
    snprintf(head, sizeof head, "DELETE %s HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 409);
    snprintf(head, sizeof head, "GET %s HTTP/1.1", path);
    /* A list may take longer, and would keep the slot from others. */
    ck_assert_int_eq(server_status(&server, "GET /v1/jobs HTTP/1.1", NULL), 503);
    for (int i = 0; i < OPEN; i++) {
        ck_assert_int_eq(server_status(&server, "GET /healthz HTTP/1.1", NULL), 200);
        ck_assert_int_eq(server_status(&server, "GET /readyz HTTP/1.1", NULL), 200);
        ck_assert_int_eq(server_status(&server, head, NULL), 200);
    }
    ck_assert_int_eq(server_status(&server, "GET /openapi.yaml HTTP/1.1", NULL), 503);
    for (int i = 0; i < OPEN; i++)
        close(fds[i]);
    for (int i = 0; i < 2 * RESERVED_SLOTS; i++)
        close(more[i]);
    server_stop(&server);
}
END_TEST

/* Reads up to `bytes` bytes. Returns how many came before the end. */
static size_t read_bytes(int fd, size_t bytes)
{
    static char part[1 << 16];
    size_t got = 0;
    for (ssize_t now = 1; got < bytes && now > 0; got += now > 0 ? (size_t)now : 0)
        now = recv(fd, part, bytes - got < sizeof part ? bytes - got : sizeof part, 0);
    return got;
}

/* Sends a request. Waits until the answer has come and its side of the connection has ended; then
 * sends more, which must not cost the answer unless the connection was closed at once. Returns
 * whether it was. */
static bool ends_at_once(const struct server *server, const char *request, int status)
{
    struct answer answer;
    const int fd = server_connect(server);
    struct pollfd ended = {.fd = fd, .events = POLLRDHUP};
    ck_assert(client_send(fd, request));
    ck_assert_int_eq(poll(&ended, 1, 10000 * client_patience()), 1);
    client_send(fd, "12345");
    client_pause(100);
    const bool at_once = !client_send(fd, "12345");
    if (at_once) {
        close(fd);
        return true;
    }
    client_read(fd, false, &answer);
    ck_assert_msg(answer.status == status, "%d after %s", answer.status, request);
    answer_release(&answer);
    ck_assert(client_sees_end(fd));
    close(fd);
    return false;
}

/* A connection is closed at once only when new ones come fast, and the client has sent all that it
 * announced; its answer comes whole. Others linger: a client that still sends gets its answer. */
START_TEST(test_connections__lingers_where_more_may_come)
{
    static const struct {
        const char *request;
        int status;
        bool at_once; /* in a rush */
    } rows[] = {
        {"GET / HTTP/1.1\r\nHost : localhost\r\n\r\n", 400, true},
        {"\x16\x03\x01\x02\r\n\r\n", 400, true},
        {"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", 200, true},
        {"POST / HTTP/1.1\r\nHost : localhost\r\nContent-Length: 5\r\n\r\n", 400, false},
        {"POST / HTTP/1.1\r\nHost : localhost\r\ntransfer-encoding: chunked\r\n\r\n", 400, false},
        {"GET / HTTP/1.1\r\nHost : localhost\r\n\r\nGET /healthz", 400, false},
        {"GET / HTTP/1.1\r\nHost: localhost\n\n", 400, false},
        {("POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n"
          "Expect: 100-continue\r\nContent-Type: image/png\r\n\r\n"),
         415, false}};
    struct server server;
    server_start(&server, &(struct server_options){.idle_seconds = 0});
    for (int rush = 0; rush < 2; rush++) {
        atomic_store(&server.http->rush_until_ns, rush ? INT64_MAX : 0);
        for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
            ck_assert_msg(ends_at_once(&server, rows[i].request, rows[i].status) ==
                              (rush && rows[i].at_once),
                          "rush %d: %s", rush, rows[i].request);
        server_expect_alive(&server);
    }
    server_stop(&server);
}
END_TEST

/* Whether the answer to this request closes the connection. */
static bool is_closed_after(int fd, const char *request)
{
    struct answer answer;
    char value[20];
    client_send(fd, request);
    client_read(fd, false, &answer);
    ck_assert_int_ne(answer.status, 0);
    const bool closed =
        strcmp(answer_field(&answer, "Connection", value, sizeof value), "close") == 0;
    answer_release(&answer);
    ck_assert(!closed || client_sees_end(fd));
    return closed;
}

/* In a rush a refusal that is the first answer on its connection closes it, but for a tenth of each
 * second. Whoever uses a connection again keeps it. */
START_TEST(test_connections__refusals_of_a_rush_close)
{
    static const char good[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
    static const char bad[] = "GET /nowhere HTTP/1.1\r\nHost: localhost\r\n\r\n";
    struct server server;
    server_start(&server, &(struct server_options){.idle_seconds = 0});
    for (int i = 0; i < 3; i++) {
        enum { NO_RUSH, FIRST_TENTH, LATER };
        int fd = server_connect(&server);
        const int64_t now_ns = pen_clock_ns();
        atomic_store(&server.http->rush_until_ns, i == NO_RUSH ? 0 : INT64_MAX);
        atomic_store(&server.http->rush_since_ns,
                     i == FIRST_TENTH ? INT64_MAX : now_ns - 110000000); /* of 900 ms */
        ck_assert(is_closed_after(fd, bad) == (i == LATER));
        close(fd);
        fd = server_connect(&server);
        ck_assert(!is_closed_after(fd, good) && !is_closed_after(fd, bad));
        ck_assert(!is_closed_after(fd, bad));
        close(fd);
    }
    server_stop(&server);
}
END_TEST

/* Where a client sends more than it has announced, at the moment when its connection is closed, it
 * still finds its answer. */
START_TEST(test_connections__unannounced_bytes_cost_no_answer)
{
    enum { TRIES = 6000 };
    struct server server;
    server_start(&server, &(struct server_options){.idle_seconds = 0});
    atomic_store(&server.http->rush_until_ns, INT64_MAX);
    for (int i = 0; i < TRIES; i++) {
        struct answer answer;
        const int fd = server_connect(&server);
        client_send(fd, "POST /v1/jobs HTTP/1.0\r\nHost: localhost\r\n\r\n");
        for (const int64_t until_ns = pen_clock_ns() + i % 60 * 1000; pen_clock_ns() < until_ns;)
            continue;
        client_send(fd, "{\"scene\": \"builtin:room\"}");
        client_read(fd, false, &answer);
        ck_assert_msg(answer.status == 411, "%d: %d", i, answer.status);
        answer_release(&answer);
        close(fd);
    }
    server_stop(&server);
}
END_TEST

/* A reader that takes several windows in the time of one keeps its answer, although the kernel
 * could take megabytes of it, and would not ask for more until a third of them was read. One that
 * takes nothing loses it, and so does one that takes a little now and then, but no window in its
 * time. */
START_TEST(test_connections__slow_readers_keep_their_answer)
{
    enum { PART = 1 << 16, PARTS = 24, LEAST = 8000000 }; /* the kernel keeps less than that */
    struct server server;
    struct answer answer;
    char path[80], text[200];
    size_t taken = 0;
    const int factor = client_patience() > 2 ? client_patience() : 2;
    server_start(&server, &(struct server_options){.worker = true, .idle_seconds = 3 * factor});
    server_ask(&server, "POST /v1/jobs HTTP/1.1",
               "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 1000, \"height\": 800}}",
               &answer);
    answer_field(&answer, "Location", path, sizeof path);
    answer_release(&answer);
    snprintf(text, sizeof text, "GET %s/image?format=pfm HTTP/1.1", path);
    int status = 409;
    for (int i = 0; i < 600 && status == 409; i++) {
        client_pause(100);
        status = server_status(&server, text, NULL);
    }
    ck_assert_int_eq(status, 200);
    snprintf(text, sizeof text,
             "GET %s/image?format=pfm HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
             path);
    int slow = server_connect(&server), silent = server_connect(&server);
    int slower = server_connect(&server), little = 4096;
    setsockopt(slower, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    client_send(slow, text);
    client_send(silent, text);
    client_send(slower, text);
    for (int i = 0; i < PARTS; i++) {
        client_pause(250 * factor);
        ck_assert_uint_eq(read_bytes(slow, PART), PART);
        taken += read_bytes(slower, PART / 16);
    }
    ck_assert_uint_gt(read_bytes(slow, SIZE_MAX), LEAST);
    ck_assert_uint_lt(read_bytes(silent, SIZE_MAX), LEAST);
    ck_assert_uint_lt(taken + read_bytes(slower, SIZE_MAX), LEAST);
    close(slower);
    close(slow);
    close(silent);
    server_stop(&server);
}
END_TEST

/* The places of polls whose clients have gone are free soon, though the job does not change. */
START_TEST(test_connections__abandoned_polls_are_forgotten)
{
    enum { WAITING = 530 }; /* more than there are places */
    server_allow_many_files();
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160];
    server_submit(&server, path);
    static int fds[WAITING];
    server_open_polls(&server, path, "", fds, WAITING);
    client_first_answered(fds, WAITING); /* one was refused: all places are taken */
    const struct linger reset = {.l_onoff = 1};
    for (int i = 0; i < WAITING; i++) {
        if (i % 2)
            setsockopt(fds[i], SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        close(fds[i]);
    }
    snprintf(head, sizeof head, "GET %s?wait=1 HTTP/1.1", path);
    int status = 503;
    for (int i = 0; i < 100 && status == 503; i++) {
        status = server_status(&server, head, NULL);
        client_pause(50);
    }
    ck_assert_int_eq(status, 200);
    server_stop(&server);
}
END_TEST

/* Reads all that comes. Returns whether a refusal is in it, perhaps after interim answers. */
static bool ends_with_refusal(int fd)
{
    char text[1 << 14] = "";
    size_t used = 0;
    for (ssize_t got = 1; got > 0; used += got > 0 ? (size_t)got : 0)
        got = recv(fd, text + used, sizeof text - 1 - used, 0);
    return strstr(text, "HTTP/1.1 503 ") != NULL;
}

/* Polls whose clients end their side just when the store has changed, and their jobs are checked:
 * they get no answer, or their job, but are not refused. */
START_TEST(test_connections__abandoned_polls_are_not_refused)
{
    enum { WAITING = 60, ROUNDS = 40 };
    struct server server;
    char path[WAITING][80], other[80];
    int fds[WAITING], refused = 0;
    server_start(&server, &(struct server_options){0});
    for (int i = 0; i < WAITING; i++)
        server_submit(&server, path[i]);
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < WAITING; i++)
            server_open_polls(&server, path[i], "", &fds[i], 1);
        server_submit(&server, other);
        for (int i = 0; i < WAITING; i++)
            shutdown(fds[i], SHUT_WR);
        for (int i = 0; i < WAITING; i++) {
            refused += ends_with_refusal(fds[i]);
            close(fds[i]);
        }
    }
    ck_assert_int_eq(refused, 0);
    server_stop(&server);
}
END_TEST

/* Without a worker the explanation would wait for 10 s, and its job for a worker. */
START_TEST(test_connections__abandoned_explanations_leave_no_job)
{
    static const char body[] = "{\"scene\": \"builtin:spheres\"}";
    struct server server;
    server_start(&server, &(struct server_options){0});
    char text[300];
    struct answer answer;
    snprintf(text, sizeof text,
             "POST /v1/explain HTTP/1.1\r\nHost: localhost\r\nContent-Length: %zu\r\n\r\n%s",
             sizeof body - 1, body);
    int fd = server_connect(&server);
    client_send(fd, text);
    bool listed = false;
    for (int i = 0; i < 100 && !listed; i++) {
        client_pause(50);
        server_ask(&server, "GET /v1/jobs?kind=explain HTTP/1.1", NULL, &answer);
        listed = strstr(answer.body, "\"queued\"") != NULL;
        answer_release(&answer);
    }
    ck_assert(listed);
    close(fd);
    for (int i = 0; i < 100 && listed; i++) {
        client_pause(50);
        server_ask(&server, "GET /v1/jobs?kind=explain HTTP/1.1", NULL, &answer);
        listed = strstr(answer.body, "\"id\"") != NULL;
        answer_release(&answer);
    }
    ck_assert(!listed);
    server_stop(&server);
}
END_TEST

static int status_of_poll(const struct server *server, const char *path, const char *from,
                          const char *what)
{
    char text[200];
    struct answer answer;
    int fd = server_connect_from(server, from);
    snprintf(text, sizeof text, "GET %s%s HTTP/1.0\r\nHost: localhost\r\n\r\n", path, what);
    client_send(fd, text);
    client_read(fd, true, &answer);
    int status = answer.status;
    answer_release(&answer);
    close(fd);
    return status;
}

START_TEST(test_connections__one_address_cannot_take_all_places)
{
    enum { WAITING = 4 };
    struct server server;
    server_start(&server, &(struct server_options){.waiting_per_address = WAITING,
                                                   .trusted_proxy = "127.0.0.3"});
    char path[80];
    server_submit(&server, path);
    int fds[2 * WAITING];
    server_open_polls(&server, path, "", fds, WAITING);
    char text[200];
    snprintf(text, sizeof text, "GET %s/events HTTP/1.1\r\nHost: localhost\r\n\r\n", path);
    for (int i = WAITING; i < 2 * WAITING; i++) {
        fds[i] = server_connect(&server);
        client_send(fds[i], text);
    }
    server_wait_for_waiters(&server, WAITING, WAITING);
    ck_assert_int_eq(status_of_poll(&server, path, "127.0.0.1", "?wait=1"), 429);
    ck_assert_int_eq(status_of_poll(&server, path, "127.0.0.1", "/events"), 429);
    ck_assert_int_eq(status_of_poll(&server, path, "127.0.0.1", ""), 200);
    ck_assert_int_eq(status_of_poll(&server, path, "127.0.0.2", "?wait=1"), 200);
    ck_assert_int_eq(status_of_poll(&server, path, "127.0.0.2", "/events"), 200);
    int more[WAITING + 1];
    for (int i = 0; i <= WAITING; i++) {
        more[i] = server_connect_from(&server, "127.0.0.3");
        client_send(more[i], text);
    }
    for (int i = 0; i <= WAITING; i++) {
        struct answer answer;
        client_read(more[i], true, &answer);
        ck_assert_int_eq(answer.status, 200);
        answer_release(&answer);
        close(more[i]);
    }
    for (int i = 0; i < 2 * WAITING; i++)
        close(fds[i]);
    int status = 429;
    for (int i = 0; i < 100 && status == 429; i++) {
        client_pause(100);
        status = status_of_poll(&server, path, "127.0.0.1", "?wait=1");
    }
    ck_assert_int_eq(status, 200);
    server_stop(&server);
}
END_TEST

PEN_SUITE("connections", test_connections__slow_requests_are_ended,
          test_connections__idle_connections_give_way,
          test_connections__reserved_slots_of_one_thread_serve_all,
          test_connections__short_requests_have_slots_of_their_own,
          test_connections__refusals_of_a_rush_close,
          test_connections__unannounced_bytes_cost_no_answer,
          test_connections__abandoned_polls_are_forgotten,
          test_connections__abandoned_polls_are_not_refused,
          test_connections__abandoned_explanations_leave_no_job,
          test_connections__one_address_cannot_take_all_places, PEN_TIMED,
          test_connections__early_bytes_buy_no_time,
          test_connections__fresh_connections_keep_their_place,
          test_connections__half_bodies_give_way, test_connections__lingers_where_more_may_come,
          test_connections__slow_readers_keep_their_answer)
