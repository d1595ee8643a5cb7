/* SPDX-License-Identifier: MIT */
#include "support/server.h"

#include <arpa/inet.h>
#include <check.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "jobs/worker.h"
#include "store/store.h"
#include "support/suite.h"

static int listen_on_free_port(int *port)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t bytes = sizeof address;
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq(bind(fd, (struct sockaddr *)&address, bytes), 0);
    ck_assert_int_eq(listen(fd, 1024), 0);
    ck_assert_int_eq(getsockname(fd, (struct sockaddr *)&address, &bytes), 0);
    *port = ntohs(address.sin_port);
    return fd;
}

static void *work(void *arg)
{
    struct server *server = arg;
    struct pen_status st;
    const struct pen_worker_options options = {
        .store_url = server->store, .id = "test:1:1", .threads = 2};
    ck_assert_msg(pen_worker_run(&options, &server->stop_worker, &st), "%s", st.msg);
    return NULL;
}

void server_start(struct server *server, const struct server_options *options)
{
    pen_log_set_level(PEN_LOG_ERROR);
    *server = (struct server){.has_worker = options->worker};
    snprintf(server->folder, sizeof server->folder, "/tmp/penumbra-test-XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(server->folder));
    snprintf(server->store, sizeof server->store, "%s/store.db", server->folder);
    server->listen_fd = listen_on_free_port(&server->port);
    struct pen_status st;
    struct pen_http_options http = {.listen_fd = server->listen_fd,
                                    .store_url = server->store,
                                    .limits = pen_limits_default(),
                                    .idle_seconds = options->idle_seconds,
                                    .heartbeat_ms = options->heartbeat_ms,
                                    .connections = options->connections,
                                    .trusted_proxy = options->trusted_proxy,
                                    .tokens = options->tokens,
                                    .cors = options->cors};
    if (options->body_bytes)
        http.limits.body_bytes = options->body_bytes;
    struct pen_store *made = pen_store_open(server->store, true, &st);
    ck_assert_msg(made != NULL, "%s", st.msg);
    pen_store_close(made);
    server->http = pen_http_start(&http, &st);
    ck_assert_msg(server->http != NULL, "%s", st.msg);
    ck_assert_msg(pen_http_open(server->http, &http, &st), "%s", st.msg);
    if (options->worker)
        ck_assert_int_eq(pthread_create(&server->worker, NULL, work, server), 0);
}

static void stop_worker(struct server *server)
{
    struct pen_status st;
    atomic_store(&server->stop_worker, true);
    struct pen_store *store = pen_store_open(server->store, false, &st);
    ck_assert_msg(store != NULL, "%s", st.msg);
    pen_store_wake(store);
    pthread_join(server->worker, NULL);
    pen_store_close(store);
}

void server_stop(struct server *server)
{
    if (server->has_worker)
        stop_worker(server);
    pen_http_stop(server->http);
    close(server->listen_fd);
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", server->folder);
    ck_assert_int_eq(system(command), 0);
}

int server_connect(const struct server *server)
{
    return server_connect_from(server, "127.0.0.1");
}

int client_patience(void)
{
    const char *multiplier = getenv("CK_TIMEOUT_MULTIPLIER");
    const int patience = multiplier ? atoi(multiplier) : 1;
    return patience > 1 ? patience : 1;
}

int server_connect_from(const struct server *server, const char *from)
{
    struct sockaddr_in own = {.sin_family = AF_INET};
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_port = htons((uint16_t)server->port),
                                  .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    struct timeval limit = {.tv_sec = SUITE_HANG_S};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    ck_assert_int_ge(fd, 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
    ck_assert_int_eq(inet_pton(AF_INET, from, &own.sin_addr), 1);
    ck_assert_int_eq(bind(fd, (struct sockaddr *)&own, sizeof own), 0);
    ck_assert_int_eq(connect(fd, (struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

bool client_send(int fd, const char *text)
{
    for (size_t left = strlen(text); left > 0;) {
        ssize_t sent = send(fd, text, left, MSG_NOSIGNAL);
        if (sent <= 0)
            return false;
        text += sent;
        left -= (size_t)sent;
    }
    return true;
}

/* Reads until the text holds `bytes` bytes. The head is read byte by byte, so that a pipelined
 * answer stays in the socket. */
static bool read_up_to(int fd, struct pen_buf *text, size_t bytes)
{
    char part[4096];
    while (text->bytes < bytes) {
        size_t wanted = bytes - text->bytes;
        ssize_t got = recv(fd, part, wanted < sizeof part ? wanted : sizeof part, 0);
        if (got <= 0)
            return false;
        pen_buf_add(text, part, (size_t)got);
    }
    return true;
}

void client_read(int fd, bool head_request, struct answer *answer)
{
    *answer = (struct answer){.body = ""};
    struct pen_buf *text = &answer->text;
    pen_buf_add(text, "", 0);
    const char *end = NULL;
    while (!end && read_up_to(fd, text, text->bytes + 1))
        end = strstr((const char *)text->data, "\r\n\r\n");
    if (!end || sscanf((const char *)text->data, "HTTP/1.%*d %d", &answer->status) != 1)
        return;
    size_t head = text->bytes;
    char length[32];
    answer_field(answer, "Content-Length", length, sizeof length);
    bool has_body = !head_request && answer->status >= 200 && answer->status != 304;
    if (has_body && !read_up_to(fd, text, head + strtoul(length, NULL, 10)))
        answer->status = 0;
    answer->body = (const char *)text->data + head;
}

void answer_release(struct answer *answer)
{
    pen_buf_release(&answer->text);
}

const char *answer_field(const struct answer *answer, const char *name, char *out, size_t bytes)
{
    const char *line = (const char *)answer->text.data;
    size_t length = strlen(name);
    out[0] = '\0';
    while ((line = strstr(line, "\r\n")) != NULL && line[2] != '\r') {
        line += 2;
        if (strncasecmp(line, name, length) != 0 || line[length] != ':')
            continue;
        line += length + 1;
        line += strspn(line, " ");
        snprintf(out, bytes, "%.*s", (int)strcspn(line, "\r"), line);
        break;
    }
    return out;
}

bool client_sees_answer(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) > 0;
}

static bool ends_within(int fd, int ms)
{
    char part[4096];
    struct pollfd readable = {.fd = fd, .events = POLLIN};
    while (poll(&readable, 1, ms) > 0) {
        if (recv(fd, part, sizeof part, 0) <= 0)
            return true;
    }
    return false;
}

bool client_sees_end(int fd)
{
    return ends_within(fd, 1000 * SUITE_HANG_S);
}

bool client_has_seen_end(int fd)
{
    return ends_within(fd, 0);
}

void server_ask(const struct server *server, const char *head, const char *body,
                struct answer *answer)
{
    struct pen_buf text = {0};
    pen_buf_printf(&text, "%s\r\nHost: localhost\r\n", head);
    if (body)
        pen_buf_printf(&text, "Content-Length: %zu\r\n", strlen(body));
    pen_buf_printf(&text, "\r\n%s", body ? body : "");
    int fd = server_connect(server);
    client_send(fd, (const char *)text.data);
    client_read(fd, strncmp(head, "HEAD ", 5) == 0, answer);
    close(fd);
    pen_buf_release(&text);
}

int server_status(const struct server *server, const char *head, const char *body)
{
    struct answer answer;
    server_ask(server, head, body, &answer);
    int status = answer.status;
    answer_release(&answer);
    return status;
}

void server_expect_alive(const struct server *server)
{
    ck_assert_int_eq(server_status(server, "GET /healthz HTTP/1.1", NULL), 200);
    ck_assert_int_eq(server_status(server, "GET /v1/jobs HTTP/1.1", NULL), 200);
}

void server_submit(const struct server *server, char path[80])
{
    struct answer answer;
    server_ask(server, "POST /v1/jobs HTTP/1.1",
               "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 32, \"height\": 24}}",
               &answer);
    ck_assert_msg(answer.status == 202, "%s", (const char *)answer.text.data);
    answer_field(&answer, "Location", path, 80);
    answer_release(&answer);
}

void server_open_polls(const struct server *server, const char *path, const char *fields, int *fds,
                       int count)
{
    char text[300];
    snprintf(text, sizeof text, "GET %s?wait=50 HTTP/1.1\r\nHost: localhost\r\n%s\r\n", path,
             fields);
    for (int i = 0; i < count; i++) {
        fds[i] = server_connect(server);
        client_send(fds[i], text);
    }
}

/* The value behind this text in /metrics, -1 if it is not there. */
static int metric_of(const struct server *server, const char *name)
{
    struct answer answer;
    server_ask(server, "GET /metrics HTTP/1.1", NULL, &answer);
    const char *found = strstr(answer.body, name);
    const int value = found ? atoi(found + strlen(name)) : -1;
    answer_release(&answer);
    return value;
}

void server_wait_for_waiters(const struct server *server, int polls, int streams)
{
    int polls_now = -1, streams_now = -1;
    for (int i = 0; i < 2000 && (polls_now < polls || streams_now < streams); i++) {
        client_pause(10 * client_patience());
        polls_now = metric_of(server, "\npenumbra_http_requests_in_progress{state=\"poll\"} ");
        streams_now = metric_of(server, "\npenumbra_sse_clients ");
    }
    ck_assert_int_ge(polls_now, polls);
    ck_assert_int_ge(streams_now, streams);
}

int client_first_answered(const int *fds, int count)
{
    struct pollfd *list = calloc((size_t)count, sizeof *list);
    ck_assert_ptr_nonnull(list);
    for (int i = 0; i < count; i++)
        list[i] = (struct pollfd){.fd = fds[i], .events = POLLIN};
    ck_assert_int_ge(poll(list, (nfds_t)count, 1000 * SUITE_HANG_S), 1);
    int first = 0;
    while (!list[first].revents)
        first++;
    free(list);
    return first;
}

void client_pause(long ms)
{
    const struct timespec pause = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000};
    nanosleep(&pause, NULL);
}

void server_allow_many_files(void)
{
    struct rlimit files;
    ck_assert_int_eq(getrlimit(RLIMIT_NOFILE, &files), 0);
    files.rlim_cur = files.rlim_max < 4096 ? files.rlim_max : 4096;
    ck_assert_int_eq(setrlimit(RLIMIT_NOFILE, &files), 0);
}
