/* SPDX-License-Identifier: MIT */
/* The server with clients that disconnect, pipeline, stall, send wrong lengths, or are many. */
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "http/internal/encoding.h"
#include "http/internal/http.h"
#include "support/server.h"
#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static int64_t ms_since(int64_t begun_ns)
{
    return (pen_clock_ns() - begun_ns) / 1000000;
}

/* Sends bytes on a new connection. Returns the status of the answer, 0 if there is none. */
static int status_of_bytes(const struct server *server, const char *bytes)
{
    struct answer answer;
    int fd = server_connect(server);
    client_send(fd, bytes);
    client_read(fd, false, &answer);
    close(fd);
    int status = answer.status;
    answer_release(&answer);
    return status;
}

START_TEST(test_server__partial_requests_are_ended)
{
    static const char *const parts[] = {"", "G", "GET /healthz HTTP/1.1\r\n",
                                        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: ",
                                        ("POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                                         "Content-Length: 100\r\n\r\n{\"scene\"")};
    struct server server;
    server_start(&server, &(struct server_options){.idle_seconds = 3 * client_patience()});
    int fds[5];
    for (int i = 0; i < 5; i++) {
        fds[i] = server_connect(&server);
        client_send(fds[i], parts[i]);
    }
    server_expect_alive(&server);
    for (int i = 0; i < 5; i++) {
        ck_assert_msg(client_sees_end(fds[i]), "\"%s\" is still open", parts[i]);
        close(fds[i]);
    }
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__aborted_uploads_leave_nothing)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    char *part = malloc(300001);
    memset(part, ' ', 300000);
    part[300000] = '\0';
    for (int i = 0; i < 60; i++) {
        const struct linger reset = {.l_onoff = 1};
        int fd = server_connect(&server);
        client_send(fd, "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                        "Content-Length: 9000000\r\n\r\n");
        client_send(fd, part + 5000 * i);
        if (i % 2)
            setsockopt(fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
        close(fd);
    }
    free(part);
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

/* When the memory for bodies is used up, the next body is refused. */
START_TEST(test_server__bodies_in_memory_are_bounded)
{
    enum { ALL = 256 << 20 };
    struct server server;
    server_start(&server, &(struct server_options){0});
    atomic_fetch_add(&server.http->body_bytes, ALL);
    ck_assert_int_eq(server_status(&server, "POST /v1/jobs HTTP/1.1", "{}"), 503);
    ck_assert_uint_eq(atomic_load(&server.http->body_bytes), ALL);
    atomic_fetch_sub(&server.http->body_bytes, ALL);
    ck_assert_int_eq(server_status(&server, "POST /v1/jobs HTTP/1.1", "{}"), 422);
    ck_assert_uint_eq(atomic_load(&server.http->body_bytes), 0);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__pipelined_requests_are_answered_in_order)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    int fd = server_connect(&server);
    client_send(fd, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
                    "POST /v1/validate HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\n\r\n{"
                    "GET /v1/jobs HTTP/1.1\r\nHost: localhost\r\n\r\n"
                    "POST /nowhere HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"
                    "HEAD /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
                    "GET /nowhere HTTP/1.1\r\nHost: localhost\r\n\r\n"
                    "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                    "Transfer-Encoding: chunked\r\n\r\n1\r\n{\r\n1;x=y\r\n}\r\n0\r\nX: y\r\n\r\n"
                    "GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    static const int expected[] = {200, 400, 200, 404, 200, 404, 422, 200};
    for (int i = 0; i < 8; i++) {
        struct answer answer;
        client_read(fd, i == 4, &answer);
        ck_assert_msg(answer.status == expected[i], "answer %d: %d", i, answer.status);
        answer_release(&answer);
    }
    close(fd);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__garbage_is_refused_or_dropped)
{
    struct server server;
    server_start(&server, &(struct server_options){.idle_seconds = 3 * client_patience()});
    unsigned seed = (unsigned)time(NULL);
    srand(seed);
    for (int round = 0; round < 100; round++) {
        char bytes[400];
        int length = 1 + rand() % 390;
        for (int i = 0; i < length; i++)
            bytes[i] = (char)(rand() % 5 ? 32 + rand() % 95 : 1 + rand() % 255);
        memcpy(bytes + length, "\r\n\r\n", 5);
        int status = status_of_bytes(&server, bytes);
        ck_assert_msg(status == 0 || status >= 400, "seed %u: %d for \"%s\"", seed, status, bytes);
    }
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__oversized_head_is_refused)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    struct pen_buf text = {0};
    pen_buf_puts(&text, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n");
    for (int i = 0; i < 700; i++)
        pen_buf_printf(&text, "X-%d: %0100d\r\n", i, i);
    pen_buf_puts(&text, "\r\n");
    ck_assert_int_eq(status_of_bytes(&server, (const char *)text.data), 431);
    pen_buf_release(&text);
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__ambiguous_lengths_are_refused)
{
    static const struct {
        const char *fields;
        int status;
    } rows[] = {{"Content-Length: 2\r\nTransfer-Encoding: chunked\r\n", 400},
                {"Transfer-Encoding: chunked\r\nContent-Length: 2\r\n", 400},
                {"Transfer-Encoding: gzip\r\n", 400},
                {"Transfer-Encoding: gzip, chunked\r\n", 400},
                {"Transfer-Encoding: chunked\r\n", 400} /* no chunk follows */,
                {"Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n", 400},
                {"Content-Length: 2\r\nContent-Length: 3\r\n", 400},
                {"Content-Length: 2\r\nContent-Length: 2\r\n", 400},
                {"Content-Length: -2\r\n", 400},
                {"Content-Length: 2, 2\r\n", 400},
                {"Content-Length: 0x2\r\n", 400},
                {"Content-Length: \r\n", 400},
                {"Content-Length: 99999999999999999999\r\n", 413},
                {"Content-Length: 18446744073709551615\r\n", 413},
                {"Content-Length: 2\r\nHost: localhost\r\n", 400}};
    struct server server;
    server_start(&server, &(struct server_options){0});
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char text[300];
        snprintf(text, sizeof text, "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n%s\r\n{}",
                 rows[i].fields);
        int status = status_of_bytes(&server, text);
        ck_assert_msg(status == rows[i].status, "%s: %d", rows[i].fields, status);
    }
    ck_assert_int_eq(status_of_bytes(&server, "GET /healthz HTTP/1.1\r\n\r\n"), 400);
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

/* Each of these heads is refused or its connection closed, even after a good request. libmicrohttpd
 * 0.9.75 hides folded lines, fields without a name, lines that end in LF, and bytes after a zero
 * byte. */
START_TEST(test_server__ambiguous_heads_are_refused)
{
    static const char *const rows[] = {
        "GET /healthz HTTP/1.1\r\nHost : localhost\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: a\rb\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX: \x01\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nX\r\n\r\n",
        "GET /health z HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n",
        "GET /healthz HTTP/1.1\r\n\r\n",
        "GET /healthz http/1.1\r\nHost: localhost\r\n\r\n",
        "G(T /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"};
    struct server server;
    server_start(&server, &(struct server_options){0});
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct answer answer;
        int fd = server_connect(&server);
        client_send(fd, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
        client_read(fd, false, &answer);
        ck_assert_int_eq(answer.status, 200);
        answer_release(&answer);
        client_send(fd, rows[i]);
        client_read(fd, false, &answer);
        ck_assert_msg(answer.status == 0 || answer.status >= 400, "%s: %d", rows[i], answer.status);
        answer_release(&answer);
        ck_assert(client_sees_end(fd));
        close(fd);
    }
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

/* Sends a head and a body of bytes. */
static void ask_bytes(const struct server *server, const char *head, const struct pen_buf *body,
                      struct answer *answer)
{
    char text[400];
    int fd = server_connect(server);
    snprintf(text, sizeof text, "%s\r\nHost: localhost\r\nContent-Length: %zu\r\n\r\n", head,
             body->bytes);
    client_send(fd, text);
    send(fd, body->data, body->bytes, MSG_NOSIGNAL);
    client_read(fd, false, answer);
    close(fd);
}

START_TEST(test_server__compressed_bodies_are_decoded_under_the_limit)
{
    static const char job[] = "{\"scene\": \"builtin:spheres\"}";
    static const char gzip[] = "POST /v1/validate HTTP/1.1\r\nContent-Encoding: gzip";
    struct server server;
    server_start(&server, &(struct server_options){.body_bytes = 1000000});
    struct pen_buf body = {0}, bomb = {0};
    struct answer answer;
    ck_assert(pen_http_gzip(job, sizeof job - 1, &body));
    ask_bytes(&server, gzip, &body, &answer);
    ck_assert_msg(answer.status == 200, "%s", answer.body);
    answer_release(&answer);
    body.bytes -= 3;
    ask_bytes(&server, gzip, &body, &answer);
    ck_assert_int_eq(answer.status, 400);
    answer_release(&answer);
    ask_bytes(&server, "POST /v1/validate HTTP/1.1\r\nContent-Encoding: br", &body, &answer);
    ck_assert_int_eq(answer.status, 415);
    answer_release(&answer);
    ck_assert_int_eq(
        server_status(&server, "POST /v1/validate HTTP/1.1\r\nContent-Encoding: Identity", job),
        200);
    char *spaces = malloc(50000000);
    memset(spaces, ' ', 50000000);
    ck_assert(pen_http_gzip(spaces, 50000000, &bomb));
    ck_assert_uint_lt(bomb.bytes, 1000000);
    ask_bytes(&server, gzip, &bomb, &answer);
    ck_assert_int_eq(answer.status, 413);
    answer_release(&answer);
    free(spaces);
    pen_buf_release(&body);
    pen_buf_release(&bomb);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__answers_are_compressed_on_demand)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    struct answer plain, packed, known;
    struct pen_status st;
    struct pen_buf text = {0};
    char value[100], tag[100], head[300];
    server_ask(&server, "GET /openapi.yaml HTTP/1.1", NULL, &plain);
    ck_assert_str_eq(answer_field(&plain, "Content-Encoding", value, sizeof value), "");
    ck_assert_str_eq(answer_field(&plain, "Vary", value, sizeof value), "Accept-Encoding");
    server_ask(&server, "GET /openapi.yaml HTTP/1.1\r\nAccept-Encoding: br, gzip;q=0.5", NULL,
               &packed);
    ck_assert_str_eq(answer_field(&packed, "Content-Encoding", value, sizeof value), "gzip");
    ck_assert_str_eq(answer_field(&packed, "Vary", value, sizeof value), "Accept-Encoding");
    size_t bytes = packed.text.bytes - (size_t)(packed.body - (const char *)packed.text.data);
    size_t plain_bytes = plain.text.bytes - (size_t)(plain.body - (const char *)plain.text.data);
    ck_assert_uint_lt(bytes, plain_bytes / 2);
    ck_assert(pen_http_gunzip(packed.body, bytes, plain_bytes, &text, &st));
    ck_assert_uint_eq(text.bytes, plain_bytes);
    ck_assert_mem_eq(text.data, plain.body, plain_bytes);
    answer_field(&packed, "ETag", tag, sizeof tag);
    ck_assert_str_ne(answer_field(&plain, "ETag", value, sizeof value), tag);
    snprintf(head, sizeof head,
             "GET /openapi.yaml HTTP/1.1\r\nAccept-Encoding: gzip\r\nIf-None-Match: %s", tag);
    server_ask(&server, head, NULL, &known);
    ck_assert_int_eq(known.status, 304);
    ck_assert_str_eq(answer_field(&known, "ETag", value, sizeof value), tag);
    answer_release(&known);
    server_ask(&server, "GET /openapi.yaml HTTP/1.1\r\nAccept-Encoding: gzip;q=0", NULL, &known);
    ck_assert_str_eq(answer_field(&known, "Content-Encoding", value, sizeof value), "");
    answer_release(&known);
    answer_release(&packed);
    server_ask(&server, "GET /metrics HTTP/1.1\r\nAccept-Encoding: gzip", NULL, &packed);
    ck_assert_str_eq(answer_field(&packed, "Content-Encoding", value, sizeof value), "gzip");
    answer_release(&plain);
    answer_release(&packed);
    pen_buf_release(&text);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__body_is_requested_only_if_accepted)
{
    struct server server;
    server_start(&server, &(struct server_options){.body_bytes = 1000});
    struct answer answer;
    int fd = server_connect(&server);
    client_send(fd, "POST /v1/validate HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\n"
                    "Content-Length: 2\r\n\r\n");
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 100);
    answer_release(&answer);
    client_send(fd, "{}");
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 422);
    answer_release(&answer);
    close(fd);

    fd = server_connect(&server);
    client_send(fd, "POST /v1/validate HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\n"
                    "Content-Length: 1001\r\n\r\n");
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 413);
    ck_assert(client_sees_end(fd));
    answer_release(&answer);
    close(fd);

    fd = server_connect(&server);
    client_send(fd, "POST /nowhere HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\n"
                    "Content-Length: 10\r\n\r\n");
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 404);
    answer_release(&answer);
    close(fd);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__endless_chunks_are_dropped)
{
    struct server server;
    server_start(&server,
                 &(struct server_options){.body_bytes = 100000, .cors = "https://a.example"});
    char chunk[5010], field[200];
    snprintf(chunk, sizeof chunk, "1388\r\n%05000d\r\n", 0);
    int fd = server_connect(&server);
    client_send(fd, "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nOrigin: https://a.example\r\n"
                    "Transfer-Encoding: chunked\r\n\r\n");
    for (int i = 0; i < 30; i++)
        client_send(fd, chunk);
    struct answer answer;
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 413);
    ck_assert_str_eq(answer_field(&answer, "Access-Control-Allow-Origin", field, sizeof field),
                     "https://a.example");
    answer_release(&answer);
    bool open = true; /* later bytes are read and dropped for a minute */
    for (int i = 0; i < SUITE_HANG_S * 1000 && open; i++) {
        client_pause(1);
        open = client_send(fd, chunk);
    }
    ck_assert(!open);
    close(fd);
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__body_limit_is_exact)
{
    struct server server;
    server_start(&server, &(struct server_options){.body_bytes = 50});
    char body[52];
    memset(body, ' ', 51);
    body[51] = '\0';
    ck_assert_int_eq(server_status(&server, "POST /v1/validate HTTP/1.1", body), 413);
    body[50] = '\0';
    ck_assert_int_eq(server_status(&server, "POST /v1/validate HTTP/1.1", body), 400);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__old_clients_are_served)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    ck_assert_int_eq(status_of_bytes(&server, "GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n"),
                     200);
    ck_assert_int_eq(status_of_bytes(&server, "GET /healthz HTTP/1.0\r\n\r\n"), 403);
    server_stop(&server);
}
END_TEST

enum { POLLS = 64 };

static void expect_polls(int *fds, int count, int status, const char *part)
{
    for (int i = 0; i < count; i++) {
        struct answer answer;
        client_read(fds[i], false, &answer);
        ck_assert_msg(answer.status == status, "poll %d: %d", i, answer.status);
        ck_assert_msg(strstr(answer.body, part) != NULL, "poll %d: %s", i, answer.body);
        answer_release(&answer);
        close(fds[i]);
    }
}

/* Cancels a job that long polls wait for. Returns the ms until all of them are answered. */
static int64_t cancel_polls(const struct server *server)
{
    char path[80], cancel[120];
    int fds[POLLS];
    server_submit(server, path);
    server_open_polls(server, path, "", fds, POLLS);
    server_wait_for_waiters(server, POLLS, 0);
    const int64_t begun = pen_clock_ns();
    snprintf(cancel, sizeof cancel, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(server_status(server, cancel, NULL), 202);
    expect_polls(fds, POLLS, 200, "\"cancelled\"");
    return ms_since(begun);
}

START_TEST(test_server__long_polls_end_with_the_job)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    int64_t ms = 1000;
    for (int i = 0; i < 3 && ms >= 1000; i++) /* no delay disturbs at least one of three tries */
        ms = cancel_polls(&server);
    ck_assert_timed(ms < 1000);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__long_poll_ends_with_its_time)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160];
    server_submit(&server, path);
    struct answer answer;
    char etag[40];
    int64_t begun = pen_clock_ns();
    snprintf(head, sizeof head, "GET %s?wait=1 HTTP/1.1", path);
    server_ask(&server, head, NULL, &answer);
    ck_assert_int_eq(answer.status, 200);
    ck_assert_int_ge(ms_since(begun), 990);
    ck_assert_timed(ms_since(begun) < 10000);
    answer_field(&answer, "ETag", etag, sizeof etag);
    answer_release(&answer);
    begun = pen_clock_ns();
    snprintf(head, sizeof head, "GET %s?wait=1 HTTP/1.1\r\nIf-None-Match: %s", path, etag);
    ck_assert_int_eq(server_status(&server, head, NULL), 304);
    ck_assert_int_ge(ms_since(begun), 990);
    begun = pen_clock_ns();
    snprintf(head, sizeof head, "GET %s?wait=60 HTTP/1.1\r\nIf-None-Match: \"0\"", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 200);
    ck_assert_timed(ms_since(begun) < 10000);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__long_poll_of_a_deleted_job)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160];
    server_submit(&server, path);
    snprintf(head, sizeof head, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 202);
    snprintf(head, sizeof head, "DELETE %s HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 204);
    snprintf(head, sizeof head, "GET %s?wait=30 HTTP/1.1", path);
    int64_t begun = pen_clock_ns();
    ck_assert_int_eq(server_status(&server, head, NULL), 410);
    ck_assert_timed(ms_since(begun) < 15000);
    server_stop(&server);
}
END_TEST

/* If there is one request too many, one is refused. The server's threads decide which one. */
START_TEST(test_server__waiting_requests_are_bounded)
{
    enum { WAITING = 512 };
    server_allow_many_files();
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160];
    server_submit(&server, path);
    static int fds[WAITING + 1];
    server_open_polls(&server, path, "", fds, WAITING + 1);
    const int refused = client_first_answered(fds, WAITING + 1);
    struct answer answer;
    char retry[16];
    client_read(fds[refused], false, &answer);
    close(fds[refused]);
    fds[refused] = fds[WAITING];
    ck_assert_int_eq(answer.status, 503);
    ck_assert_str_ne(answer_field(&answer, "Retry-After", retry, sizeof retry), "");
    answer_release(&answer);
    int64_t ms = 500;
    for (int i = 0; i < 3 && ms >= 500; i++) { /* no delay disturbs at least one of three tries */
        const int64_t begun = pen_clock_ns();
        ck_assert_int_eq(server_status(&server, "GET /v1/jobs HTTP/1.1", NULL), 200);
        ms = ms_since(begun);
    }
    ck_assert_timed(ms < 500);
    snprintf(head, sizeof head, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 202);
    expect_polls(fds, WAITING, 200, "\"cancelled\"");
    server_stop(&server);
}
END_TEST

START_TEST(test_server__disconnected_waiters_do_no_harm)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160];
    server_submit(&server, path);
    int fds[POLLS];
    server_open_polls(&server, path, "", fds, POLLS);
    server_wait_for_waiters(&server, POLLS, 0);
    for (int i = 0; i < POLLS; i += 2)
        close(fds[i]);
    snprintf(head, sizeof head, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 202);
    for (int i = 1; i < POLLS; i += 2)
        expect_polls(&fds[i], 1, 200, "\"cancelled\"");
    server_expect_alive(&server);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__stop_answers_waiting_requests)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80];
    server_submit(&server, path);
    int fds[POLLS];
    server_open_polls(&server, path, "", fds, POLLS);
    server_wait_for_waiters(&server, POLLS, 0);
    int64_t begun = pen_clock_ns();
    server_stop(&server);
    ck_assert_timed(ms_since(begun) < 20000);
    expect_polls(fds, POLLS, 200, "\"queued\"");
}
END_TEST

START_TEST(test_server__drain_refuses_new_jobs_only)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160], retry[16];
    server_submit(&server, path);
    pen_http_drain(server.http);
    struct answer answer;
    server_ask(&server, "POST /v1/jobs HTTP/1.1", "{\"scene\": \"builtin:spheres\"}", &answer);
    ck_assert_int_eq(answer.status, 503);
    ck_assert_str_ne(answer_field(&answer, "Retry-After", retry, sizeof retry), "");
    answer_release(&answer);
    ck_assert_int_eq(server_status(&server, "GET /readyz HTTP/1.1", NULL), 503);
    ck_assert_int_eq(server_status(&server, "GET /healthz HTTP/1.1", NULL), 200);
    snprintf(head, sizeof head, "GET %s HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 200);
    server_stop(&server);
}
END_TEST

/* Lets files grow to `bytes` at most, like a disk that becomes full. */
static void limit_files(rlim_t bytes)
{
    struct rlimit size;
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &size), 0);
    size.rlim_cur = bytes;
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &size), 0);
}

START_TEST(test_server__store_that_takes_no_writes_is_reported)
{
    static const char job[] = "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 8}}";
    struct server server;
    server_start(&server, &(struct server_options){0});
    char path[80], head[160], retry[16];
    server_submit(&server, path);
    signal(SIGXFSZ, SIG_IGN);
    limit_files(1);
    struct answer answer;
    server_ask(&server, "POST /v1/jobs HTTP/1.1", job, &answer);
    ck_assert_msg(answer.status == 503 || answer.status == 507, "%d", answer.status);
    ck_assert_str_ne(answer_field(&answer, "Retry-After", retry, sizeof retry), "");
    answer_release(&answer);
    server_ask(&server, "GET /readyz HTTP/1.1", NULL, &answer);
    ck_assert_int_eq(answer.status, 503);
    ck_assert_ptr_nonnull(strstr(answer.body, "the store does not take writes: "));
    answer_release(&answer);
    snprintf(head, sizeof head, "GET %s HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 200);
    ck_assert_int_eq(server_status(&server, "GET /healthz HTTP/1.1", NULL), 200);

    limit_files(RLIM_INFINITY);
    int ready = 503;
    for (int i = 0; i < 30 && ready != 200; i++) {
        client_pause(200);
        ready = server_status(&server, "GET /readyz HTTP/1.1", NULL);
    }
    ck_assert_int_eq(ready, 200);
    ck_assert_int_eq(server_status(&server, "POST /v1/jobs HTTP/1.1", job), 202);
    server_stop(&server);
}
END_TEST

enum { CLIENTS = 16, SUBMITS = 10 };

struct client {
    pthread_t thread;
    const struct server *server;
    char path[SUBMITS][80];
};

static void *submit_some(void *arg)
{
    struct client *client = arg;
    for (int i = 0; i < SUBMITS; i++)
        server_submit(client->server, client->path[i]);
    return NULL;
}

static int compare_paths(const void *a, const void *b)
{
    return strcmp(a, b);
}

START_TEST(test_server__concurrent_submits_are_all_kept)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    static struct client clients[CLIENTS];
    static char paths[CLIENTS * SUBMITS][80];
    for (int i = 0; i < CLIENTS; i++) {
        clients[i].server = &server;
        ck_assert_int_eq(pthread_create(&clients[i].thread, NULL, submit_some, &clients[i]), 0);
    }
    for (int i = 0; i < CLIENTS; i++) {
        pthread_join(clients[i].thread, NULL);
        memcpy(paths[i * SUBMITS], clients[i].path, sizeof clients[i].path);
    }
    qsort(paths, CLIENTS * SUBMITS, sizeof paths[0], compare_paths);
    struct answer answer;
    server_ask(&server, "GET /v1/jobs?limit=500 HTTP/1.1", NULL, &answer);
    for (int i = 0; i < CLIENTS * SUBMITS; i++) {
        ck_assert(i == 0 || strcmp(paths[i - 1], paths[i]) != 0);
        ck_assert_ptr_nonnull(strstr(answer.body, paths[i]));
    }
    answer_release(&answer);
    server_stop(&server);
}
END_TEST

static void *submit_keyed(void *arg)
{
    struct client *client = arg;
    struct answer answer;
    server_ask(client->server, "POST /v1/jobs HTTP/1.1\r\nIdempotency-Key: same",
               "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 32, \"height\": 24}}",
               &answer);
    ck_assert_int_eq(answer.status, 202);
    answer_field(&answer, "Location", client->path[0], sizeof client->path[0]);
    answer_release(&answer);
    return NULL;
}

START_TEST(test_server__concurrent_submits_with_one_key_are_one_job)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    static struct client clients[CLIENTS];
    for (int i = 0; i < CLIENTS; i++) {
        clients[i].server = &server;
        ck_assert_int_eq(pthread_create(&clients[i].thread, NULL, submit_keyed, &clients[i]), 0);
    }
    for (int i = 0; i < CLIENTS; i++) {
        pthread_join(clients[i].thread, NULL);
        ck_assert_str_eq(clients[i].path[0], clients[0].path[0]);
    }
    server_stop(&server);
}
END_TEST

START_TEST(test_server__jobs_are_rendered)
{
    struct server server;
    server_start(&server, &(struct server_options){.worker = true});
    char path[80], head[160];
    server_submit(&server, path);
    struct answer answer;
    snprintf(head, sizeof head, "GET %s?wait=30 HTTP/1.1", path);
    server_ask(&server, head, NULL, &answer);
    ck_assert_ptr_nonnull(strstr(answer.body, "\"succeeded\""));
    answer_release(&answer);
    snprintf(head, sizeof head, "GET %s/image HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 200);
    server_stop(&server);
}
END_TEST

START_TEST(test_server__listening_socket_stays_the_callers)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    pen_http_stop(server.http);
    int fd = server_connect(&server); /* waits in the backlog: the socket still listens */
    struct pen_status st;
    const struct pen_http_options again = {
        .listen_fd = server.listen_fd, .store_url = server.store, .limits = pen_limits_default()};
    server.http = pen_http_start(&again, &st);
    ck_assert_msg(server.http != NULL, "%s", st.msg);
    client_send(fd, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    struct answer answer;
    client_read(fd, false, &answer);
    ck_assert_int_eq(answer.status, 200);
    answer_release(&answer);
    close(fd);
    server_stop(&server);
}
END_TEST

/* Without its store the server gives the reason, and may open the store later. */
START_TEST(test_server__serves_before_its_store_is_open)
{
    struct server server;
    struct pen_status st;
    struct answer answer;
    server_start(&server, &(struct server_options){0});
    pen_http_stop(server.http);
    struct pen_http_options options = {.listen_fd = server.listen_fd,
                                       .store_url = "/dev/null/nowhere.db",
                                       .limits = pen_limits_default()};
    server.http = pen_http_start(&options, &st);
    ck_assert_msg(server.http != NULL, "%s", st.msg);
    ck_assert(!pen_http_open(server.http, &options, &st));
    ck_assert_int_eq(server_status(&server, "GET /healthz HTTP/1.1", NULL), 200);
    ck_assert_int_eq(server_status(&server, "GET /readyz HTTP/1.1", NULL), 503);
    ck_assert_int_eq(
        server_status(&server, "GET /openapi.yaml HTTP/1.1\r\nAccept-Encoding: gzip", NULL), 200);
    server_ask(&server, "POST /v1/jobs HTTP/1.1", "{\"scene\": \"builtin:room\"}", &answer);
    ck_assert_int_eq(answer.status, 503);
    ck_assert_ptr_nonnull(strstr(answer.body, "the store cannot be opened: "));
    ck_assert_ptr_nonnull(strstr(answer.body, "nowhere.db"));
    answer_release(&answer);
    options.store_url = server.store;
    ck_assert_msg(pen_http_open(server.http, &options, &st), "%s", st.msg);
    ck_assert_int_eq(server_status(&server, "GET /readyz HTTP/1.1", NULL), 200);
    server_stop(&server);
}
END_TEST

PEN_SUITE("server", test_server__partial_requests_are_ended,
          test_server__aborted_uploads_leave_nothing, test_server__bodies_in_memory_are_bounded,
          test_server__pipelined_requests_are_answered_in_order,
          test_server__garbage_is_refused_or_dropped, test_server__oversized_head_is_refused,
          test_server__compressed_bodies_are_decoded_under_the_limit,
          test_server__answers_are_compressed_on_demand, test_server__ambiguous_lengths_are_refused,
          test_server__ambiguous_heads_are_refused, test_server__body_is_requested_only_if_accepted,
          test_server__body_limit_is_exact, test_server__old_clients_are_served,
          test_server__long_polls_end_with_the_job, test_server__long_poll_ends_with_its_time,
          test_server__long_poll_of_a_deleted_job, test_server__waiting_requests_are_bounded,
          test_server__disconnected_waiters_do_no_harm, test_server__stop_answers_waiting_requests,
          test_server__drain_refuses_new_jobs_only,
          test_server__store_that_takes_no_writes_is_reported,
          test_server__concurrent_submits_are_all_kept,
          test_server__concurrent_submits_with_one_key_are_one_job, test_server__jobs_are_rendered,
          test_server__listening_socket_stays_the_callers,
          test_server__serves_before_its_store_is_open, PEN_TIMED,
          test_server__endless_chunks_are_dropped)
