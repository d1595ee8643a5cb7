/* SPDX-License-Identifier: MIT */
/* Clients that hold connections without using them. Their connections are closed, or found to be
 * dead, and other clients are answered meanwhile. */
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support/server.h"
#include "support/suite.h"

/* A client that sends a little from time to time is never idle, but its deadline stays the same. */
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
        ck_assert(client_sees_end(open[i].fd));
        close(open[i].fd);
    }
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

/* Bytes that came early do not allow a body to be slow later. */
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
    for (int i = 0; i < PARTS; i++) { /* longer than the deadline, and faster than the least rate */
        client_pause(700);
        ck_assert(client_send(fd, early));
    }
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 400); /* spaces are no JSON */
    answer_release(&answer);
    close(fd);
    ck_assert(client_sees_end(slow));
    close(slow);
    free(early);
    server_stop(&server);
}
END_TEST

/* Connections up to a quarter above the limit are accepted at once. Beyond the limit, those that
 * wait longest are closed. */
START_TEST(test_connections__idle_connections_are_closed_for_new_ones)
{
    enum { OPEN = 80, ALL = 3 * OPEN };
    struct server server;
    server_start(&server, &(struct server_options){.connections = OPEN});
    int fds[ALL];
    for (int i = 0; i < ALL; i++) {
        fds[i] = server_connect(&server);
        client_send(fds[i], i % 2 ? "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n" : "GET /");
        client_pause(10);
    }
    int open = ALL;
    for (int k = 0; k < 400 && open > OPEN; k++) {
        client_pause(50);
        open = 0;
        for (int i = 0; i < ALL; i++)
            open += !client_has_seen_end(fds[i]);
    }
    ck_assert_int_le(open, OPEN);
    ck_assert(client_has_seen_end(fds[0]));
    server_expect_alive(&server);
    for (int i = 0; i < ALL; i++)
        close(fds[i]);
    server_stop(&server);
}
END_TEST

/* A body that has stopped is as idle as a head. */
START_TEST(test_connections__half_bodies_are_closed_for_new_ones)
{
    enum { OPEN = 20 };
    struct server server;
    int fds[OPEN];
    server_start(&server, &(struct server_options){.connections = OPEN});
    for (int i = 0; i < OPEN; i++) {
        fds[i] = server_connect(&server);
        client_send(fds[i], "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                            "Content-Length: 1000\r\n\r\n{");
    }
    client_pause(1500);
    char path[80];
    int more[OPEN];
    for (int i = 0; i < OPEN; i++) {
        more[i] = server_connect(&server);
        client_pause(300);
        server_submit(&server, path);
    }
    for (int i = 0; i < OPEN; i++)
        close(fds[i]), close(more[i]);
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

/* A connection lingers if its client may still send. The client gets its answer, even if it sends
 * more after the server's side has ended. */
START_TEST(test_connections__early_answers_arrive)
{
    static const struct {
        const char *request;
        int status;
    } rows[] = {
        {"POST / HTTP/1.1\r\nHost: localhost\r\nHost: a\r\nContent-Length: 5\r\n\r\n", 400},
        {"POST / HTTP/1.1\r\nHost: other\r\nConnection: close\r\n"
         "Transfer-Encoding: gzip\r\n\r\n",
         400},
        {"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\n", 413},
        {"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n"
         "Expect: 100-continue\r\nContent-Type: image/png\r\n\r\n",
         415}};
    struct server server;
    server_start(&server, &(struct server_options){.idle_seconds = 0});
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct answer answer;
        const int fd = server_connect(&server);
        struct pollfd ended = {.fd = fd, .events = POLLRDHUP};
        ck_assert(client_send(fd, rows[i].request));
        ck_assert_int_eq(poll(&ended, 1, SUITE_HANG_S * 1000), 1);
        client_send(fd, "12345");
        client_pause(100);
        client_send(fd, "12345");
        client_read(fd, false, &answer);
        ck_assert_msg(answer.status == rows[i].status, "%d after %s", answer.status,
                      rows[i].request);
        answer_release(&answer);
        ck_assert(client_sees_end(fd));
        close(fd);
    }
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

/* A reader that reads several windows in the time of one keeps its answer. The kernel could take
 * megabytes of it, and would not ask for more until a third of them was read. A client that reads
 * nothing loses its answer. So does a client that reads a little from time to time, but less than a
 * window in its time. */
START_TEST(test_connections__slow_readers_keep_their_answer)
{
    enum { PART = 1 << 16, PARTS = 24, LEAST = 8000000 }; /* the kernel buffers less than that */
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

/* The places of polls whose clients have gone are soon free, even if the job does not change. */
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

/* Reads until the end. Returns whether there is a refusal, perhaps after interim answers. */
static bool ends_with_refusal(int fd)
{
    char text[1 << 14] = "";
    size_t used = 0;
    for (ssize_t got = 1; got > 0; used += got > 0 ? (size_t)got : 0)
        got = recv(fd, text + used, sizeof text - 1 - used, 0);
    return strstr(text, "HTTP/1.1 503 ") != NULL;
}

/* Polls whose clients end their side while the store changes and their jobs are checked. They get
 * no answer or their job, but no refusal. */
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

PEN_SUITE("connections", test_connections__slow_requests_are_ended,
          test_connections__idle_connections_are_closed_for_new_ones,
          test_connections__early_answers_arrive, test_connections__abandoned_polls_are_forgotten,
          test_connections__abandoned_polls_are_not_refused,
          test_connections__abandoned_explanations_leave_no_job, PEN_TIMED,
          test_connections__early_bytes_buy_no_time,
          test_connections__half_bodies_are_closed_for_new_ones,
          test_connections__slow_readers_keep_their_answer)
