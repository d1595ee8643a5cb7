/* SPDX-License-Identifier: MIT */
/* The acceptor thread accepts connections and deals them out to the loops. It accepts always: the
 * loops close idle connections for new ones (loop.h), so that nobody waits outside. The listening
 * socket belongs to the supervisor and stays open. */
#include "http/internal/listener.h"

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "http/internal/addresses.h"
#include "http/internal/http.h"
#include "http/internal/loop.h"
#include "http/internal/pace.h"

enum {
    CONNECTIONS = 8192,
    SPARE_FILES = 128, /* descriptors for the store and everything else */
    LOOPS_MAX = 4,
    IDLE_S = 30,
    HEAD_S = 10,
    BODY_S = 10,
    ACCEPT_AGAIN_MS = 5,
    RUSH_LASTS_NS = 100000000 /* after connections came fast */
};

/* A host that has vanished closes nothing. Probes find that out on a silent connection within 20 s;
 * a loop asks for them when a connection has to wait. The kernel sends none while it has something
 * to send: then the times of the loop end the wait, or, of a stream, which may wait for long,
 * TCP_USER_TIMEOUT (conn_send.c). */
enum { PROBE_AFTER_S = 10, PROBE_EVERY_S = 5, PROBES = 2 };

/* What the kernel takes of an answer beyond what it has sent. With the megabytes that it would take
 * otherwise, a slow client would have to take a third of them until more can be sent, and the loop
 * could not tell it from one that takes nothing. */
enum { UNSENT_BYTES = 64 << 10 };

struct listener {
    struct pen_http *http;
    int listen_fd;
    int stop_fd; /* an eventfd: readable once accepting has to end */
    pthread_t acceptor;
    bool accepting; /* the acceptor thread runs and has to be joined */
    bool count_loopback, has_trusted;
    unsigned char trusted[16];
    int loop_count, next_loop;
    struct loop *loop[LOOPS_MAX];
};

/* Accepted sockets get the options of the listening one. */
static void set_options(int fd)
{
    static const struct {
        int level, name, value;
    } options[] = {{IPPROTO_TCP, TCP_NODELAY, 1}, /* answers are written whole */
                   {IPPROTO_TCP, TCP_KEEPIDLE, PROBE_AFTER_S},
                   {IPPROTO_TCP, TCP_KEEPINTVL, PROBE_EVERY_S},
                   {IPPROTO_TCP, TCP_KEEPCNT, PROBES},
                   {IPPROTO_TCP, TCP_NOTSENT_LOWAT, UNSENT_BYTES}};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++)
        setsockopt(fd, options[i].level, options[i].name, &options[i].value, sizeof(int));
}

/* Accepts one connection. Returns whether there may be more. */
static bool accept_one(struct listener *listener)
{
    struct sockaddr_storage peer;
    socklen_t bytes = sizeof peer;
    int fd = accept4(listener->listen_fd, (struct sockaddr *)&peer, &bytes,
                     SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) {
        /* Out of descriptors or memory, which the loops may give back: the connection stays in the
         * backlog. */
        if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
            pen_http_loop_wake(listener->loop[listener->next_loop]);
            poll(NULL, 0, ACCEPT_AGAIN_MS);
        }
        return false;
    }
    struct pen_address_key key = pen_http_address_key(
        (struct sockaddr *)&peer, listener->has_trusted ? listener->trusted : NULL,
        listener->count_loopback);
    pen_http_loop_add(listener->loop[listener->next_loop], fd, &key);
    return true;
}

/* Wakes the loop that got the last connections, and turns to the next one. */
static void wake_next_loop(struct listener *listener)
{
    pen_http_loop_wake(listener->loop[listener->next_loop]);
    listener->next_loop = (listener->next_loop + 1) % listener->loop_count;
}

/* The accepted connections that the loops have not looked at. */
static int arriving(const struct listener *listener)
{
    return atomic_load_explicit(&listener->http->arriving, memory_order_relaxed);
}

/* Accepts what waits, a burst at most, and deals it out: one after the other, or, to wake one
 * thread once, all to the same loop. Returns the number of connections. */
static int accept_burst(struct listener *listener, bool together)
{
    int count = 0;
    while (count < PACE_BURST && arriving(listener) < PACE_ARRIVING && accept_one(listener)) {
        count++;
        if (!together)
            wake_next_loop(listener);
    }
    if (together && count > 0)
        wake_next_loop(listener);
    return count;
}

static void note_rush(struct pen_http *http, int64_t now_ns)
{
    if (atomic_load_explicit(&http->rush_until_ns, memory_order_relaxed) < now_ns)
        atomic_store_explicit(&http->rush_since_ns, now_ns, memory_order_relaxed);
    atomic_store_explicit(&http->rush_until_ns, now_ns + RUSH_LASTS_NS, memory_order_relaxed);
}

/* Waits for so long, or, with 0, for new connections. Returns false once accepting has to end. */
static bool wait_for_more(const struct listener *listener, int64_t wait_ns)
{
    const struct timespec wait = {.tv_nsec = wait_ns};
    struct pollfd fds[] = {{.fd = listener->stop_fd, .events = POLLIN},
                           {.fd = listener->listen_fd, .events = POLLIN}};
    const int n = ppoll(fds, wait_ns > 0 ? 1 : 2, wait_ns > 0 ? &wait : NULL, NULL);
    if (n < 0 && errno != EINTR)
        poll(NULL, 0, ACCEPT_AGAIN_MS); /* the kernel is out of memory */
    return n <= 0 || !fds[0].revents;
}

static void *accept_all(void *arg)
{
    struct listener *listener = arg;
    struct pace pace = {0};
    for (;;) {
        const int64_t now_ns = pen_clock_ns();
        const int64_t wait_ns = pen_http_pace_wait(&pace, now_ns, arriving(listener));
        if (pace.rush)
            note_rush(listener->http, now_ns);
        if (!wait_for_more(listener, wait_ns))
            break;
        pen_http_pace_count(&pace, accept_burst(listener, pace.pause_ns > 0));
    }
    return NULL;
}

/* The number of connections that the process has descriptors for. */
static int connection_max(int wanted)
{
    const int others = SPARE_FILES + PACE_ARRIVING + RESERVED_SLOTS;
    struct rlimit files;
    wanted = wanted > 0 ? wanted : CONNECTIONS;
    if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= (rlim_t)(wanted + others))
        return wanted;
    return files.rlim_cur > (rlim_t)(2 * others) ? (int)files.rlim_cur - others : others / 4;
}

static bool start_loops(struct listener *listener, int idle_seconds, struct pen_status *st)
{
    const int64_t second_ns = INT64_C(1000000000);
    int idle = idle_seconds > 0 ? idle_seconds : IDLE_S;
    const struct loop_times times = {.idle_ns = idle * second_ns,
                                     .head_ns = (idle < HEAD_S ? idle : HEAD_S) * second_ns,
                                     .body_ns = (idle < BODY_S ? idle : BODY_S) * second_ns};
    int cpus = pen_cpu_count();
    int count = cpus < 2 ? 2 : cpus > LOOPS_MAX ? LOOPS_MAX : cpus;
    while (listener->loop_count < count) {
        struct loop *loop = pen_http_loop_start(listener->http, &times, st);
        if (!loop)
            return false;
        listener->loop[listener->loop_count++] = loop;
    }
    for (int i = 0; i < count; i++)
        listener->loop[i]->next = listener->loop[(i + 1) % count];
    return true;
}

/* Another process may accept the connection that poll() announced: accept must not block. */
static bool make_nonblocking(int fd)
{
    int flags = fcntl(fd, F_GETFL);
    return flags >= 0 && fcntl(fd, F_SETFL, flags | O_NONBLOCK) == 0;
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
                                  .stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK),
                                  .count_loopback = options->count_loopback};
    listener->has_trusted =
        options->trusted_proxy && pen_http_address_parse(options->trusted_proxy, listener->trusted);
    http->connection_max = connection_max(options->connections);
    set_options(options->listen_fd);
    bool ok = (make_nonblocking(options->listen_fd) && listener->stop_fd >= 0) ||
              pen_fail(st, PEN_UNAVAILABLE, "the HTTP server does not start");
    if (ok && start_loops(listener, options->idle_seconds, st))
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

void pen_http_listener_counts(struct listener *listener, int counts[WAITS])
{
    for (enum conn_wait wait = 0; wait < WAITS; wait++) {
        counts[wait] = 0;
        for (int i = 0; i < 2 * listener->loop_count; i++)
            counts[wait] += atomic_load_explicit(&listener->loop[i / 2]->list[i % 2][wait].count,
                                                 memory_order_relaxed);
    }
}

void pen_http_listener_stop(struct listener *listener)
{
    if (!listener)
        return;
    pen_http_listener_stop_accepting(listener);
    pen_http_loops_stop(listener->loop, listener->loop_count);
    if (listener->stop_fd >= 0)
        close(listener->stop_fd);
    free(listener);
}
