/* SPDX-License-Identifier: MIT */
/* A thread with an epoll set, which serves its connections: reads requests, answers them or hands
 * them to the executor, sends answers. It never blocks, and it closes connections that keep it
 * waiting:
 *
 *   waits for                time
 *   a first or next request  idle_ns
 *   the rest of a head       head_ns from its first byte, or from accepting
 *   the rest of a body       body_ns for each window: as much as comes in body_ns at BODY_RATE
 *   a client that reads      idle_ns for each window of the answer, READER_BYTES or its rest; less
 *                            where memory is used up (answers.h)
 *   the end of a client      2 s, or 10 s while it still sends
 *
 * A client that vanishes without a word is found by the kernel (keep-alive probes, whose times
 * listener.c sets; conn_send.c sets TCP_USER_TIMEOUT for streams), a client that closes its
 * connection by epoll at once.
 *
 * A window of a body, or of an answer, ends early when its bytes have come, or the client has taken
 * them, and the next one begins: bytes that come soon buy no time for those that follow. Nobody
 * waits for what the kernel holds of an answer when all was given to it. It takes more of it when
 * the client has taken some 64 KiB of what it holds, 128 KiB at most (UNSENT_BYTES in listener.c).
 *
 * When there are as many connections as allowed, one more takes the place of the one that has been
 * idle longest: one that is being closed, or waits for a request; else the one whose head, or
 * window of a body, began first, more than 1 s ago; else the reader whose window began first, more
 * than 2 s ago. If a loop has none of these, it passes the new one on to the next loop. If no loop
 * has one, the new one gets a reserved slot (http.h). These are not counted, and only when all of
 * them are taken, too, somebody gives way in the same order who has one, or who has come less than
 * 1 s ago: on this loop, or else on the next that has such a one. */
#ifndef PEN_HTTP_INTERNAL_LOOP_H
#define PEN_HTTP_INTERNAL_LOOP_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "http/internal/conn.h"

struct pen_http;

enum {
    LOOP_BYTES = 64 << 10,   /* read at once */
    BODY_RATE = 4096,        /* bytes per second */
    READER_BYTES = 128 << 10 /* the window of an answer */
};

struct loop_times {
    int64_t idle_ns, head_ns, body_ns;
};

struct loop {
    struct pen_http *http;
    struct loop *next; /* the loops are in a ring */
    struct loop_times times;
    int epoll_fd, wake_fd; /* wake_fd: an eventfd, written by who left something under `lock` */
    pthread_t thread;
    int64_t now_ns; /* when the loop last woke */
    struct conn_list {
        struct conn *first, *last;
        atomic_int count; /* atomic: relaxed, only this thread changes it, /metrics reads it */
    } list[2][WAITS];     /* of connections without and with a reserved slot */
    struct conn *ready;   /* connections that can go on without an event */
    struct conn *dead;    /* closed, freed at the end of a turn; linked by `next` */
    char date[40];        /* the value of a Date field */
    int64_t date_s;       /* the second for which it was made */
    char *buffer;         /* LOOP_BYTES */

    pthread_mutex_t lock;
    struct conn *resumed;  /* guarded by lock: connections whose requests were resumed */
    struct conn *accepted; /* guarded by lock: new connections, linked by `next` */
    bool stop;             /* guarded by lock */
    atomic_bool woken;     /* wake_fd was written since the loop last took what is under the lock.
                            * atomic: relaxed, as threads set it after they held the lock to leave
                            * something, and the loop clears it with the lock held */
};

/* Starts a loop. Owns: pen_http_loops_stop frees. Fails: PEN_UNAVAILABLE, PEN_NO_MEMORY. */
struct loop *pen_http_loop_start(struct pen_http *http, const struct loop_times *times,
                                 struct pen_status *st);

/* Closes all connections, ends the threads and frees the loops, which are all of a ring: until all
 * threads have ended, one may pass a connection on to another. No request may be with another
 * thread. */
void pen_http_loops_stop(struct loop *const *loops, int count);

/* Gives an accepted socket to the loop, which closes it. The loop is not woken: a caller that has
 * several for it wakes it once, behind the last. Threads: any. */
void pen_http_loop_add(struct loop *loop, int fd, const struct pen_address_key *address);

/* Wakes the loop for what was left under its lock, unless it was woken for others of these and has
 * not looked yet. Threads: any. */
void pen_http_loop_wake(struct loop *loop);

/* Moves a connection to the end of a list. Threads: the loop's. */
void pen_http_loop_wait(struct conn *conn, enum conn_wait wait);

/* Whether new connections come so fast that answers to wrong requests have to be cheap. */
bool pen_http_loop_rush(const struct loop *loop);

/* Whether that is so, and refusals close their connections. In each second of a rush they do not
 * for its first tenth: clients that would use their connections again keep them then, and are no
 * part of the rush any more, which they would keep up if every refusal made them connect again. */
bool pen_http_loop_closes_refused(const struct loop *loop);

/* Asks the kernel to tell of this connection, and to find out whether its client is still there,
 * unless it does so already: one that is answered and closed at once needs neither events nor a
 * timer. Returns false if the kernel is out of memory. Threads: the loop's. */
bool pen_http_loop_watch(struct conn *conn);

/* Makes the loop run this connection again in this turn or the next. Threads: the loop's. */
void pen_http_loop_again(struct conn *conn);

/* Takes a closed connection out of the loop. Threads: the loop's. */
void pen_http_loop_remove(struct conn *conn);

/* Tells the loop of a request's connection that its answer is ready, or more of its stream, or that
 * it has to give way (intake.h, answers.h). Unless it is a stream, or a lock keeps the loop from
 * ending the request, the caller must not touch it afterwards. Locks: the loop's. Threads: any. */
void pen_http_resume(struct request *request);

/* The value of a Date field now. */
const char *pen_http_loop_date(struct loop *loop);

#endif
