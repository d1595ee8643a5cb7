/* SPDX-License-Identifier: MIT */
#include "http/internal/guard.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    TICK_MS = 250,
    LINGER_MS = 60000,      /* longest time for which a closed connection is read */
    LINGER_QUIET_MS = 2000, /* longest time without a byte */
    LINGER_MOST = 512,      /* lingering connections at once: at most this number, */
    LINGER_PART = 16,       /* and at most one in this number of descriptors */
    EVICT_IDLE_MS = 100,    /* a connection that waited for less is not closed for others */
    EVICT_BUSY_MS = 1000,   /* the same for a connection within a head or a body */
    /* One in this number of connections is closed in addition, so that not every new connection is
     * one too many. */
    EVICT_PART = 128,
    SEND_GRACE_MS = 2000 /* answers that take less time are not checked */
};

struct peer {
    _Atomic int state; /* atomic: release, with since_ms */
    /* Start of its state, or of a window of the state. atomic: relaxed, a time that is late by a
     * tick does no harm */
    _Atomic int64_t since_ms;
    _Atomic uint64_t received; /* bytes of bodies. atomic: relaxed, a sum */
    atomic_bool served;        /* it has got an answer. atomic: relaxed, it chooses a deadline */
    /* The following members are guarded by the lock. */
    /* `received`, or the acknowledged bytes, at the start of the window. */
    uint64_t window_from;
    int window_state; /* the state of the window */
    bool doomed;      /* shut down, and not yet closed by libmicrohttpd */
    struct request *watched;
    int64_t linger_ms, quiet_ms; /* deadlines of a lingering descriptor; 0: it does not linger */
};

struct guard {
    struct guard_options options;
    pthread_t thread;
    int set, wake;        /* an epoll set; an eventfd in it */
    atomic_bool stopping; /* atomic: relaxed, read in a loop that wake ends */
    atomic_int open;      /* number of connections. atomic: relaxed, for information */
    pthread_mutex_t lock;
    int top;                /* guarded by lock: the highest descriptor so far */
    int lingering;          /* guarded by lock */
    int *sorted;            /* the thread's: space for all descriptors */
    char dropped[64 << 10]; /* the thread's: what lingering connections send */
    struct peer peer[];
};

static int64_t now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC_COARSE, &t);
    return t.tv_sec * INT64_C(1000) + t.tv_nsec / 1000000;
}

void pen_guard_state(struct guard *guard, int fd, enum peer_state state)
{
    struct peer *peer = &guard->peer[fd];
    atomic_store_explicit(&peer->since_ms, now_ms(), memory_order_relaxed);
    if (state == PEER_IDLE)
        atomic_store_explicit(&peer->served, true, memory_order_relaxed);
    atomic_store_explicit(&peer->state, (int)state, memory_order_release);
}

void pen_guard_received(struct guard *guard, int fd, size_t bytes)
{
    atomic_fetch_add_explicit(&guard->peer[fd].received, bytes, memory_order_relaxed);
}

static void clear(struct peer *peer, enum peer_state state)
{
    peer->window_from = 0;
    peer->window_state = PEER_FREE;
    peer->doomed = false;
    peer->watched = NULL;
    peer->linger_ms = peer->quiet_ms = 0;
    atomic_store_explicit(&peer->received, 0, memory_order_relaxed);
    atomic_store_explicit(&peer->served, false, memory_order_relaxed);
    atomic_store_explicit(&peer->since_ms, now_ms(), memory_order_relaxed);
    atomic_store_explicit(&peer->state, (int)state, memory_order_release);
}

void pen_guard_opened(struct guard *guard, int fd)
{
    pthread_mutex_lock(&guard->lock);
    clear(&guard->peer[fd], PEER_IDLE);
    guard->top = fd > guard->top ? fd : guard->top;
    const int open = atomic_fetch_add_explicit(&guard->open, 1, memory_order_relaxed) + 1;
    pthread_mutex_unlock(&guard->lock);
    if (open > guard->options.connections && open % 16 == 0)
        eventfd_write(guard->wake, 1);
}

/* Makes a close linger. Closing a socket with unread bytes would reset the connection, and the
 * client could lose its answer. So a second descriptor keeps the socket. Its sending side is shut
 * down, and the guard reads and drops what the client still sends. Called with the lock held. */
static void linger(struct guard *guard, int fd)
{
    int unread = 0;
    if (atomic_load(&guard->peer[fd].state) != PEER_BODY &&
        (ioctl(fd, FIONREAD, &unread) != 0 || unread == 0))
        return;
    const int two = guard->lingering < LINGER_MOST &&
                            guard->lingering < guard->options.descriptors / LINGER_PART
                        ? fcntl(fd, F_DUPFD_CLOEXEC, 0)
                        : -1;
    struct epoll_event event = {.events = EPOLLIN | EPOLLRDHUP, .data.fd = two};
    if (two < 0)
        return;
    shutdown(fd, SHUT_WR);
    if (two >= guard->options.descriptors ||
        epoll_ctl(guard->set, EPOLL_CTL_ADD, two, &event) != 0) {
        close(two);
        return;
    }
    clear(&guard->peer[two], PEER_FREE);
    guard->peer[two].linger_ms = now_ms() + LINGER_MS;
    guard->peer[two].quiet_ms = now_ms() + LINGER_QUIET_MS;
    guard->top = two > guard->top ? two : guard->top;
    guard->lingering++;
}

/* Called with the lock held. */
static void end_linger(struct guard *guard, int fd)
{
    guard->peer[fd].linger_ms = 0;
    guard->lingering--;
    close(fd); /* also removes it from the set, as the last descriptor of the socket */
}

void pen_guard_closing(struct guard *guard, int fd)
{
    pthread_mutex_lock(&guard->lock);
    if (!guard->peer[fd].doomed)
        linger(guard, fd);
    clear(&guard->peer[fd], PEER_FREE);
    atomic_fetch_sub_explicit(&guard->open, 1, memory_order_relaxed);
    pthread_mutex_unlock(&guard->lock);
}

void pen_guard_watch(struct guard *guard, int fd, struct request *request)
{
    struct epoll_event event = {.events = EPOLLRDHUP | EPOLLONESHOT, .data.fd = fd};
    pthread_mutex_lock(&guard->lock);
    guard->peer[fd].watched = request;
    epoll_ctl(guard->set, EPOLL_CTL_ADD, fd, &event); /* if it fails, the deadline ends the wait */
    pthread_mutex_unlock(&guard->lock);
}

bool pen_guard_unwatch(struct guard *guard, int fd)
{
    pthread_mutex_lock(&guard->lock);
    const bool mine = guard->peer[fd].watched != NULL;
    if (mine)
        epoll_ctl(guard->set, EPOLL_CTL_DEL, fd, NULL);
    guard->peer[fd].watched = NULL;
    pthread_mutex_unlock(&guard->lock);
    return mine;
}

int pen_guard_count(struct guard *guard, int counts[PEER_STATES])
{
    if (counts) {
        for (int i = 0; i < PEER_STATES; i++)
            counts[i] = 0;
        pthread_mutex_lock(&guard->lock);
        for (int fd = 0; fd <= guard->top; fd++)
            counts[atomic_load(&guard->peer[fd].state)]++;
        pthread_mutex_unlock(&guard->lock);
    }
    return atomic_load_explicit(&guard->open, memory_order_relaxed);
}

/* Shuts a connection down; libmicrohttpd notices and closes it. Called with the lock held. */
static void doom(struct guard *guard, int fd)
{
    const struct linger at_once = {.l_onoff = 1};
    guard->peer[fd].doomed = true;
    if (atomic_load(&guard->peer[fd].state) ==
        PEER_SEND) /* drop the bytes that the client does not read */
        setsockopt(fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    shutdown(fd, SHUT_RDWR);
}

static uint64_t acknowledged(int fd)
{
    struct tcp_info info;
    socklen_t bytes = sizeof info;
    return getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &bytes) == 0 ? info.tcpi_bytes_acked : 0;
}

/* Closes a connection whose body or reader was too slow in its window. Otherwise begins the next
 * window. */
static void check_window(struct guard *guard, int fd, int state, int64_t now, int ms,
                         unsigned least)
{
    struct peer *peer = &guard->peer[fd];
    const uint64_t bytes = state == PEER_BODY ? atomic_load(&peer->received) : acknowledged(fd);
    const bool begun = peer->window_state == state;
    if (begun && bytes - peer->window_from < least) {
        if (now - atomic_load(&peer->since_ms) > ms)
            doom(guard, fd);
        return;
    }
    if (begun)
        atomic_store(&peer->since_ms, now);
    peer->window_state = state;
    peer->window_from = bytes;
}

/* Called with the lock held. */
static void check_deadline(struct guard *guard, int fd, int64_t now)
{
    const struct guard_options *options = &guard->options;
    struct peer *peer = &guard->peer[fd];
    const int state = atomic_load_explicit(&peer->state, memory_order_acquire);
    const int64_t age = now - atomic_load_explicit(&peer->since_ms, memory_order_relaxed);
    if (peer->doomed)
        return;
    if (state == PEER_IDLE &&
        age > (atomic_load(&peer->served) ? options->idle_ms : options->head_ms))
        doom(guard, fd);
    if (state == PEER_HEAD && age > options->head_ms)
        doom(guard, fd);
    if (state == PEER_BODY)
        check_window(guard, fd, state, now, options->body_ms, options->body_bytes);
    if (state == PEER_SEND && age > SEND_GRACE_MS)
        check_window(guard, fd, state, now, options->send_ms, options->send_bytes);
}

static int by_age(const void *a, const void *b, void *user)
{
    const struct guard *guard = user;
    const int64_t x = atomic_load(&guard->peer[*(const int *)a].since_ms),
                  y = atomic_load(&guard->peer[*(const int *)b].since_ms);
    return (x > y) - (x < y);
}

/* Closes the connections that are idle longest, then the oldest heads and bodies. Called with the
 * lock held. */
static void evict(struct guard *guard, int64_t now, int many)
{
    for (int state = PEER_IDLE; state <= PEER_BODY && many > 0; state++) {
        const int least = state == PEER_IDLE ? EVICT_IDLE_MS : EVICT_BUSY_MS;
        int n = 0;
        for (int fd = 0; fd <= guard->top; fd++) {
            const struct peer *peer = &guard->peer[fd];
            if (atomic_load(&peer->state) == state && !peer->doomed &&
                now - atomic_load(&peer->since_ms) > least)
                guard->sorted[n++] = fd;
        }
        qsort_r(guard->sorted, (size_t)n, sizeof guard->sorted[0], by_age, guard);
        for (int i = 0; i < n && many > 0; i++, many--)
            doom(guard, guard->sorted[i]);
    }
}

static void look_at_all(struct guard *guard)
{
    const int64_t now = now_ms();
    int left = 0;
    pthread_mutex_lock(&guard->lock);
    for (int fd = 0; fd <= guard->top; fd++) {
        struct peer *peer = &guard->peer[fd];
        if (peer->linger_ms && (now > peer->linger_ms || now > peer->quiet_ms))
            end_linger(guard, fd);
        if (atomic_load(&peer->state) == PEER_FREE)
            continue;
        check_deadline(guard, fd, now);
        left += !peer->doomed;
    }
    if (left > guard->options.connections)
        evict(guard, now,
              left - guard->options.connections + guard->options.connections / EVICT_PART);
    pthread_mutex_unlock(&guard->lock);
}

static void on_event(struct guard *guard, int fd, uint32_t events)
{
    struct peer *peer = &guard->peer[fd];
    pthread_mutex_lock(&guard->lock);
    struct request *request = peer->watched;
    if (peer->linger_ms) {
        const ssize_t n = recv(fd, guard->dropped, sizeof guard->dropped, MSG_DONTWAIT | MSG_TRUNC);
        if (n == 0 || (n < 0 && errno != EAGAIN) || (events & (EPOLLERR | EPOLLHUP)))
            end_linger(guard, fd);
        else
            peer->quiet_ms = now_ms() + LINGER_QUIET_MS;
    } else if (request) {
        peer->watched = NULL;
        epoll_ctl(guard->set, EPOLL_CTL_DEL, fd, NULL);
    }
    pthread_mutex_unlock(&guard->lock);
    if (request)
        guard->options.gone(request);
}

static void *run(void *arg)
{
    struct guard *guard = arg;
    int64_t next = 0;
    while (!atomic_load_explicit(&guard->stopping, memory_order_relaxed)) {
        struct epoll_event event[64];
        const int n = epoll_wait(guard->set, event, 64, TICK_MS);
        bool soon = false;
        for (int i = 0; i < n; i++) {
            eventfd_t value;
            if (event[i].data.fd == guard->wake)
                soon = eventfd_read(guard->wake, &value) == 0;
            else
                on_event(guard, event[i].data.fd, event[i].events);
        }
        if (soon || now_ms() >= next) {
            look_at_all(guard);
            next = now_ms() + TICK_MS;
        }
    }
    return NULL;
}

static void release(struct guard *guard)
{
    for (int fd = 0; fd <= guard->top; fd++) {
        if (guard->peer[fd].linger_ms)
            close(fd);
    }
    if (guard->set >= 0)
        close(guard->set);
    if (guard->wake >= 0)
        close(guard->wake);
    pthread_mutex_destroy(&guard->lock);
    free(guard->sorted);
    free(guard);
}

struct guard *pen_guard_start(const struct guard_options *options, struct pen_status *st)
{
    const size_t slots = (size_t)options->descriptors;
    struct guard *guard = calloc(1, sizeof *guard + slots * sizeof guard->peer[0]);
    if (!guard) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for %zu connections", slots);
        return NULL;
    }
    guard->options = *options;
    guard->set = epoll_create1(EPOLL_CLOEXEC);
    guard->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    guard->sorted = calloc(slots, sizeof *guard->sorted);
    pthread_mutex_init(&guard->lock, NULL);
    struct epoll_event event = {.events = EPOLLIN, .data.fd = guard->wake};
    if (guard->sorted && guard->set >= 0 && guard->wake >= 0 &&
        epoll_ctl(guard->set, EPOLL_CTL_ADD, guard->wake, &event) == 0 &&
        pthread_create(&guard->thread, NULL, run, guard) == 0)
        return guard;
    release(guard);
    pen_fail(st, PEN_UNAVAILABLE, "the guard of the connections does not start");
    return NULL;
}

void pen_guard_stop(struct guard *guard)
{
    if (!guard)
        return;
    atomic_store_explicit(&guard->stopping, true, memory_order_relaxed);
    eventfd_write(guard->wake, 1);
    pthread_join(guard->thread, NULL);
    release(guard);
}
