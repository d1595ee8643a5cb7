/* SPDX-License-Identifier: MIT */
/* A loop's turn: events of the kernel; new connections and resumed requests, which come through one
 * lock; connections that have more to do; deadlines. */
#include "http/internal/loop.h"

#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/trim.h"

enum { EVENTS = 128, LINGER_S = 2 };
static const int64_t second_ns = INT64_C(1000000000);
/* Whose head, or window of a body, began less than this ago has had no time to send it. */
static const int64_t fresh_ns = INT64_C(1000000000);
/* A reader that has not taken its window for so long gives way to a new connection. */
static const int64_t stalled_ns = 2 * INT64_C(1000000000);

static struct conn_list *list_of(const struct conn *conn)
{
    return &conn->loop->list[conn->reserved][conn->wait];
}

static void append(struct conn *conn, enum conn_wait wait)
{
    conn->wait = wait;
    struct conn_list *list = list_of(conn);
    conn->since_ns = conn->loop->now_ns;
    conn->next = NULL;
    conn->previous = list->last;
    *(list->last ? &list->last->next : &list->first) = conn;
    list->last = conn;
    atomic_fetch_add_explicit(&list->count, 1, memory_order_relaxed);
}

static void take_out(struct conn *conn)
{
    struct conn_list *list = list_of(conn);
    *(conn->previous ? &conn->previous->next : &list->first) = conn->next;
    *(conn->next ? &conn->next->previous : &list->last) = conn->previous;
    atomic_fetch_sub_explicit(&list->count, 1, memory_order_relaxed);
}

void pen_http_loop_wait(struct conn *conn, enum conn_wait wait)
{
    take_out(conn);
    append(conn, wait);
}

bool pen_http_loop_rush(const struct loop *loop)
{
    return atomic_load_explicit(&loop->http->rush_until_ns, memory_order_relaxed) > loop->now_ns;
}

bool pen_http_loop_closes_refused(const struct loop *loop)
{
    const int64_t since_ns = atomic_load_explicit(&loop->http->rush_since_ns, memory_order_relaxed);
    return pen_http_loop_rush(loop) && (loop->now_ns - since_ns) % second_ns >= second_ns / 10;
}

bool pen_http_loop_watch(struct conn *conn)
{
    const int on = 1;
    struct epoll_event event = {.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET,
                                .data.ptr = conn};
    if (conn->watched || conn->fd < 0)
        return true;
    setsockopt(conn->fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    conn->watched = epoll_ctl(conn->loop->epoll_fd, EPOLL_CTL_ADD, conn->fd, &event) == 0;
    return conn->watched;
}

void pen_http_loop_again(struct conn *conn)
{
    if (conn->ready)
        return;
    conn->ready = true;
    conn->next_ready = conn->loop->ready;
    conn->loop->ready = conn;
}

void pen_http_loop_remove(struct conn *conn)
{
    struct loop *loop = conn->loop;
    take_out(conn);
    conn->next = loop->dead;
    loop->dead = conn;
    struct pen_http *http = loop->http;
    if (conn->reserved)
        atomic_fetch_sub_explicit(&http->reserved, 1, memory_order_relaxed);
    atomic_fetch_sub_explicit(&http->connections, 1, memory_order_relaxed);
    pen_http_trim_note(http->trim);
}

void pen_http_loop_wake(struct loop *loop)
{
    if (!atomic_exchange_explicit(&loop->woken, true, memory_order_relaxed))
        eventfd_write(loop->wake_fd, 1);
}

void pen_http_resume(struct request *request)
{
    struct conn *conn = request->conn;
    struct loop *loop = conn->loop;
    pthread_mutex_lock(&loop->lock);
    request->resumed = true;
    if (!conn->resumed) {
        conn->resumed = true;
        conn->next_resumed = loop->resumed;
        loop->resumed = conn;
    }
    pthread_mutex_unlock(&loop->lock);
    pen_http_loop_wake(loop);
}

/* Gives a new connection to a loop that is to be woken then. Returns false if the loop is being
 * stopped. */
static bool give(struct loop *loop, struct conn *conn)
{
    pthread_mutex_lock(&loop->lock);
    const bool taken = !loop->stop;
    if (taken) {
        atomic_fetch_add_explicit(&loop->http->arriving, 1, memory_order_relaxed);
        conn->loop = loop;
        conn->next = loop->accepted;
        loop->accepted = conn;
    }
    pthread_mutex_unlock(&loop->lock);
    return taken;
}

void pen_http_loop_add(struct loop *loop, int fd, const struct pen_address_key *address)
{
    struct conn *conn = calloc(1, sizeof *conn);
    if (!conn) {
        close(fd);
        return;
    }
    *conn = (struct conn){.loop = loop, .walk_from = loop, .fd = fd, .address = *address};
    if (give(loop, conn))
        return;
    close(fd);
    free(conn);
}

const char *pen_http_loop_date(struct loop *loop)
{
    int64_t now_s = pen_clock_wall_ms() / 1000;
    if (now_s != loop->date_s) {
        time_t time = (time_t)now_s;
        struct tm utc;
        gmtime_r(&time, &utc);
        strftime(loop->date, sizeof loop->date, "%a, %d %b %Y %H:%M:%S GMT", &utc);
        loop->date_s = now_s;
    }
    return loop->date;
}

/* The one of a list that has waited longest, if it has waited for so long; else NULL. */
static struct conn *waiting_for(const struct loop *loop, const struct conn_list *list,
                                int64_t least_ns)
{
    struct conn *conn = list->first;
    return conn && loop->now_ns - conn->since_ns >= least_ns ? conn : NULL;
}

/* Closes the connection that can best be spared, of those in reserved slots or of the others: with
 * `also_fresh`, also one that has come just now. Returns false if all others are at work. */
static bool close_idlest(struct loop *loop, bool reserved, bool also_fresh)
{
    const struct conn_list *list = loop->list[reserved];
    const int64_t least_ns = also_fresh ? 0 : fresh_ns;
    struct conn *head = waiting_for(loop, &list[WAIT_HEAD], least_ns);
    struct conn *body = waiting_for(loop, &list[WAIT_BODY], least_ns);
    struct conn *idlest = list[WAIT_LINGER].first;
    if (!idlest)
        idlest = list[WAIT_IDLE].first;
    if (!idlest)
        idlest = !head || (body && body->since_ns < head->since_ns) ? body : head;
    if (!idlest)
        idlest = waiting_for(loop, &list[WAIT_READER], stalled_ns);
    if (idlest)
        pen_http_conn_close(idlest);
    return idlest != NULL;
}

/* Makes place for a new connection. Returns false if no other of this loop can be spared. */
static bool make_place(struct conn *conn)
{
    struct pen_http *http = conn->loop->http;
    int others = atomic_fetch_add_explicit(&http->connections, 1, memory_order_relaxed) -
                 atomic_load_explicit(&http->reserved, memory_order_relaxed);
    atomic_fetch_sub_explicit(&http->arriving, 1, memory_order_relaxed);
    return others < http->connection_max || close_idlest(conn->loop, false, false);
}

/* Passes a new connection on to the next loop, which may have one to spare. Returns false if that
 * is where this walk began, or it is being stopped. */
static bool pass_on(struct conn *conn)
{
    struct pen_http *http = conn->loop->http;
    struct loop *next = conn->loop->next; /* afterwards the connection is that one's */
    if (next == conn->walk_from)
        return false;
    atomic_fetch_sub_explicit(&http->connections, 1, memory_order_relaxed);
    if (give(next, conn)) {
        pen_http_loop_wake(next);
        return true;
    }
    atomic_fetch_add_explicit(&http->connections, 1, memory_order_relaxed);
    return false;
}

/* Gives a new connection one of the reserved slots. When these are taken, too, by connections that
 * have come just now or are at work, the first of this loop that has come just now gives way.
 * Returns false if all of this loop are at work. */
static bool reserve(struct conn *conn)
{
    struct pen_http *http = conn->loop->http;
    conn->reserved = true;
    if (atomic_fetch_add_explicit(&http->reserved, 1, memory_order_relaxed) < RESERVED_SLOTS ||
        close_idlest(conn->loop, true, false))
        return true;
    const bool placed = close_idlest(conn->loop, false, true);
    if (!placed && close_idlest(conn->loop, true, true))
        return true;
    conn->reserved = false;
    atomic_fetch_sub_explicit(&http->reserved, 1, memory_order_relaxed);
    return placed;
}

/* Finds a place for a new connection, which walks from loop to loop for it: once for the place of
 * one that can be spared, and again for a reserved slot, as those who hold these may all belong to
 * other loops. */
static void begin(struct conn *conn)
{
    bool placed = make_place(conn);
    if (!placed && !conn->last_walk) {
        if (pass_on(conn))
            return;
        conn->last_walk = true;
        conn->walk_from = conn->loop;
    }
    placed = placed || reserve(conn);
    if (!placed && pass_on(conn))
        return;
    append(conn, WAIT_HEAD);
    if (!placed) {
        pen_http_conn_close(conn);
        return;
    }
    /* Mostly true by now, and a call that finds otherwise costs less than waiting for an event. */
    conn->readable = conn->writable = true;
    pen_http_loop_again(conn);
}

/* Takes what other threads have left. Returns whether the loop goes on. */
static bool take_messages(struct loop *loop)
{
    pthread_mutex_lock(&loop->lock);
    atomic_store_explicit(&loop->woken, false, memory_order_relaxed);
    struct conn *accepted = NULL;
    for (struct conn *conn = loop->accepted, *next; conn; conn = next) {
        next = conn->next;
        conn->next = accepted; /* the first that came is the first in the list now */
        accepted = conn;
    }
    bool goes_on = !loop->stop;
    for (struct conn *conn = loop->resumed; conn; conn = conn->next_resumed) {
        conn->resumed = false;
        conn->wakened = conn->request && conn->request->resumed;
        pen_http_loop_again(conn);
    }
    loop->accepted = loop->resumed = NULL;
    pthread_mutex_unlock(&loop->lock);
    for (struct conn *next; accepted; accepted = next) {
        next = accepted->next;
        begin(accepted);
    }
    return goes_on;
}

static void run_ready(struct loop *loop)
{
    struct conn *ready = loop->ready;
    loop->ready = NULL;
    for (struct conn *next; ready; ready = next) {
        next = ready->next_ready;
        ready->ready = false;
        if (ready->wakened)
            pen_http_conn_resume(ready);
        else
            pen_http_conn_run(ready);
    }
}

/* How long connections of each list may wait; 0: without a limit. */
static int64_t time_of(const struct loop *loop, enum conn_wait wait)
{
    switch (wait) {
    case WAIT_IDLE:
    case WAIT_READER:
        return loop->times.idle_ns;
    case WAIT_HEAD:
        return loop->times.head_ns;
    case WAIT_BODY:
        return loop->times.body_ns;
    case WAIT_LINGER:
        return LINGER_S * second_ns;
    case WAIT_WORK:
    case WAITS:
        break;
    }
    return 0;
}

/* Ends the connections of a list that have waited for so long. Returns the time until the next one
 * has, `most_ns` at most. */
static int64_t expire_list(struct loop *loop, const struct conn_list *list, int64_t time_ns,
                           int64_t most_ns)
{
    for (struct conn *conn; (conn = list->first) != NULL;) {
        const int64_t left_ns = conn->since_ns + time_ns - loop->now_ns;
        if (left_ns > 0)
            return left_ns < most_ns ? left_ns : most_ns;
        pen_http_conn_expire(conn);
    }
    return most_ns;
}

/* Ends the connections that have waited too long. Returns the time until the next one has, in ms.
 */
static int expire(struct loop *loop)
{
    int64_t wait_ns = 60 * second_ns;
    for (enum conn_wait wait = 0; wait < WAITS; wait++) {
        const int64_t time_ns = time_of(loop, wait);
        for (int reserved = 0; time_ns && reserved < 2; reserved++)
            wait_ns = expire_list(loop, &loop->list[reserved][wait], time_ns, wait_ns);
    }
    return loop->ready ? 0 : (int)(wait_ns / 1000000) + 1;
}

/* Frees the connections that were closed in this turn. No list has them any more, but the kernel's
 * events of this turn and `ready` could still have had them. */
static void free_dead(struct loop *loop)
{
    if (!loop->dead)
        return;
    for (struct conn **link = &loop->ready; *link;) {
        if ((*link)->state == CONN_DEAD)
            *link = (*link)->next_ready;
        else
            link = &(*link)->next_ready;
    }
    pthread_mutex_lock(&loop->lock);
    for (struct conn **link = &loop->resumed; *link;) {
        if ((*link)->state == CONN_DEAD)
            *link = (*link)->next_resumed;
        else
            link = &(*link)->next_resumed;
    }
    pthread_mutex_unlock(&loop->lock);
    for (struct conn *next; loop->dead; loop->dead = next) {
        next = loop->dead->next;
        free(loop->dead);
    }
}

static void handle_event(struct loop *loop, const struct epoll_event *event)
{
    struct conn *conn = event->data.ptr;
    eventfd_t ignored;
    if (!conn) {
        eventfd_read(loop->wake_fd, &ignored);
        return;
    }
    if (event->events & (EPOLLIN | EPOLLRDHUP))
        conn->readable = true;
    if (event->events & EPOLLOUT)
        conn->writable = true;
    if (event->events & EPOLLRDHUP)
        conn->half_closed = true;
    if (event->events & (EPOLLERR | EPOLLHUP))
        conn->reset = true;
    pen_http_conn_run(conn);
}

static void close_all(struct loop *loop)
{
    for (int i = 0; i < 2 * WAITS; i++) {
        const struct conn_list *list = &loop->list[i / WAITS][i % WAITS];
        while (list->first)
            pen_http_conn_close(list->first);
    }
    free_dead(loop);
}

static void *run(void *arg)
{
    struct loop *loop = arg;
    struct epoll_event events[EVENTS];
    int wait_ms = 0;
    bool goes_on = true;
    while (goes_on) {
        int count = epoll_wait(loop->epoll_fd, events, EVENTS, wait_ms);
        loop->now_ns = pen_clock_ns();
        for (int i = 0; i < count; i++)
            handle_event(loop, &events[i]);
        goes_on = take_messages(loop);
        run_ready(loop);
        wait_ms = expire(loop);
        free_dead(loop);
    }
    close_all(loop);
    return NULL;
}

static void release(struct loop *loop)
{
    if (loop->epoll_fd >= 0)
        close(loop->epoll_fd);
    if (loop->wake_fd >= 0)
        close(loop->wake_fd);
    pthread_mutex_destroy(&loop->lock);
    free(loop->buffer);
    free(loop);
}

struct loop *pen_http_loop_start(struct pen_http *http, const struct loop_times *times,
                                 struct pen_status *st)
{
    struct loop *loop = calloc(1, sizeof *loop);
    char *buffer = malloc(LOOP_BYTES);
    if (!loop || !buffer) {
        free(loop);
        free(buffer);
        pen_fail(st, PEN_NO_MEMORY, "no memory for the HTTP server");
        return NULL;
    }
    *loop = (struct loop){.http = http,
                          .times = *times,
                          .buffer = buffer,
                          .now_ns = pen_clock_ns(),
                          .epoll_fd = epoll_create1(EPOLL_CLOEXEC),
                          .wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
    struct epoll_event event = {.events = EPOLLIN, .data.ptr = NULL};
    pthread_mutex_init(&loop->lock, NULL);
    if (loop->epoll_fd >= 0 && loop->wake_fd >= 0 &&
        epoll_ctl(loop->epoll_fd, EPOLL_CTL_ADD, loop->wake_fd, &event) == 0 &&
        pthread_create(&loop->thread, NULL, run, loop) == 0)
        return loop;
    release(loop);
    pen_fail(st, PEN_UNAVAILABLE, "the HTTP server does not start");
    return NULL;
}

void pen_http_loops_stop(struct loop *const *loops, int count)
{
    for (int i = 0; i < count; i++) {
        pthread_mutex_lock(&loops[i]->lock);
        loops[i]->stop = true;
        pthread_mutex_unlock(&loops[i]->lock);
        pen_http_loop_wake(loops[i]);
    }
    for (int i = 0; i < count; i++)
        pthread_join(loops[i]->thread, NULL);
    for (int i = 0; i < count; i++)
        release(loops[i]);
}
