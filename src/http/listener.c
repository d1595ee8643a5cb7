/* SPDX-License-Identifier: MIT */
/* Threads and sockets. libmicrohttpd gets its connections from an acceptor of our own: ending its
 * own accepting is a race between MHD_quiesce_daemon and its threads, which can end the process,
 * and MHD_stop_daemon shuts the listening socket down, which belongs to the supervisor.
 *
 * Its limits are set so that it never has to refuse a connection itself: in 0.9.75 a pool thread
 * that refuses one which another thread added keeps its lock for ever. The acceptor counts. */
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/cpu.h"
#include "base/log.h"
#include "http/internal/adapter_internal.h"

enum {
    CONNECTIONS = 1024,
    SPARE_FILES = 128, /* descriptors for the store and everything else */
    CONNECTION_BYTES = 64 << 10,
    THREADS_MAX = 4,
    LOST_MS = 30000,
    BUSY_MS = 20 /* until the next look when there is no room for a connection */
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
    struct adapter *adapter = cls;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED)
        atomic_fetch_sub_explicit(&adapter->connections, 1, memory_order_relaxed);
}

/* Leaves targets as they came: they are taken apart before they are decoded. */
static size_t keep_escapes(void *cls, struct MHD_Connection *connection, char *text)
{
    (void)cls, (void)connection;
    return strlen(text);
}

static void accept_one(struct adapter *adapter)
{
    struct sockaddr_storage peer;
    socklen_t bytes = sizeof peer;
    int fd =
        accept4(adapter->listen_fd, (struct sockaddr *)&peer, &bytes, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) {
        /* Out of descriptors or memory: the connection stays in the backlog. */
        if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM)
            poll(NULL, 0, BUSY_MS);
        return;
    }
    /* A host that vanished does not hang up: what it does not acknowledge ends the connection. */
    setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &(unsigned){LOST_MS}, sizeof(unsigned));
    atomic_fetch_add_explicit(&adapter->connections, 1, memory_order_relaxed);
    if (MHD_add_connection(adapter->daemon, fd, (struct sockaddr *)&peer, bytes) != MHD_YES)
        atomic_fetch_sub_explicit(&adapter->connections, 1, memory_order_relaxed);
}

static void *accept_all(void *arg)
{
    struct adapter *adapter = arg;
    for (;;) {
        bool room = atomic_load_explicit(&adapter->connections, memory_order_relaxed) <
                    adapter->connection_max;
        struct pollfd fds[] = {{.fd = adapter->stop_fd, .events = POLLIN},
                               {.fd = adapter->listen_fd, .events = POLLIN}};
        int n = poll(fds, room ? 2 : 1, room ? -1 : BUSY_MS);
        if (n < 0 && errno != EINTR)
            poll(NULL, 0, BUSY_MS); /* out of memory */
        if (n > 0 && fds[0].revents)
            break;
        if (n > 0 && fds[1].revents)
            accept_one(adapter);
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

static struct MHD_Daemon *start_daemon(struct adapter *adapter, int idle_seconds)
{
    int cpus = pen_cpu_count();
    unsigned threads = cpus < 2 ? 2 : cpus > THREADS_MAX ? THREADS_MAX : (unsigned)cpus;
    unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ITC |
                     MHD_USE_ERROR_LOG | MHD_USE_NO_LISTEN_SOCKET;
    /* Each thread may have every connection: twice over, for those on their way to be closed. */
    unsigned limit = threads * 2 * CONNECTIONS;
    return MHD_start_daemon(
        flags, 0, NULL, NULL, pen_http_adapter_on_access, adapter->http, MHD_OPTION_EXTERNAL_LOGGER,
        on_message, NULL, MHD_OPTION_THREAD_POOL_SIZE, threads, MHD_OPTION_CONNECTION_LIMIT, limit,
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)idle_seconds, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
        (size_t)CONNECTION_BYTES, MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_URI_LOG_CALLBACK,
        pen_http_adapter_on_line, adapter->http, MHD_OPTION_UNESCAPE_CALLBACK, keep_escapes, NULL,
        MHD_OPTION_NOTIFY_COMPLETED, pen_http_adapter_on_completed, adapter->http,
        MHD_OPTION_NOTIFY_CONNECTION, on_connection, adapter, MHD_OPTION_END);
}

struct adapter *pen_http_adapter_start(struct pen_http *http, int listen_fd, int idle_seconds,
                                       struct pen_status *st)
{
    struct adapter *adapter = calloc(1, sizeof *adapter);
    if (!adapter) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
        return NULL;
    }
    *adapter = (struct adapter){.http = http,
                                .listen_fd = listen_fd,
                                .stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK),
                                .connection_max = connection_max()};
    pthread_mutex_init(&adapter->parking, NULL);
    /* Another process may take the connection that poll() promised: accept must not block. */
    int flags = fcntl(listen_fd, F_GETFL);
    if (flags >= 0 && fcntl(listen_fd, F_SETFL, flags | O_NONBLOCK) == 0 && adapter->stop_fd >= 0)
        adapter->daemon = start_daemon(adapter, idle_seconds);
    if (adapter->daemon)
        return adapter;
    pen_http_adapter_stop(adapter);
    pen_fail(st, PEN_UNAVAILABLE, "the HTTP server does not start");
    return NULL;
}

bool pen_http_adapter_accept(struct adapter *adapter, struct pen_status *st)
{
    adapter->accepting = pthread_create(&adapter->acceptor, NULL, accept_all, adapter) == 0;
    return adapter->accepting || pen_fail(st, PEN_UNAVAILABLE, "no thread to accept connections");
}

void pen_http_adapter_stop_accepting(struct adapter *adapter)
{
    if (!adapter->accepting)
        return;
    eventfd_write(adapter->stop_fd, 1);
    pthread_join(adapter->acceptor, NULL);
    adapter->accepting = false;
}

void pen_http_adapter_stop(struct adapter *adapter)
{
    if (!adapter)
        return;
    pen_http_adapter_stop_accepting(adapter);
    if (adapter->daemon)
        MHD_stop_daemon(adapter->daemon);
    if (adapter->stop_fd >= 0)
        close(adapter->stop_fd);
    pthread_mutex_destroy(&adapter->parking);
    free(adapter);
}
