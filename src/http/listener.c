/* SPDX-License-Identifier: MIT */
/* Threads and sockets. The acceptor thread accepts connections and gives them to libmicrohttpd,
 * which does not accept any itself, for two reasons:
 *   - To end libmicrohttpd's own accepting is a race between MHD_quiesce_daemon and its threads,
 *     which can end the process.
 *   - MHD_stop_daemon shuts the listening socket down, but the socket belongs to the supervisor.
 *
 * libmicrohttpd's limits are set so high that it never refuses a connection itself: in version
 * 0.9.75 a thread that refuses a connection which another thread added never releases its lock.
 * The acceptor counts connections instead. */
#include "http/internal/listener.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/cpu.h"
#include "base/log.h"
#include "http/internal/adapter.h"

enum {
    CONNECTIONS = 1024,
    SPARE_FILES = 128, /* descriptors for the store and everything else */
    CONNECTION_BYTES = 64 << 10,
    THREADS_MAX = 4,
    ACK_TIMEOUT_MS = 30000,
    FULL_WAIT_MS = 20 /* before checking again whether a connection may be accepted */
};

struct listener {
    struct pen_http *http;
    struct MHD_Daemon *daemon;
    int listen_fd;
    int stop_fd; /* an eventfd: readable once accepting has to end */
    pthread_t acceptor;
    bool accepting; /* the acceptor thread runs and has to be joined */
    int connection_max;
    atomic_int connections; /* accepted and not yet closed. atomic: relaxed, a bound */
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
    (void)connection, (void)context;
    struct listener *listener = cls;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED)
        atomic_fetch_sub_explicit(&listener->connections, 1, memory_order_relaxed);
}

/* Leaves percent-encoding in targets: target.c splits them before it decodes them. */
static size_t keep_escapes(void *cls, struct MHD_Connection *connection, char *text)
{
    (void)cls, (void)connection;
    return strlen(text);
}

static void accept_one(struct listener *listener)
{
    struct sockaddr_storage peer;
    socklen_t bytes = sizeof peer;
    int fd = accept4(listener->listen_fd, (struct sockaddr *)&peer, &bytes,
                     SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) {
        /* Out of descriptors or memory: the connection stays in the backlog. */
        if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM)
            poll(NULL, 0, FULL_WAIT_MS);
        return;
    }
    /* A host that has vanished closes nothing: data it does not acknowledge in time ends the
     * connection. */
    setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &(unsigned){ACK_TIMEOUT_MS}, sizeof(unsigned));
    atomic_fetch_add_explicit(&listener->connections, 1, memory_order_relaxed);
    if (MHD_add_connection(listener->daemon, fd, (struct sockaddr *)&peer, bytes) != MHD_YES)
        atomic_fetch_sub_explicit(&listener->connections, 1, memory_order_relaxed);
}

static void *accept_all(void *arg)
{
    struct listener *listener = arg;
    for (;;) {
        bool below_limit = atomic_load_explicit(&listener->connections, memory_order_relaxed) <
                           listener->connection_max;
        struct pollfd fds[] = {{.fd = listener->stop_fd, .events = POLLIN},
                               {.fd = listener->listen_fd, .events = POLLIN}};
        int n = poll(fds, below_limit ? 2 : 1, below_limit ? -1 : FULL_WAIT_MS);
        if (n < 0 && errno != EINTR)
            poll(NULL, 0, FULL_WAIT_MS); /* the kernel is out of memory */
        if (n > 0 && fds[0].revents)
            break;
        if (n > 0 && fds[1].revents)
            accept_one(listener);
    }
    return NULL;
}

static int connection_max(void)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= CONNECTIONS + SPARE_FILES)
        return CONNECTIONS;
    return files.rlim_cur > 2 * SPARE_FILES ? (int)files.rlim_cur - SPARE_FILES : SPARE_FILES;
}

static struct MHD_Daemon *start_daemon(struct listener *listener, int idle_seconds)
{
    int cpus = pen_cpu_count();
    unsigned threads = cpus < 2 ? 2 : cpus > THREADS_MAX ? THREADS_MAX : (unsigned)cpus;
    unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC |
                     MHD_USE_ERROR_LOG | MHD_USE_NO_LISTEN_SOCKET;
    /* One thread may get all connections, and those that are being closed still count: twice as
     * many. */
    unsigned limit = threads * 2 * CONNECTIONS;
    return MHD_start_daemon(
        flags, 0, NULL, NULL, pen_http_adapter_on_access, listener->http,
        MHD_OPTION_EXTERNAL_LOGGER, on_message, NULL, MHD_OPTION_THREAD_POOL_SIZE, threads,
        MHD_OPTION_CONNECTION_LIMIT, limit, MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)idle_seconds,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)CONNECTION_BYTES, MHD_OPTION_STRICT_FOR_CLIENT,
        1, MHD_OPTION_URI_LOG_CALLBACK, pen_http_adapter_on_line, listener->http,
        MHD_OPTION_UNESCAPE_CALLBACK, keep_escapes, NULL, MHD_OPTION_NOTIFY_COMPLETED,
        pen_http_adapter_on_completed, listener->http, MHD_OPTION_NOTIFY_CONNECTION, on_connection,
        listener, MHD_OPTION_END);
}

struct listener *pen_http_listener_start(struct pen_http *http, int listen_fd, int idle_seconds,
                                         struct pen_status *st)
{
    struct listener *listener = calloc(1, sizeof *listener);
    if (!listener) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
        return NULL;
    }
    *listener = (struct listener){.http = http,
                                  .listen_fd = listen_fd,
                                  .stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK),
                                  .connection_max = connection_max()};
    /* Another process may accept the connection that poll() announced: accept must not block. */
    int flags = fcntl(listen_fd, F_GETFL);
    if (flags >= 0 && fcntl(listen_fd, F_SETFL, flags | O_NONBLOCK) == 0 && listener->stop_fd >= 0)
        listener->daemon = start_daemon(listener, idle_seconds);
    if (listener->daemon)
        return listener;
    pen_http_listener_stop(listener);
    pen_fail(st, PEN_UNAVAILABLE, "the HTTP server does not start");
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
    if (listener->stop_fd >= 0)
        close(listener->stop_fd);
    free(listener);
}
