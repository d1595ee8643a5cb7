/* SPDX-License-Identifier: MIT */
/* Event streams: their events, resuming, their end, and clients that disconnect. The test commits
 * the batches itself, through the store. */
#include <jansson.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/clock.h"
#include "store/store.h"
#include "support/server.h"
#include "support/store.h"
#include "support/suite.h"

enum { WIDTH = 203, HEIGHT = 150, EVENTS = 4096 };

/* Two views of several batches each. */
static const char some_batches[] =
    "{\"scene\": {\"format\": \"penumbra-scene/1\","
    " \"camera\": {\"position\": [0, 1, 10], \"look_at\": [0, 0, 0]},"
    " \"views\": [{\"name\": \"left\"}, {\"name\": \"right\"}],"
    " \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 2}]},"
    " \"render\": {\"width\": 203, \"height\": 150, \"tile\": 14, \"samples_per_pixel\": 1024}}";

struct event {
    char type[16];
    int64_t id;
    json_t *data;
};

/* A client of one stream. */
struct client {
    int fd;
    struct pen_buf raw;  /* as received */
    struct pen_buf text; /* the body so far, without its framing */
    size_t head, taken;  /* bytes of raw before the body; bytes of raw that are in text already */
    size_t read;         /* bytes of text that were read as events */
    bool ended;          /* the last chunk was received */
    int heartbeats;
    struct event events[EVENTS];
    int count;
};

static struct server server;
static struct pen_store *store;
static char path[80], id[PEN_ID_BYTES];

static void set_up(const char *job, int heartbeat_ms)
{
    struct pen_status st;
    struct answer answer;
    server_start(&server, &(struct server_options){.heartbeat_ms = heartbeat_ms});
    store = pen_store_open(server.store, false, &st);
    store_must(store != NULL, &st, "open");
    server_ask(&server, "POST /v1/jobs HTTP/1.1", job, &answer);
    ck_assert_msg(answer.status == 202, "%s", (const char *)answer.text.data);
    answer_field(&answer, "Location", path, sizeof path);
    snprintf(id, sizeof id, "%s", strrchr(path, '/') + 1);
    answer_release(&answer);
}

static void tear_down(void)
{
    pen_store_close(store);
    server_stop(&server);
}

static void open_stream(struct client *client, const char *last_id)
{
    char text[300];
    *client = (struct client){.fd = server_connect(&server)};
    snprintf(text, sizeof text, "GET %s/events HTTP/1.1\r\nHost: localhost\r\n%s%s\r\n\r\n", path,
             last_id ? "Last-Event-ID: " : "Accept: text/event-stream", last_id ? last_id : "");
    ck_assert(client_send(client->fd, text));
}

static void close_stream(struct client *client)
{
    close(client->fd);
    for (int i = 0; i < client->count; i++)
        json_decref(client->events[i].data);
    pen_buf_release(&client->raw);
    pen_buf_release(&client->text);
}

/* Moves the contents of whole chunks from raw to text. */
static void unframe(struct client *client)
{
    pen_buf_add(&client->raw, "", 1); /* a terminating zero for strstr, removed again below */
    client->raw.bytes--;
    char *raw = (char *)client->raw.data;
    if (!client->head) {
        char *end = strstr(raw, "\r\n\r\n");
        if (!end)
            return;
        ck_assert_msg(strncmp(raw, "HTTP/1.1 200", 12) == 0, "%s", raw);
        ck_assert_ptr_nonnull(strstr(raw, "Content-Type: text/event-stream\r\n"));
        client->head = client->taken = (size_t)(end + 4 - raw);
    }
    for (;;) {
        char *size = raw + client->taken, *line = strstr(size, "\r\n");
        size_t bytes = line ? strtoul(size, NULL, 16) : 0;
        size_t whole = line ? (size_t)(line - size) + 2 + bytes + 2 : 0;
        if (!line || client->taken + whole > client->raw.bytes)
            return;
        client->ended = bytes == 0;
        pen_buf_add(&client->text, line + 2, bytes);
        client->taken += whole;
        if (client->ended)
            return;
    }
}

/* Reads one block of lines: an event, a comment, or the time to retry. */
static void read_block(struct client *client, char *block)
{
    if (block[0] == ':') {
        client->heartbeats++;
        return;
    }
    if (strncmp(block, "retry: ", 7) == 0)
        return;
    ck_assert_int_lt(client->count, EVENTS);
    struct event *event = &client->events[client->count++];
    long long number;
    int data = 0;
    ck_assert_msg(sscanf(block, "event: %15s\nid: %lld\ndata: %n", event->type, &number, &data) ==
                          2 &&
                      data > 0,
                  "%s", block);
    event->id = number;
    ck_assert_ptr_null(strchr(block + data, '\n'));
    event->data = json_loads(block + data, 0, NULL);
    ck_assert_msg(event->data != NULL, "%s", block);
}

static void read_blocks(struct client *client)
{
    pen_buf_add(&client->text, "", 1);
    client->text.bytes--;
    char *text = (char *)client->text.data + client->read, *end;
    for (; (end = strstr(text, "\n\n")) != NULL; text = end + 2) {
        *end = '\0';
        read_block(client, text);
    }
    client->read = (size_t)(text - (char *)client->text.data);
}

/* Reads once. Returns false if the connection is closed or silent for too long. */
static bool read_some(struct client *client)
{
    char part[65536];
    ssize_t got = recv(client->fd, part, sizeof part, 0);
    if (got <= 0)
        return false;
    pen_buf_add(&client->raw, part, (size_t)got);
    unframe(client);
    read_blocks(client);
    return true;
}

static void read_to_end(struct client *client)
{
    while (!client->ended)
        ck_assert_msg(read_some(client), "the stream is silent after %d events", client->count);
}

/* Reads until there were `count` events about the job. */
static void read_job_events(struct client *client, int count)
{
    for (;;) {
        int found = 0;
        for (int i = 0; i < client->count; i++)
            found += strcmp(client->events[i].type, "tile") != 0;
        if (found >= count)
            return;
        ck_assert_msg(read_some(client), "%d of %d events", found, count);
    }
}

static const char *state_of(const struct event *event)
{
    const char *state = json_string_value(json_object_get(event->data, "state"));
    return state ? state : "";
}

static int number_of(const struct event *event, const char *key)
{
    return (int)json_integer_value(json_object_get(event->data, key));
}

static void expect_growing_ids(const struct client *client, int64_t after)
{
    for (int i = 0; i < client->count; i++) {
        ck_assert_int_gt(client->events[i].id, after);
        after = client->events[i].id;
    }
}

/* The tiles cover each pixel of both views once. */
static void expect_whole_pictures(const struct client *client)
{
    static unsigned char covered[2][WIDTH * HEIGHT];
    memset(covered, 0, sizeof covered);
    for (int i = 0; i < client->count; i++) {
        const struct event *event = &client->events[i];
        if (strcmp(event->type, "tile") != 0)
            continue;
        const char *view = json_string_value(json_object_get(event->data, "view"));
        int x = number_of(event, "x"), y = number_of(event, "y");
        for (int n = 0; n < number_of(event, "width") * number_of(event, "height"); n++)
            covered[strcmp(view, "left") != 0][(y + n / number_of(event, "width")) * WIDTH + x +
                                               n % number_of(event, "width")]++;
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        ck_assert(covered[0][i] == 1 && covered[1][i] == 1);
}

START_TEST(test_events__follow_a_job_from_queue_to_end)
{
    static struct client client;
    set_up(some_batches, 0);
    open_stream(&client, NULL);
    read_job_events(&client, 1);
    ck_assert_int_eq(client.count, 1);
    ck_assert_str_eq(client.events[0].type, "state");
    ck_assert_str_eq(state_of(&client.events[0]), "queued");
    struct pen_claim claim = store_claim(store, "w");
    read_job_events(&client, 2);
    ck_assert_str_eq(client.events[1].type, "state");
    ck_assert_str_eq(state_of(&client.events[1]), "running");
    ck_assert_int_eq(store_commit(store, &claim), PEN_OK);
    read_job_events(&client, 3);
    const struct event *last = &client.events[client.count - 1];
    ck_assert_int_gt(client.count, 3);
    ck_assert_str_eq(client.events[2].type, "tile");
    ck_assert_str_eq(last->type, "progress");
    json_t *progress = json_object_get(last->data, "progress");
    ck_assert_int_eq(json_integer_value(json_object_get(progress, "done")), claim.pixels);
    ck_assert_int_gt(store_work_off(store, "w"), 4);
    read_to_end(&client);
    last = &client.events[client.count - 1];
    ck_assert_str_eq(last->type, "state");
    ck_assert_str_eq(state_of(last), "succeeded");
    expect_growing_ids(&client, 0);
    expect_whole_pictures(&client);
    close_stream(&client);
    tear_down();
}
END_TEST

START_TEST(test_events__cancelled_job_ends_its_streams)
{
    static struct client client;
    char head[160];
    set_up(some_batches, 0);
    open_stream(&client, NULL);
    read_job_events(&client, 1);
    snprintf(head, sizeof head, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 202);
    read_to_end(&client);
    ck_assert_int_eq(client.count, 2);
    ck_assert_str_eq(state_of(&client.events[1]), "cancelled");
    close_stream(&client);
    tear_down();
}
END_TEST

START_TEST(test_events__resume_after_any_id)
{
    static struct client all, rest;
    set_up(some_batches, 0);
    open_stream(&all, NULL);
    read_job_events(&all, 1);
    store_work_off(store, "w");
    read_to_end(&all);
    static struct event tiles[EVENTS];
    int tile_count = 0;
    for (int i = 0; i < all.count; i++) {
        if (strcmp(all.events[i].type, "tile") == 0)
            tiles[tile_count++] = all.events[i];
    }
    int64_t final = all.events[all.count - 1].id;
    for (int i = 0; i + 1 < all.count; i++) {
        char last_id[32];
        int64_t after = all.events[i].id;
        snprintf(last_id, sizeof last_id, "%lld", (long long)after);
        open_stream(&rest, last_id);
        read_to_end(&rest);
        int skip = 0;
        while (skip < tile_count && tiles[skip].id <= after)
            skip++;
        ck_assert_int_eq(rest.count, tile_count - skip + 1);
        for (int k = 0; k + 1 < rest.count; k++) {
            ck_assert_int_eq(rest.events[k].id, tiles[skip + k].id);
            ck_assert(json_equal(rest.events[k].data, tiles[skip + k].data));
        }
        ck_assert_int_eq(rest.events[rest.count - 1].id, final);
        ck_assert_str_eq(state_of(&rest.events[rest.count - 1]), "succeeded");
        close_stream(&rest);
    }
    close_stream(&all);
    tear_down();
}
END_TEST

START_TEST(test_events__unusable_ids_begin_anew_and_the_last_id_ends)
{
    static struct client client;
    static const char *const unusable[] = {"nonsense", "-4", "999999999", "99999999999999999999",
                                           "12;",      "0"};
    char head[200];
    set_up(some_batches, 0);
    store_work_off(store, "w");
    open_stream(&client, NULL);
    read_to_end(&client);
    int all = client.count;
    int64_t final = client.events[all - 1].id;
    close_stream(&client);
    for (size_t i = 0; i < sizeof unusable / sizeof unusable[0]; i++) {
        open_stream(&client, unusable[i]);
        read_to_end(&client);
        ck_assert_int_eq(client.count, all);
        close_stream(&client);
    }
    snprintf(head, sizeof head, "GET %s/events HTTP/1.1\r\nLast-Event-ID: %lld", path,
             (long long) final);
    ck_assert_int_eq(server_status(&server, head, NULL), 204);
    snprintf(head, sizeof head, "HEAD %s/events HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 200);
    snprintf(head, sizeof head, "POST %s/events HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 405);
    snprintf(head, sizeof head, "GET %s/events?from=3 HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, head, NULL), 400);
    ck_assert_int_eq(
        server_status(&server, "GET /v1/jobs/01890a5d-ac96-774b-bcce-b302099a8057/events HTTP/1.1",
                      NULL),
        404);
    tear_down();
}
END_TEST

/* More commits than one text holds. */
START_TEST(test_events__many_missed_events_come_in_several_texts)
{
    static struct client client;
    set_up("{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 400, \"height\": 300,"
           " \"tile\": 8, \"samples_per_pixel\": 7000}}",
           0);
    ck_assert_int_gt(store_work_off(store, "w"), 300);
    open_stream(&client, NULL);
    read_to_end(&client);
    ck_assert_int_gt(client.count, 300);
    expect_growing_ids(&client, 0);
    int64_t pixels = 0;
    for (int i = 0; i + 1 < client.count; i++)
        pixels += number_of(&client.events[i], "width") * number_of(&client.events[i], "height");
    ck_assert_int_eq(pixels, 400 * 300);
    ck_assert_str_eq(state_of(&client.events[client.count - 1]), "succeeded");
    close_stream(&client);
    tear_down();
}
END_TEST

START_TEST(test_events__silent_streams_get_heartbeats)
{
    static struct client client;
    set_up(some_batches, 100);
    open_stream(&client, NULL);
    while (client.heartbeats < 3)
        ck_assert(read_some(&client));
    ck_assert_int_eq(client.count, 1);
    ck_assert(!client.ended);
    close_stream(&client);
    tear_down();
}
END_TEST

enum { WAITERS_MAX = 512 };

static void open_waiters(int fds[WAITERS_MAX], const char *what)
{
    char text[200];
    snprintf(text, sizeof text, "GET %s%s HTTP/1.1\r\nHost: localhost\r\n\r\n", path, what);
    for (int i = 0; i < WAITERS_MAX; i++) {
        fds[i] = server_connect(&server);
        ck_assert(client_send(fds[i], text));
    }
}

START_TEST(test_events__have_a_limit_of_their_own_and_release_it)
{
    server_allow_many_files();
    static int fds[WAITERS_MAX], polls[WAITERS_MAX];
    struct answer answer;
    char head[160], text[32];
    set_up(some_batches, 100);
    open_waiters(polls, "?wait=60");
    open_waiters(fds, "/events");
    server_wait_for_waiters(&server, WAITERS_MAX, WAITERS_MAX);
    snprintf(head, sizeof head, "GET %s/events HTTP/1.1", path);
    server_ask(&server, head, NULL, &answer);
    ck_assert_int_eq(answer.status, 503);
    ck_assert_str_ne(answer_field(&answer, "Retry-After", text, sizeof text), "");
    answer_release(&answer);
    ck_assert_int_eq(server_status(&server, "GET /v1/jobs HTTP/1.1", NULL), 200);
    for (int i = 0; i < WAITERS_MAX; i++)
        close(fds[i]); /* the streams disconnect, the polls stay */
    static struct client client;
    int64_t begun = pen_clock_ns();
    int status = 503;
    while (status == 503 && pen_clock_ns() - begun < INT64_C(1000000000) * SUITE_HANG_S) {
        client_pause(50);
        int fd = server_connect(&server);
        snprintf(head, sizeof head, "GET %s/events HTTP/1.0\r\nHost: localhost\r\n\r\n", path);
        client_send(fd, head);
        char line[16] = "";
        recv(fd, line, sizeof line - 1, 0);
        status = atoi(line + 9);
        close(fd);
    }
    ck_assert_int_eq(status, 200);
    open_stream(&client, NULL);
    read_job_events(&client, 1);
    for (int i = 0; i < WAITERS_MAX; i++)
        close(polls[i]);
    close_stream(&client);
    tear_down();
}
END_TEST

START_TEST(test_events__reach_all_clients)
{
    enum { CLIENTS = 100 };
    server_allow_many_files();
    static struct client clients[CLIENTS];
    set_up(some_batches, 0);
    for (int i = 0; i < CLIENTS; i++)
        open_stream(&clients[i], NULL);
    for (int i = 0; i < CLIENTS; i += 2)
        read_job_events(&clients[i], 1); /* other clients may still be connecting */
    store_work_off(store, "w");
    for (int i = 0; i < CLIENTS; i++) {
        read_to_end(&clients[i]);
        expect_growing_ids(&clients[i], 0);
        expect_whole_pictures(&clients[i]);
        ck_assert_str_eq(state_of(&clients[i].events[clients[i].count - 1]), "succeeded");
        close_stream(&clients[i]);
    }
    tear_down();
}
END_TEST

START_TEST(test_events__end_when_the_server_stops)
{
    enum { CLIENTS = 20 };
    static struct client clients[CLIENTS];
    set_up(some_batches, 0);
    for (int i = 0; i < CLIENTS; i++) {
        open_stream(&clients[i], NULL);
        read_job_events(&clients[i], 1);
    }
    int64_t begun = pen_clock_ns();
    tear_down();
    ck_assert_timed((pen_clock_ns() - begun) / 1000000 < 15000);
    for (int i = 0; i < CLIENTS; i++) {
        read_to_end(&clients[i]);
        ck_assert_int_eq(clients[i].count, 1);
        close_stream(&clients[i]);
    }
}
END_TEST

/* The server's end of a client's connection; both are in this process. */
static int find_other_end(int fd)
{
    struct sockaddr_in own, peer;
    socklen_t bytes = sizeof own;
    ck_assert_int_eq(getsockname(fd, (struct sockaddr *)&own, &bytes), 0);
    for (int other = 0; other < 1024; other++) {
        bytes = sizeof peer;
        if (getpeername(other, (struct sockaddr *)&peer, &bytes) == 0 &&
            peer.sin_family == AF_INET && peer.sin_port == own.sin_port)
            return other;
    }
    ck_abort_msg("no socket");
}

/* The ms without an acknowledgement after which the server ends a connection; 0: the kernel's
 * choice. */
static int unanswered_ms(int fd)
{
    int ms = -1;
    socklen_t bytes = sizeof ms;
    ck_assert_int_eq(getsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &ms, &bytes), 0);
    return ms;
}

/* The timeout of a stream does not apply to a later answer that the client reads slowly. */
START_TEST(test_events__leave_their_connection_as_it_was)
{
    struct client *client = malloc(sizeof *client);
    struct answer answer;
    char text[200];
    set_up("{\"scene\": \"builtin:spheres\"}", 0);
    open_stream(client, NULL);
    client_first_answered(&client->fd, 1);
    const int other = find_other_end(client->fd);
    ck_assert_int_gt(unanswered_ms(other), 0);
    snprintf(text, sizeof text, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(server_status(&server, text, NULL), 202);
    read_to_end(client);
    snprintf(text, sizeof text, "GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n", path);
    ck_assert(client_send(client->fd, text));
    client_read(client->fd, false, &answer);
    ck_assert_int_eq(answer.status, 200);
    answer_release(&answer);
    ck_assert_int_eq(unanswered_ms(other), 0);
    close_stream(client);
    free(client);
    tear_down();
}
END_TEST

PEN_SUITE("events", test_events__follow_a_job_from_queue_to_end,
          test_events__cancelled_job_ends_its_streams, test_events__resume_after_any_id,
          test_events__unusable_ids_begin_anew_and_the_last_id_ends,
          test_events__many_missed_events_come_in_several_texts,
          test_events__silent_streams_get_heartbeats,
          test_events__have_a_limit_of_their_own_and_release_it, test_events__reach_all_clients,
          test_events__end_when_the_server_stops, test_events__leave_their_connection_as_it_was)
