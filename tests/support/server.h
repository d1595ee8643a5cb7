/* SPDX-License-Identifier: MIT */
/* An HTTP server inside the test process, on a free port with a store in a temporary folder. Also a
 * client that sends plain bytes, so that tests can send what no HTTP library would. */
#ifndef TESTS_SUPPORT_SERVER_H
#define TESTS_SUPPORT_SERVER_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "base/buf.h"
#include "http/server.h"

struct server {
    struct pen_http *http;
    int listen_fd, port;
    char folder[64], store[96];
    bool has_worker;
    pthread_t worker;
    atomic_bool stop_worker;
};

struct server_options {
    bool worker;               /* jobs are rendered */
    int idle_seconds;          /* as pen_http_options */
    int heartbeat_ms;          /* as pen_http_options */
    int connections;           /* as pen_http_options */
    const char *trusted_proxy; /* as pen_http_options */
    const char *tokens, *cors; /* as pen_http_options */
    size_t body_bytes;         /* the limit; 0: the default */
};

/* Start and stop the server. The test fails if that fails. */
void server_start(struct server *server, const struct server_options *options);
void server_stop(struct server *server);

/* Returns the factor for a client's waiting times: libcheck's CK_TIMEOUT_MULTIPLIER, which builds
 * with sanitizers set, or 1. */
int client_patience(void);

/* Returns a connected socket whose reads give up after SUITE_HANG_S. */
int server_connect(const struct server *server);

/* As server_connect, from another loopback address, such as "127.0.0.2". */
int server_connect_from(const struct server *server, const char *address);

/* Sends text. Returns false if the server has closed the connection. */
bool client_send(int fd, const char *text);

/* Reads one answer: the head, and a body of its Content-Length. The text is empty if the connection
 * ends or times out before. Owns: the caller releases *answer. */
struct answer {
    int status;
    struct pen_buf text; /* the whole answer */
    const char *body;    /* in text */
};
void client_read(int fd, bool head_request, struct answer *answer);
void answer_release(struct answer *answer);

/* Returns the value of a field of the answer, or "". */
const char *answer_field(const struct answer *answer, const char *name, char *out, size_t bytes);

/* Returns true if bytes of an answer have come. */
bool client_sees_answer(int fd);

/* Returns true if the server closes the connection within SUITE_HANG_S. */
bool client_sees_end(int fd);

/* Returns true if it has already closed the connection. */
bool client_has_seen_end(int fd);

/* Makes one request on a new connection. `head` is a request line and fields, without Host and the
 * empty line; body may be NULL. */
void server_ask(const struct server *server, const char *head, const char *body,
                struct answer *answer);

/* Returns the status of the answer to such a request. */
int server_status(const struct server *server, const char *head, const char *body);

/* Fails the test unless the server answers that it is alive, and reads its store. */
void server_expect_alive(const struct server *server);

/* Submits a small job and writes its path. */
void server_submit(const struct server *server, char path[80]);

/* Opens `count` long polls on a job, with further fields in separate lines. */
void server_open_polls(const struct server *server, const char *path, const char *fields, int *fds,
                       int count);

/* Waits until this number of long polls and event streams wait in the server. The test fails if
 * they do not. */
void server_wait_for_waiters(const struct server *server, int polls, int streams);

/* Waits until one of these connections can be read; returns its index. */
int client_first_answered(const int *fds, int count);

void client_pause(long ms);

/* Allows descriptors for both ends of some hundred connections. */
void server_allow_many_files(void);

#endif
