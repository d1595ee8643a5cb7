/* SPDX-License-Identifier: MIT */
/* The acceptor thread accepts connections and gives them to libmicrohttpd, which accepts none
 * itself, for three reasons:
 *   - MHD_quiesce_daemon races with the library's threads.
 *   - MHD_stop_daemon shuts the listening socket down, but the socket belongs to the supervisor.
 *   - A thread of the library that has its share of the limit stops accepting silently. So the
 *     library's limit is far above the guard's, and the guard closes idle connections.
 *
 * TLS is served in poll mode, since in epoll mode a stalled handshake keeps a thread busy (0.9.75,
 * 1.0.1). */
#include "http/internal/listener.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "access/tls.h"
#include "base/clock.h"
#include "base/log.h"
#include "http/internal/guard.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/watch.h"

enum {
    CONNECTIONS = 8192,
    SPARE_FILES = 128,     /* descriptors for the store and everything else */
    POOL_BYTES = 16 << 10, /* memory of a connection: its head, and a part of a body */
    THREADS = 2,
    BACKLOG_BURST =
        64, /* connections that are accepted before the acceptor checks its other tasks */
    REFRESH_MS = 1000, /* between checks of tokens and certificate */
    FULL_WAIT_MS = 50, /* pause when there are no descriptors */
    IDLE_S = 30,
    HEAD_S = 10,
    BODY_S = 10,
    BODY_BYTES = 40 << 10, /* fewest bytes of a body in BODY_S */
    SEND_S = 30,
    SEND_BYTES = 128 << 10 /* fewest bytes of an answer in SEND_S */
};

/* A host that has vanished closes no connection. Probes detect it within 20 s on a silent
 * connection. The kernel sends no probes while it has data to send; then the deadline of readers
 * applies. */
enum { PROBE_AFTER_S = 10, PROBE_EVERY_S = 5, PROBES = 2 };

/* The bytes of an answer that the kernel takes beyond those that it has sent. With megabytes, the
 * guard could not distinguish a slow reader from a client that reads nothing. */
enum { UNSENT_BYTES = 128 << 10 };

struct listener {
    struct pen_http *http;
    struct MHD_Daemon *daemon;
    int listen_fd;
    int stop_fd;                  /* an eventfd: readable when accepting must end */
    int connections, descriptors; /* the guard's limits */
    pthread_t acceptor;
    bool accepting; /* the acceptor thread runs and must be joined */
};

static void on_message(void *cls, const char *format, va_list args)
{
    (void)cls;
    char text[300];
    if (vsnprintf(text, sizeof text, format, args) < 0)
        return;
    text[strcspn(text, "\n")] = '\0';
    pen_log(PEN_LOG_DEBUG, "%s", text);
}

static void on_connection(void *cls, struct MHD_Connection *connection, void **context,
                          enum MHD_ConnectionNotificationCode code)
{
    (void)context;
    struct pen_http *http = cls;
    const int fd =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    if (code == MHD_CONNECTION_NOTIFY_STARTED)
        pen_guard_opened(http->guard, fd);
    else
        pen_guard_closing(http->guard, fd);
}

/* Keeps percent-encoding in targets, since target.c splits them before it decodes them. */
static size_t keep_escapes(void *cls, struct MHD_Connection *connection, char *text)
{
    (void)cls, (void)connection;
    return strlen(text);
}

static void on_gone(struct request *request)
{
    pen_http_watch_gone(request->http->watch, request);
}

/* Accepted sockets get the options of the listening one. */
static void set_options(int fd)
{
    static const struct {
        int level, name, value;
    } options[] = {{SOL_SOCKET, SO_KEEPALIVE, 1},
                   {IPPROTO_TCP, TCP_NODELAY, 1}, /* answers are written as a whole */
                   {IPPROTO_TCP, TCP_KEEPIDLE, PROBE_AFTER_S},
                   {IPPROTO_TCP, TCP_KEEPINTVL, PROBE_EVERY_S},
                   {IPPROTO_TCP, TCP_KEEPCNT, PROBES},
                   {IPPROTO_TCP, TCP_NOTSENT_LOWAT, UNSENT_BYTES}};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        setsockopt(fd, options[i].level, options[i].name, &options[i].value, sizeof(int));
}

/* Accepts one connection. Returns whether more may be waiting. */
static bool accept_one(struct listener *listener)
{
    struct sockaddr_storage peer;
    socklen_t bytes = sizeof peer;
    const int fd = accept4(listener->listen_fd, (struct sockaddr *)&peer, &bytes,
                           SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) {
        /* Out of descriptors or memory: the connection stays in the backlog. */
        if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM)
            poll(NULL, 0, FULL_WAIT_MS);
        return false;
    }
    const int open = pen_guard_count(listener->http->guard, NULL);
    if (fd >= listener->descriptors || open > listener->connections + listener->connections / 4)
        close(fd);
    else
        MHD_add_connection(listener->daemon, fd, (struct sockaddr *)&peer, bytes);
    return true;
}

/* Reads tokens and certificate again if they have changed. The acceptor thread does it, since it
 * never waits for the store. */
static void refresh(struct pen_http *http)
{
    if (http->tokens)
        pen_tokens_refresh(http->tokens);
    if (http->tls)
        pen_tls_refresh(http->tls);
}

static void *accept_all(void *arg)
{
    struct listener *listener = arg;
    struct pollfd fds[] = {{.fd = listener->stop_fd, .events = POLLIN},
                           {.fd = listener->listen_fd, .events = POLLIN}};
    int64_t refreshed_ns = 0;
    while (!fds[0].revents) {
        if (poll(fds, 2, REFRESH_MS) < 0 && errno != EINTR)
            poll(NULL, 0, FULL_WAIT_MS); /* the kernel is out of memory */
        for (int i = 0; i < BACKLOG_BURST && fds[1].revents && accept_one(listener); i++)
            continue;
        const int64_t now_ns = pen_clock_ns();
        if (now_ns - refreshed_ns >= REFRESH_MS * INT64_C(1000000)) {
            refreshed_ns = now_ns;
            refresh(listener->http);
        }
    }
    return NULL;
}

/* Sets the numbers of connections and descriptors that the process may have. */
static void set_limits(struct listener *listener, int wanted)
{
    struct rlimit files;
    wanted = wanted > 0 ? wanted : CONNECTIONS;
    const rlim_t needed = (rlim_t)wanted + (rlim_t)wanted / 4 + SPARE_FILES;
    const bool known = getrlimit(RLIMIT_NOFILE, &files) == 0;
    listener->descriptors = (int)(needed * 2);
    listener->connections = wanted;
    if (!known || files.rlim_cur >= needed)
        return;
    listener->descriptors = (int)files.rlim_cur;
    const int left =
        files.rlim_cur > 2 * SPARE_FILES ? (int)files.rlim_cur - SPARE_FILES : SPARE_FILES / 2;
    listener->connections = left / 5 * 4;
}

static bool start_guard(struct listener *listener, int idle_seconds, struct pen_status *st)
{
    const int idle = idle_seconds > 0 ? idle_seconds : IDLE_S;
    const struct guard_options options = {.connections = listener->connections,
                                          .descriptors = listener->descriptors,
                                          .idle_ms = idle * 1000,
                                          .head_ms = (idle < HEAD_S ? idle : HEAD_S) * 1000,
                                          .body_ms = (idle < BODY_S ? idle : BODY_S) * 1000,
                                          .send_ms = (idle < SEND_S ? idle : SEND_S) * 1000,
                                          .body_bytes = BODY_BYTES,
                                          .send_bytes = SEND_BYTES,
                                          .gone = on_gone};
    listener->http->guard = pen_guard_start(&options, st);
    return listener->http->guard != NULL;
}

/* Strictness level 1 of version 1.0 refuses malformed heads. In 0.9.75, level 1 drops a space in a
 * target without an answer, and sends the head of a refusal twice. There, level -1 with the checks
 * of admit.c is better. */
#if MHD_VERSION >= 0x00097701
#define STRICTNESS                                                                                 \
    {                                                                                              \
        MHD_OPTION_CLIENT_DISCIPLINE_LVL, 1, NULL                                                  \
    }
#else
#define STRICTNESS                                                                                 \
    {                                                                                              \
        MHD_OPTION_STRICT_FOR_CLIENT, -1, NULL                                                     \
    }
#endif

static bool start_daemon(struct listener *listener, struct pen_status *st)
{
    struct pen_http *http = listener->http;
    unsigned flags =
        MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC | MHD_USE_ERROR_LOG | MHD_USE_NO_LISTEN_SOCKET;
    struct MHD_OptionItem options[] = {
        STRICTNESS,
        {MHD_OPTION_THREAD_POOL_SIZE, THREADS, NULL},
        {MHD_OPTION_CONNECTION_LIMIT, THREADS * 2 * listener->descriptors, NULL},
        {MHD_OPTION_CONNECTION_TIMEOUT, 0, NULL}, /* the guard has the deadlines */
        {MHD_OPTION_CONNECTION_MEMORY_LIMIT, POOL_BYTES, NULL},
        {http->tls ? MHD_OPTION_HTTPS_PRIORITIES : MHD_OPTION_END, 0, (void *)pen_tls_priorities},
        {MHD_OPTION_END, 0, NULL}};
    if (http->tls)
        flags |= MHD_USE_POLL_INTERNAL_THREAD | MHD_USE_TLS;
    else
        flags |= MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_TURBO;
    listener->daemon = MHD_start_daemon(
        flags, 0, NULL, NULL, pen_http_adapter_on_access, http, MHD_OPTION_EXTERNAL_LOGGER,
        on_message, NULL, MHD_OPTION_URI_LOG_CALLBACK, pen_http_adapter_on_line, http,
        MHD_OPTION_UNESCAPE_CALLBACK, keep_escapes, NULL, MHD_OPTION_NOTIFY_COMPLETED,
        pen_http_adapter_on_completed, http, MHD_OPTION_NOTIFY_CONNECTION, on_connection, http,
        MHD_OPTION_ARRAY, options, http->tls ? MHD_OPTION_HTTPS_CERT_CALLBACK : MHD_OPTION_END,
        pen_tls_certificate, MHD_OPTION_END);
    return listener->daemon ||
           pen_fail(st, PEN_UNAVAILABLE, "libmicrohttpd %s does not start", MHD_get_version());
}

/* Prepares the socket. Another process may accept a connection that poll() announced, so accept
 * must not block. */
static bool prepare_socket(struct listener *listener, struct pen_status *st)
{
    const int flags = fcntl(listener->listen_fd, F_GETFL);
    set_options(listener->listen_fd);
    return (flags >= 0 && fcntl(listener->listen_fd, F_SETFL, flags | O_NONBLOCK) == 0 &&
            listener->stop_fd >= 0) ||
           pen_fail(st, PEN_UNAVAILABLE, "the listening socket cannot be used: %s",
                    strerror(errno));
}

struct listener *pen_http_listener_start(struct pen_http *http,
                                         const struct pen_http_options *options,
                                         struct pen_status *st)
{
    struct listener *listener = calloc(1, sizeof *listener);
    if (!listener) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
        return NULL;
    }
    *listener = (struct listener){.http = http,
                                  .listen_fd = options->listen_fd,
                                  .stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    set_limits(listener, options->connections);
    if (prepare_socket(listener, st) && start_guard(listener, options->idle_seconds, st) &&
        start_daemon(listener, st))
        return listener;
    pen_http_listener_stop(listener);
    return NULL;
}

bool pen_http_listener_accept(struct listener *listener, struct pen_status *st)
{
    listener->accepting = pthread_create(&listener->acceptor, NULL, accept_all, listener) == 0;
    return listener->accepting || pen_fail(st, PEN_UNAVAILABLE, "no thread to accept connections");
}

void pen_http_listener_stop_accepting(struct listener *listener)
{
    if (!listener->accepting)
        return;
    eventfd_write(listener->stop_fd, 1);
    pthread_join(listener->acceptor, NULL);
    listener->accepting = false;
}

void pen_http_listener_stop(struct listener *listener)
{
    if (!listener)
        return;
    pen_http_listener_stop_accepting(listener);
    if (listener->daemon)
        MHD_stop_daemon(listener->daemon);
    pen_guard_stop(listener->http->guard);
    listener->http->guard = NULL;
    if (listener->stop_fd >= 0)
        close(listener->stop_fd);
    free(listener);
}
