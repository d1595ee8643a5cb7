/* SPDX-License-Identifier: MIT */
/* Event streams: what they tell, where they go on, when they end, and what becomes of clients that
 * leave. Batches are committed by the test itself, through the store. */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
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
struct listener {
    int fd;
    struct pen_buf raw;  /* as received */
    struct pen_buf text; /* the body so far, without its framing */
    size_t head, taken;  /* bytes of raw before the body; bytes of raw already in text */
    size_t read;         /* bytes of text already taken as events */
    bool ended;          /* the last chunk has come */
    int beats;
    struct event events[EVENTS];
    int count;
};

static struct server server;
static struct pen_store *store;
static char path[80], id[PEN_ID_BYTES];

static void pause_ms(long ms)
{
    const struct timespec pause = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    nanosleep(&pause, NULL);
}

static void set_up(const char *job, int heartbeat_ms)
{
    struct pen_status st;
    struct answer answer;
    server_start(&server, &(struct server_options){.heartbeat_ms = heartbeat_ms});
    store = pen_store_open(server.store, &st);
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

static void listen_from(struct listener *listener, const char *last_id)
{
    char text[300];
    *listener = (struct listener){.fd = server_connect(&server)};
    snprintf(text, sizeof text, "GET %s/events HTTP/1.1\r\nHost: localhost\r\n%s%s\r\n\r\n", path,
             last_id ? "Last-Event-ID: " : "Accept: text/event-stream", last_id ? last_id : "");
    ck_assert(client_send(listener->fd, text));
}

static void leave(struct listener *listener)
{
    close(listener->fd);
    for (int i = 0; i < listener->count; i++)
        json_decref(listener->events[i].data);
    pen_buf_release(&listener->raw);
    pen_buf_release(&listener->text);
}

/* Takes whole chunks out of what has come. */
static void unframe(struct listener *listener)
{
    pen_buf_add(&listener->raw, "", 1); /* an end for the string functions, taken off again */
    listener->raw.bytes--;
    char *raw = (char *)listener->raw.data;
    if (!listener->head) {
        char *end = strstr(raw, "\r\n\r\n");
        if (!end)
            return;
        ck_assert_msg(strncmp(raw, "HTTP/1.1 200", 12) == 0, "%s", raw);
        ck_assert_ptr_nonnull(strstr(raw, "Content-Type: text/event-stream\r\n"));
        listener->head = listener->taken = (size_t)(end + 4 - raw);
    }
    for (;;) {
        char *size = raw + listener->taken, *line = strstr(size, "\r\n");
        size_t bytes = line ? strtoul(size, NULL, 16) : 0;
        size_t whole = line ? (size_t)(line - size) + 2 + bytes + 2 : 0;
        if (!line || listener->taken + whole > listener->raw.bytes)
            return;
        listener->ended = bytes == 0;
        pen_buf_add(&listener->text, line + 2, bytes);
        listener->taken += whole;
        if (listener->ended)
            return;
    }
}

/* One block of lines: an event, a comment, or the time to retry. */
static void read_block(struct listener *listener, char *block)
{
    if (block[0] == ':') {
        listener->beats++;
        return;
    }
    if (strncmp(block, "retry: ", 7) == 0)
        return;
    ck_assert_int_lt(listener->count, EVENTS);
    struct event *event = &listener->events[listener->count++];
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

static void read_blocks(struct listener *listener)
{
    pen_buf_add(&listener->text, "", 1);
    listener->text.bytes--;
    char *text = (char *)listener->text.data + listener->read, *end;
    for (; (end = strstr(text, "\n\n")) != NULL; text = end + 2) {
        *end = '\0';
        read_block(listener, text);
    }
    listener->read = (size_t)(text - (char *)listener->text.data);
}

/* Reads once; false when the connection is closed or silent for too long. */
static bool hear(struct listener *listener)
{
    char part[65536];
    ssize_t got = recv(listener->fd, part, sizeof part, 0);
    if (got <= 0)
        return false;
    pen_buf_add(&listener->raw, part, (size_t)got);
    unframe(listener);
    read_blocks(listener);
    return true;
}

static void hear_out(struct listener *listener)
{
    while (!listener->ended)
        ck_assert_msg(hear(listener), "the stream is silent after %d events", listener->count);
}

/* Reads until there were `count` events about the job. */
static void hear_of_job(struct listener *listener, int count)
{
    for (;;) {
        int found = 0;
        for (int i = 0; i < listener->count; i++)
            found += strcmp(listener->events[i].type, "tile") != 0;
        if (found >= count)
            return;
        ck_assert_msg(hear(listener), "%d of %d events", found, count);
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

static void expect_growing_ids(const struct listener *listener, int64_t after)
{
    for (int i = 0; i < listener->count; i++) {
        ck_assert_int_gt(listener->events[i].id, after);
        after = listener->events[i].id;
    }
}

/* Each pixel of both views was told once. */
static void expect_whole_pictures(const struct listener *listener)
{
    static unsigned char told[2][WIDTH * HEIGHT];
    memset(told, 0, sizeof told);
    for (int i = 0; i < listener->count; i++) {
        const struct event *event = &listener->events[i];
        if (strcmp(event->type, "tile") != 0)
            continue;
        const char *view = json_string_value(json_object_get(event->data, "view"));
        int x = number_of(event, "x"), y = number_of(event, "y");
        for (int n = 0; n < number_of(event, "width") * number_of(event, "height"); n++)
            told[strcmp(view, "left") != 0]
                [(y + n / number_of(event, "width")) * WIDTH + x + n % number_of(event, "width")]++;
    }
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        ck_assert(told[0][i] == 1 && told[1][i] == 1);
}

static int status_of(const char *head)
{
    struct answer answer;
    server_ask(&server, head, NULL, &answer);
    int status = answer.status;
    answer_release(&answer);
    return status;
}

START_TEST(test_events__tell_a_job_from_queue_to_end)
{
    static struct listener ear;
    set_up(some_batches, 0);
    listen_from(&ear, NULL);
    hear_of_job(&ear, 1);
    ck_assert_int_eq(ear.count, 1);
    ck_assert_str_eq(ear.events[0].type, "state");
    ck_assert_str_eq(state_of(&ear.events[0]), "queued");
    struct pen_claim claim = store_claim(store, "w");
    hear_of_job(&ear, 2);
    ck_assert_str_eq(ear.events[1].type, "state");
    ck_assert_str_eq(state_of(&ear.events[1]), "running");
    ck_assert_int_eq(store_commit(store, &claim), PEN_OK);
    hear_of_job(&ear, 3);
    const struct event *last = &ear.events[ear.count - 1];
    ck_assert_int_gt(ear.count, 3);
    ck_assert_str_eq(ear.events[2].type, "tile");
    ck_assert_str_eq(last->type, "progress");
    json_t *progress = json_object_get(last->data, "progress");
    ck_assert_int_eq(json_integer_value(json_object_get(progress, "done")), claim.pixels);
    ck_assert_int_gt(store_work_off(store, "w"), 4);
    hear_out(&ear);
    last = &ear.events[ear.count - 1];
    ck_assert_str_eq(last->type, "state");
    ck_assert_str_eq(state_of(last), "succeeded");
    expect_growing_ids(&ear, 0);
    expect_whole_pictures(&ear);
    leave(&ear);
    tear_down();
}
END_TEST

START_TEST(test_events__cancelled_job_ends_its_streams)
{
    static struct listener ear;
    char head[160];
    set_up(some_batches, 0);
    listen_from(&ear, NULL);
    hear_of_job(&ear, 1);
    snprintf(head, sizeof head, "POST %s/cancel HTTP/1.1", path);
    ck_assert_int_eq(status_of(head), 202);
    hear_out(&ear);
    ck_assert_int_eq(ear.count, 2);
    ck_assert_str_eq(state_of(&ear.events[1]), "cancelled");
    leave(&ear);
    tear_down();
}
END_TEST

START_TEST(test_events__go_on_after_any_id)
{
    static struct listener all, rest;
    set_up(some_batches, 0);
    listen_from(&all, NULL);
    hear_of_job(&all, 1);
    store_work_off(store, "w");
    hear_out(&all);
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
        listen_from(&rest, last_id);
        hear_out(&rest);
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
        leave(&rest);
    }
    leave(&all);
    tear_down();
}
END_TEST

START_TEST(test_events__of_old_and_of_foreign_clients)
{
    static struct listener ear;
    static const char *const foreign[] = {"nonsense", "-4", "999999999", "99999999999999999999",
                                          "12;",      "0"};
    char head[200];
    set_up(some_batches, 0);
    store_work_off(store, "w");
    listen_from(&ear, NULL);
    hear_out(&ear);
    int all = ear.count;
    int64_t final = ear.events[all - 1].id;
    leave(&ear);
    for (size_t i = 0; i < sizeof foreign / sizeof foreign[0]; i++) {
        listen_from(&ear, foreign[i]);
        hear_out(&ear);
        ck_assert_int_eq(ear.count, all);
        leave(&ear);
    }
    snprintf(head, sizeof head, "GET %s/events HTTP/1.1\r\nLast-Event-ID: %lld", path,
             (long long) final);
    ck_assert_int_eq(status_of(head), 204);
    snprintf(head, sizeof head, "HEAD %s/events HTTP/1.1", path);
    ck_assert_int_eq(status_of(head), 200);
    snprintf(head, sizeof head, "POST %s/events HTTP/1.1", path);
    ck_assert_int_eq(status_of(head), 405);
    snprintf(head, sizeof head, "GET %s/events?from=3 HTTP/1.1", path);
    ck_assert_int_eq(status_of(head), 400);
    ck_assert_int_eq(status_of("GET /v1/jobs/01890a5d-ac96-774b-bcce-b302099a8057/events HTTP/1.1"),
                     404);
    tear_down();
}
END_TEST

/* More commits than one text holds. */
START_TEST(test_events__of_a_long_past_come_in_several_texts)
{
    static struct listener ear;
    set_up("{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 400, \"height\": 300,"
           " \"tile\": 8, \"samples_per_pixel\": 3500}}",
           0);
    ck_assert_int_gt(store_work_off(store, "w"), 300);
    listen_from(&ear, NULL);
    hear_out(&ear);
    ck_assert_int_gt(ear.count, 300);
    expect_growing_ids(&ear, 0);
    int64_t pixels = 0;
    for (int i = 0; i + 1 < ear.count; i++)
        pixels += number_of(&ear.events[i], "width") * number_of(&ear.events[i], "height");
    ck_assert_int_eq(pixels, 400 * 300);
    ck_assert_str_eq(state_of(&ear.events[ear.count - 1]), "succeeded");
    leave(&ear);
    tear_down();
}
END_TEST

START_TEST(test_events__silent_streams_beat)
{
    static struct listener ear;
    set_up(some_batches, 100);
    listen_from(&ear, NULL);
    while (ear.beats < 3)
        ck_assert(hear(&ear));
    ck_assert_int_eq(ear.count, 1);
    ck_assert(!ear.ended);
    leave(&ear);
    tear_down();
}
END_TEST

enum { PLACES = 512 };

/* Descriptors for both ends of some hundred connections. */
static void allow_many_files(void)
{
    struct rlimit files;
    ck_assert_int_eq(getrlimit(RLIMIT_NOFILE, &files), 0);
    files.rlim_cur = files.rlim_max < 4096 ? files.rlim_max : 4096;
    ck_assert_int_eq(setrlimit(RLIMIT_NOFILE, &files), 0);
}

/* Opens streams and long polls in turn. */
static void fill_places(int fds[PLACES])
{
    char text[200];
    for (int i = 0; i < PLACES; i++) {
        fds[i] = server_connect(&server);
        snprintf(text, sizeof text, "GET %s%s HTTP/1.1\r\nHost: localhost\r\n\r\n", path,
                 i % 2 ? "/events" : "?wait=60");
        ck_assert(client_send(fds[i], text));
    }
}

START_TEST(test_events__share_their_places_with_polls_and_give_them_back)
{
    allow_many_files();
    static int fds[PLACES];
    struct answer answer;
    char head[160], text[32];
    set_up(some_batches, 100);
    fill_places(fds);
    pause_ms(1000);
    snprintf(head, sizeof head, "GET %s/events HTTP/1.1", path);
    server_ask(&server, head, NULL, &answer);
    ck_assert_int_eq(answer.status, 503);
    ck_assert_str_ne(answer_field(&answer, "Retry-After", text, sizeof text), "");
    answer_release(&answer);
    ck_assert_int_eq(status_of("GET /v1/jobs HTTP/1.1"), 200);
    for (int i = 1; i < PLACES; i += 2)
        close(fds[i]); /* the streams vanish, the polls stay */
    static struct listener ear;
    int64_t begun = pen_clock_ns();
    int status = 503;
    while (status == 503 && pen_clock_ns() - begun < INT64_C(10000000000)) {
        pause_ms(50);
        int fd = server_connect(&server);
        snprintf(head, sizeof head, "GET %s/events HTTP/1.0\r\nHost: localhost\r\n\r\n", path);
        client_send(fd, head);
        char line[16] = "";
        recv(fd, line, sizeof line - 1, 0);
        status = atoi(line + 9);
        close(fd);
    }
    ck_assert_int_eq(status, 200);
    listen_from(&ear, NULL);
    hear_of_job(&ear, 1);
    for (int i = 0; i < PLACES; i += 2)
        close(fds[i]);
    leave(&ear);
    tear_down();
}
END_TEST

START_TEST(test_events__reach_all_listeners)
{
    enum { LISTENERS = 100 };
    allow_many_files();
    static struct listener ears[LISTENERS];
    set_up(some_batches, 0);
    for (int i = 0; i < LISTENERS; i++)
        listen_from(&ears[i], NULL);
    for (int i = 0; i < LISTENERS; i += 2)
        hear_of_job(&ears[i], 1); /* the others are still on their way */
    store_work_off(store, "w");
    for (int i = 0; i < LISTENERS; i++) {
        hear_out(&ears[i]);
        expect_growing_ids(&ears[i], 0);
        expect_whole_pictures(&ears[i]);
        ck_assert_str_eq(state_of(&ears[i].events[ears[i].count - 1]), "succeeded");
        leave(&ears[i]);
    }
    tear_down();
}
END_TEST

START_TEST(test_events__end_when_the_server_stops)
{
    enum { LISTENERS = 20 };
    static struct listener ears[LISTENERS];
    set_up(some_batches, 0);
    for (int i = 0; i < LISTENERS; i++) {
        listen_from(&ears[i], NULL);
        hear_of_job(&ears[i], 1);
    }
    int64_t begun = pen_clock_ns();
    tear_down();
    ck_assert_int_lt((pen_clock_ns() - begun) / 1000000, 3000);
    for (int i = 0; i < LISTENERS; i++) {
        hear_out(&ears[i]);
        ck_assert_int_eq(ears[i].count, 1);
        leave(&ears[i]);
    }
}
END_TEST

PEN_SUITE("events", test_events__tell_a_job_from_queue_to_end,
          test_events__cancelled_job_ends_its_streams, test_events__go_on_after_any_id,
          test_events__of_old_and_of_foreign_clients,
          test_events__of_a_long_past_come_in_several_texts, test_events__silent_streams_beat,
          test_events__share_their_places_with_polls_and_give_them_back,
          test_events__reach_all_listeners, test_events__end_when_the_server_stops)
