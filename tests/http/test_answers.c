/* SPDX-License-Identifier: MIT */
/* Clients that read large answers slowly give way when the memory is used up; others do not. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "http/internal/pictures.h"
#include "support/server.h"
#include "support/suite.h"

enum { MIB = 1 << 20, HEAD_BYTES = 4096 };
static const int64_t second_ns = INT64_C(1000000000);

/* Asks for a path and reads the head alone. Little of the rest fits into the client's socket.
 * Returns the socket; *bytes is the length of the body. */
static int read_head(const struct server *server, const char *path, size_t *bytes)
{
    const int buffer = 64 << 10, fd = server_connect(server);
    char request[200], head[HEAD_BYTES + 1] = "";
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n", path);
    ck_assert(client_send(fd, request));
    for (size_t i = 0; i < HEAD_BYTES && !strstr(head, "\r\n\r\n"); i++) {
        ck_assert_int_eq(recv(fd, head + i, 1, 0), 1);
        head[i + 1] = '\0';
    }
    const char *length = strstr(head, "Content-Length: ");
    ck_assert_msg(strncmp(head, "HTTP/1.1 200", 12) == 0 && length, "%s", head);
    *bytes = strtoul(length + strlen("Content-Length: "), NULL, 10);
    return fd;
}

/* How much of the body comes until the connection ends, or until there are `bytes`. */
static size_t read_rest(int fd, size_t bytes)
{
    char part[64 << 10];
    size_t read = 0;
    ssize_t got = 1;
    while (read < bytes && got > 0) {
        got = recv(fd, part, sizeof part, 0);
        read += got > 0 ? (size_t)got : 0;
    }
    return read;
}

/* A client that reads some 2 MiB in a second. */
struct steady {
    pthread_t thread;
    int fd;
    size_t bytes, read;
    int64_t longest_ns; /* between two reads: a machine that is too busy makes it a slow one */
    atomic_bool done;
};

static void *read_steadily(void *user)
{
    struct steady *steady = user;
    char part[64 << 10];
    int64_t last_ns = pen_clock_ns();
    while (steady->read < steady->bytes) {
        const size_t left = steady->bytes - steady->read;
        client_pause(30);
        const ssize_t got =
            recv(steady->fd, part, left < sizeof part ? left : sizeof part, MSG_WAITALL);
        if (got <= 0)
            break;
        steady->read += (size_t)got;
        const int64_t now_ns = pen_clock_ns();
        if (now_ns - last_ns > steady->longest_ns)
            steady->longest_ns = now_ns - last_ns;
        last_ns = now_ns;
    }
    atomic_store(&steady->done, true);
    return NULL;
}

static void start_steady(struct steady *steady, const struct server *server, const char *path)
{
    *steady = (struct steady){0};
    steady->fd = read_head(server, path, &steady->bytes);
    ck_assert_int_eq(pthread_create(&steady->thread, NULL, read_steadily, steady), 0);
}

/* Asks until the answer is another than 503. */
static int status_in_time(const struct server *server, const char *path)
{
    char head[200];
    int status = 503;
    snprintf(head, sizeof head, "GET %s HTTP/1.1", path);
    for (int i = 0; i < 100 && status == 503; i++) {
        client_pause(50 * client_patience());
        status = server_status(server, head, NULL);
    }
    return status;
}

/* Submits a job whose labels take some 7.5 KiB in an answer. */
static void submit_labels(const struct server *server)
{
    enum { LABELS = 16, LENGTH = 38 };
    struct pen_buf body = {0};
    pen_buf_puts(&body, "{\"scene\": \"builtin:spheres\", \"labels\": {");
    for (int i = 0; i < LABELS; i++) {
        pen_buf_printf(&body, "%s\"%02d", i ? ", " : "", i);
        for (int k = 0; k < 2 * LENGTH; k++)
            pen_buf_puts(&body, k == LENGTH ? "\": \"" : "\\u0001");
        pen_buf_puts(&body, "\"");
    }
    pen_buf_puts(&body, "}}");
    ck_assert(!body.failed);
    ck_assert_int_eq(server_status(server, "POST /v1/jobs HTTP/1.1", (const char *)body.data), 202);
    pen_buf_release(&body);
}

/* Two lists that nobody takes are in memory, and the rest of it, but for half a list, is used. For
 * a third one the first has to give way, once it is slow, and not the second. */
START_TEST(test_answers__the_slowest_reader_of_a_list_gives_way)
{
    enum { JOBS = 80, ANSWER_MIB = 96 };
    static const char list[] = "/v1/jobs?limit=100";
    struct server server;
    size_t bytes, others;
    server_start(&server, &(struct server_options){0});
    struct answer_memory *memory = &server.http->answers;
    for (int i = 0; i < JOBS; i++)
        submit_labels(&server);
    const int first = read_head(&server, list, &bytes);
    ck_assert_uint_gt(bytes, JOBS * (7 << 10));
    const int second = read_head(&server, list, &bytes);
    others = (size_t)ANSWER_MIB * MIB - 2 * bytes - bytes / 2;
    atomic_fetch_add(&memory->bytes, others);
    ck_assert_int_eq(status_in_time(&server, list), 200);
    ck_assert_uint_lt(read_rest(first, bytes), bytes);
    ck_assert_uint_eq(read_rest(second, bytes), bytes);
    close(first);
    close(second);
    for (int i = 0; i < 400 && atomic_load(&memory->bytes) > others; i++)
        client_pause(10 * client_patience());
    ck_assert_uint_eq(atomic_load(&memory->bytes), others);
    ck_assert_uint_eq(atomic_load(&memory->leaving), 0);
    server_stop(&server);
}
END_TEST

/* Submits a job with a scene of `bytes`, most of them spaces, and writes the scene's path. */
static void submit_scene(const struct server *server, int bytes, char path[100])
{
    struct pen_buf body = {0};
    struct answer answer;
    pen_buf_printf(&body,
                   "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
                   " \"look_at\": [0, 0, 0]}, \"objects\": []%*s}",
                   bytes, "");
    server_ask(server, "POST /v1/jobs HTTP/1.1", (const char *)body.data, &answer);
    ck_assert_msg(answer.status == 202, "%s", answer.body);
    char job[80];
    snprintf(path, 100, "%s/scene", answer_field(&answer, "Location", job, sizeof job));
    answer_release(&answer);
    pen_buf_release(&body);
}

/* Of two clients that share a scene one is slow. As long as the other reads it, neither gives way:
 * that would free nothing. Afterwards the slow one does. */
START_TEST(test_answers__a_slow_reader_of_a_shared_scene_gives_way_when_it_is_alone)
{
    enum { SCENE = 6 * MIB, PICTURES_MIB = 128 };
    struct server server;
    struct steady steady;
    struct pen_status st;
    char shared[100], other[100], head[120];
    size_t bytes;
    server_start(&server, &(struct server_options){0});
    submit_scene(&server, SCENE, shared);
    submit_scene(&server, SCENE, other);
    struct picture_room room = {.bytes = (size_t)PICTURES_MIB * MIB - SCENE - SCENE / 2};
    const int slow = read_head(&server, shared, &bytes);
    start_steady(&steady, &server, shared);
    ck_assert_msg(pen_http_pictures_reserve(server.http->pictures, &room, 0, &st), "%s", st.msg);
    client_pause(2200);
    snprintf(head, sizeof head, "GET %s HTTP/1.1", other);
    const int meanwhile = server_status(&server, head, NULL);
    const bool was_read = !atomic_load(&steady.done);
    pthread_join(steady.thread, NULL);
    printf("# %d while the other read, %.1f s at most between two reads\n", meanwhile,
           (double)steady.longest_ns / (double)second_ns);
    if (steady.longest_ns < second_ns) {
        ck_assert(!was_read || meanwhile == 503);
        ck_assert_uint_eq(steady.read, steady.bytes);
    }
    ck_assert_int_eq(status_in_time(&server, other), 200);
    ck_assert_uint_lt(read_rest(slow, bytes), bytes);
    close(slow);
    close(steady.fd);
    pen_http_pictures_give_up(server.http->pictures, &room);
    server_stop(&server);
}
END_TEST

PEN_SUITE("answers", test_answers__the_slowest_reader_of_a_list_gives_way,
          test_answers__a_slow_reader_of_a_shared_scene_gives_way_when_it_is_alone)
