/* SPDX-License-Identifier: MIT */
/* Who is served next: clients take turns, small requests of a client come before its large ones,
 * only so many wait, and none for a client that has gone. */
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/waiting.h"
#include "support/server.h"
#include "support/suite.h"

static void add(struct waiting *waiting, struct request *request, const char *client, size_t work)
{
    ck_assert(!*client || pen_http_address_parse(client, request->client.bytes)); /* "": unknown */
    request->work_bytes = work;
    pen_http_waiting_add(waiting, request);
}

/* Takes the next request, which takes so long, and returns it. */
static const struct request *serve(struct waiting *waiting, int64_t ns)
{
    bool oldest = false;
    const struct request *request = pen_http_waiting_take(waiting, &oldest);
    if (request)
        pen_http_waiting_spent(waiting, oldest, ns);
    return request;
}

/* A client with many requests, then one with two: that one is next, then both in turn. */
START_TEST(test_turns__clients_take_turns)
{
    struct waiting *waiting = malloc(sizeof *waiting);
    struct request *request = calloc(8, sizeof *request);
    const int order[] = {0, 6, 1, 7, 2, 3, 4, 5};
    pen_http_waiting_init(waiting, true);
    for (int i = 0; i < 6; i++)
        add(waiting, &request[i], "192.0.2.1", 0);
    ck_assert_ptr_eq(serve(waiting, 0), &request[0]);
    for (int i = 6; i < 8; i++)
        add(waiting, &request[i], "192.0.2.2", 0);
    for (int i = 1; i < 8; i++)
        ck_assert_ptr_eq(serve(waiting, 0), &request[order[i]]);
    ck_assert_ptr_null(serve(waiting, 0));
    ck_assert_int_eq(waiting->count, 0);
    free(request);
    free(waiting);
}
END_TEST

/* Four requests, by these clients and of this work, wait; they are served in this order. */
static void expect_order(bool by_turns, const char *const *client, const size_t *work,
                         const int *order)
{
    struct waiting *waiting = malloc(sizeof *waiting);
    struct request *request = calloc(4, sizeof *request);
    pen_http_waiting_init(waiting, by_turns);
    for (int i = 0; i < 4; i++)
        add(waiting, &request[i], client[i], work[i]);
    for (int i = 0; i < 4; i++)
        ck_assert_ptr_eq(serve(waiting, 0), &request[order[i]]);
    free(request);
    free(waiting);
}

/* Of one client's requests the smallest is next, and of equal ones the oldest. */
START_TEST(test_turns__small_requests_come_first)
{
    expect_order(true, (const char *const[]){"", "", "", ""}, (const size_t[]){70, 20, 20, 10},
                 (const int[]){3, 1, 2, 0});
}
END_TEST

/* A large request waits, while others come and go from more clients than are remembered: it gets
 * its turn. */
START_TEST(test_turns__none_is_overtaken_for_ever)
{
    enum { OTHERS = 20 };
    struct waiting *waiting = malloc(sizeof *waiting);
    struct request *request = calloc(OTHERS + 1, sizeof *request);
    int before = 0;
    pen_http_waiting_init(waiting, true);
    add(waiting, &request[0], "192.0.2.1", 1000);
    for (int i = 1; i <= 2; i++)
        add(waiting, &request[i], "192.0.2.2", 1);
    while (before < OTHERS) {
        char client[32];
        const struct request *next = serve(waiting, 1000);
        if (next == &request[0])
            break;
        snprintf(client, sizeof client, "198.51.100.%d", before);
        add(waiting, &request[next - request], client, 1);
        before++;
    }
    ck_assert_int_le(before, 4);
    free(request);
    free(waiting);
}
END_TEST

/* Without turns all are served as they came. */
START_TEST(test_turns__a_plain_queue_keeps_the_order)
{
    expect_order(false, (const char *const[]){"192.0.2.1", "192.0.2.1", "192.0.2.1", "192.0.2.2"},
                 (const size_t[]){10, 9, 8, 7}, (const int[]){0, 1, 2, 3});
}
END_TEST

/* A server whose list of jobs takes a while to make. */
static void start_with_jobs(struct server *server, const struct server_options *options)
{
    enum { JOBS = 300 };
    char path[80];
    server_start(server, options);
    for (int i = 0; i < JOBS; i++)
        server_submit(server, path);
}

static int ask_list(const struct server *server)
{
    const int fd = server_connect(server);
    ck_assert(client_send(fd, "GET /v1/jobs?limit=500 HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    return fd;
}

/* Seconds that a list takes, asked for on a new connection. */
static double list_seconds(const struct server *server)
{
    const int64_t begun_ns = pen_clock_ns();
    ck_assert_int_eq(server_status(server, "GET /v1/jobs?limit=500 HTTP/1.1", NULL), 200);
    return (double)(pen_clock_ns() - begun_ns) * 1e-9;
}

enum { GONE = 200, ASKED = 250, TRIES = 3 }; /* in one of the tries nothing is held up */

/* Seconds that a list takes behind those of clients who ask and close at once. */
static double seconds_behind_gone(const struct server *server)
{
    for (int i = 0; i < GONE; i++)
        close(ask_list(server));
    return list_seconds(server);
}

/* The lists are not made for clients that have closed. */
START_TEST(test_turns__nothing_is_read_for_clients_that_have_gone)
{
    struct server server;
    start_with_jobs(&server, &(struct server_options){0});
    list_seconds(&server);
    const double alone = list_seconds(&server), most = 0.25 * GONE * alone;
    double behind = most;
    for (int i = 0; i < TRIES && behind >= most; i++)
        behind = seconds_behind_gone(&server);
    printf("# a list %.4f s, behind %d that nobody waits for %.4f s\n", alone, GONE, behind);
    ck_assert_timed(behind < most);
    for (int i = 0; i < 400 && atomic_load(&server.http->connections) > 0; i++)
        client_pause(10 * client_patience());
    ck_assert_int_eq(atomic_load(&server.http->connections), 0);
    server_stop(&server);
}
END_TEST

struct asked {
    int made, refused; /* lists */
    double ready;      /* seconds that /readyz took meanwhile */
};

/* Asks for many lists at once. Each is made or refused. */
static struct asked ask_lists(const struct server *server)
{
    struct asked asked = {0};
    int fd[ASKED];
    for (int i = 0; i < ASKED; i++)
        fd[i] = ask_list(server);
    const int64_t begun_ns = pen_clock_ns();
    ck_assert_int_eq(server_status(server, "GET /readyz HTTP/1.1", NULL), 200);
    asked.ready = (double)(pen_clock_ns() - begun_ns) * 1e-9;
    for (int i = 0; i < ASKED; i++) {
        struct answer answer;
        char after[20];
        client_read(fd[i], false, &answer);
        ck_assert_msg(answer.status == 200 || answer.status == 503, "%d", answer.status);
        asked.made += answer.status == 200;
        asked.refused += answer.status == 503;
        if (answer.status == 503)
            ck_assert_str_ne(answer_field(&answer, "Retry-After", after, sizeof after), "");
        answer_release(&answer);
        close(fd[i]);
    }
    return asked;
}

/* More lists are asked for than may wait: those beyond are refused at once, the others answered,
 * and what is short is not held up by either. */
START_TEST(test_turns__only_so_many_wait)
{
    enum { CONNECTIONS = 512 };
    struct server server;
    struct asked asked = {0};
    server_allow_many_files();
    start_with_jobs(&server, &(struct server_options){.connections = CONNECTIONS});
    const double alone = list_seconds(&server), most = 0.25 * ASKED * alone;
    for (int i = 0; i < TRIES && (asked.refused == 0 || asked.ready >= most); i++)
        asked = ask_lists(&server);
    printf("# a list %.4f s; of %d lists %d made, %d refused; /readyz meanwhile %.4f s\n", alone,
           ASKED, asked.made, asked.refused, asked.ready);
    ck_assert_int_ge(asked.made, CONNECTIONS / 8);
    ck_assert_int_gt(asked.refused, 0);
    ck_assert_double_lt(asked.ready, most);
    server_stop(&server);
}
END_TEST

enum { PICTURES = 8 };

/* A client asks for large pictures of a new job, then another for one. Returns how many of the
 * first are answered when the other is. */
static int count_before_other(const struct server *server)
{
    static const char body[] =
        "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9], \"look_at\":"
        " [0, 0, 0]}, \"objects\": [], \"render\": {\"width\": 2500, \"height\": 2500}}";
    struct answer answer;
    char path[80], head[200];
    int fd[PICTURES], done = 0;
    server_ask(server, "POST /v1/jobs HTTP/1.1", body, &answer);
    answer_field(&answer, "Location", path, sizeof path);
    answer_release(&answer);
    snprintf(head, sizeof head, "GET %s/preview HTTP/1.1\r\nHost: localhost\r\n\r\n", path);
    for (int i = 0; i < PICTURES; i++) {
        fd[i] = server_connect(server);
        ck_assert(client_send(fd[i], head));
    }
    client_pause(50);
    const int other = server_connect_from(server, "127.0.0.2");
    ck_assert(client_send(other, head));
    client_read(other, false, &answer);
    ck_assert_int_eq(answer.status, 200);
    answer_release(&answer);
    for (int i = 0; i < PICTURES; i++)
        done += client_sees_answer(fd[i]);
    close(other);
    for (int i = 0; i < PICTURES; i++)
        close(fd[i]);
    return done;
}

/* A client asks for many large pictures, then another for one as large. */
START_TEST(test_turns__large_pictures_of_two_clients)
{
    struct server server;
    int done = PICTURES;
    server_start(&server, &(struct server_options){0});
    for (int i = 0; i < TRIES && done > PICTURES / 2; i++)
        done = count_before_other(&server);
    printf("# %d of %d pictures of one client were before that of another\n", done, PICTURES);
    ck_assert_int_le(done, PICTURES / 2);
    server_stop(&server);
}
END_TEST

/* A scene of some 60 KB whose check takes a while: triangles along one line. */
static struct pen_buf long_check(void)
{
    struct pen_buf scene = {0};
    pen_buf_puts(&scene, "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
                         " \"look_at\": [0, 0, 0]}, \"objects\": [");
    for (int i = 0; i < 700; i++)
        pen_buf_printf(&scene,
                       "%s{\"type\": \"triangle\", \"vertices\": [[0, %d.1e-12, 0], [1, %d.3e-12, "
                       "0], [0, 0, %d.7e-12]]}",
                       i ? "," : "", i % 97 + 1, i, i + 1);
    pen_buf_puts(&scene, "]}");
    pen_buf_add(&scene, "", 1);
    ck_assert(!scene.failed);
    return scene;
}

enum { CHECKS = 12 };

/* A client has many scenes checked, and then a small one, and a picture made. Counts how many of
 * the first are answered when the small one is, and when the picture is. */
static void count_long_checks(const struct server *server, int done[2])
{
    static const char small[] = "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\":"
                                " [0, 0, 9], \"look_at\": [0, 0, 0]}, \"objects\": []}";
    struct pen_buf scene = long_check();
    char path[80], line[120], head[200];
    int fd[CHECKS];
    server_submit(server, path);
    snprintf(line, sizeof line, "GET %s/preview HTTP/1.1", path);
    snprintf(head, sizeof head,
             "POST /v1/validate HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
             "Content-Length: %zu\r\n\r\n",
             scene.bytes - 1);
    for (int i = 0; i < CHECKS; i++) {
        fd[i] = server_connect(server);
        ck_assert(client_send(fd[i], head) && client_send(fd[i], (const char *)scene.data));
    }
    client_pause(50);
    for (int k = 0; k < 2; k++) {
        const char *asked = k == 0 ? "POST /v1/validate HTTP/1.1" : line;
        done[k] = 0;
        ck_assert_int_eq(server_status(server, asked, k == 0 ? small : NULL), 200);
        for (int i = 0; i < CHECKS; i++)
            done[k] += client_sees_answer(fd[i]);
    }
    for (int i = 0; i < CHECKS; i++)
        close(fd[i]);
    pen_buf_release(&scene);
}

/* Neither waits for all of the long ones. */
START_TEST(test_turns__small_checks_and_pictures_come_first)
{
    struct server server;
    int done[2] = {CHECKS, CHECKS};
    server_start(&server, &(struct server_options){0});
    for (int i = 0; i < TRIES && (done[0] > CHECKS / 2 || done[1] >= CHECKS); i++)
        count_long_checks(&server, done);
    printf("# of %d long checks %d were before a short one, %d before a picture\n", CHECKS, done[0],
           done[1]);
    ck_assert_int_le(done[0], CHECKS / 2);
    ck_assert_int_lt(done[1], CHECKS);
    server_stop(&server);
}
END_TEST

static void expect_submitted(int fd)
{
    struct answer answer;
    client_read(fd, false, &answer);
    ck_assert_msg(answer.status == 202, "%d: %.200s", answer.status, answer.body);
    answer_release(&answer);
}

enum { SUBMITS = 60 };

/* Another writer keeps the store's one write lock, and more jobs are submitted than there are
 * threads: a read is answered. When the lock is free, a job is cancelled. Returns how many of the
 * submits are answered when the cancel is. */
static int count_before_cancel(const struct server *server)
{
    static const char submit[] = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                                 "Content-Length: 28\r\n\r\n{\"scene\": \"builtin:spheres\"}";
    char path[80], head[200];
    int fd[SUBMITS], done = 0;
    sqlite3 *db = NULL;
    server_submit(server, path);
    ck_assert_int_eq(sqlite3_open(server->store, &db), SQLITE_OK);
    ck_assert_int_eq(sqlite3_busy_timeout(db, 60000), SQLITE_OK);
    ck_assert_int_eq(sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL), SQLITE_OK);
    for (int i = 0; i < SUBMITS; i++) {
        fd[i] = server_connect(server);
        ck_assert(client_send(fd[i], submit));
    }
    client_pause(50);
    snprintf(head, sizeof head, "GET %s HTTP/1.1", path);
    ck_assert_int_eq(server_status(server, head, NULL), 200);
    for (int i = 0; i < SUBMITS; i++)
        done += client_sees_answer(fd[i]);
    ck_assert_int_eq(done, 0);
    snprintf(head, sizeof head, "POST %s/cancel HTTP/1.1\r\nHost: localhost\r\n\r\n", path);
    const int cancel = server_connect(server);
    ck_assert(client_send(cancel, head));
    client_pause(50);
    sqlite3_close(db);
    expect_submitted(cancel);
    for (int i = 0; i < SUBMITS; i++)
        done += client_sees_answer(fd[i]);
    close(cancel);
    for (int i = 0; i < SUBMITS; i++) {
        expect_submitted(fd[i]);
        close(fd[i]);
    }
    return done;
}

/* A cancel does not wait for all submits that wait for another writer. */
START_TEST(test_turns__only_writers_wait_for_writers)
{
    struct server server;
    int done = SUBMITS;
    server_start(&server, &(struct server_options){0});
    for (int i = 0; i < TRIES && done > SUBMITS - 10; i++)
        done = count_before_cancel(&server);
    printf("# %d of %d submits were before the cancel\n", done, SUBMITS);
    ck_assert_int_le(done, SUBMITS - 10);
    server_stop(&server);
}
END_TEST

/* A job that was stored tells what a probe of the store would. */
START_TEST(test_turns__a_stored_job_is_as_good_as_a_probe)
{
    struct server server;
    char path[80];
    server_start(&server, &(struct server_options){0});
    server_submit(&server, path);
    pthread_mutex_lock(&server.http->ready_lock);
    ck_assert_int_gt(server.http->ready_ns, 0);
    ck_assert_int_eq(server.http->ready.code, PEN_OK);
    pthread_mutex_unlock(&server.http->ready_lock);
    server_stop(&server);
}
END_TEST

PEN_SUITE("turns", test_turns__clients_take_turns, test_turns__small_requests_come_first,
          test_turns__none_is_overtaken_for_ever, test_turns__a_plain_queue_keeps_the_order,
          test_turns__nothing_is_read_for_clients_that_have_gone, test_turns__only_so_many_wait,
          test_turns__large_pictures_of_two_clients,
          test_turns__small_checks_and_pictures_come_first,
          test_turns__only_writers_wait_for_writers, test_turns__a_stored_job_is_as_good_as_a_probe)
