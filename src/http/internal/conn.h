/* SPDX-License-Identifier: MIT */
/* One connection of a client, and the request on it.
 *
 *   HEAD ──whole head──► BODY ──whole body──► WORK ──resumed──► SEND ──► HEAD (kept), or
 *    │                    │                    ▲                 │       LINGER ──► DEAD
 *    └─ no body, answered at once ─────────────┼────────────────►│
 *                                              └─ STREAM ────────┘
 *
 * Requests follow each other on a connection: nothing is read from it between the end of a request
 * and the end of its answer. What was read with the request is kept until then, unless too much is
 * kept of all clients; the connection is then closed behind the answer.
 *
 * SEND: when memory is used up, the answer may be given up (answers.h). The connection is closed.
 *
 * WORK: another thread has the request. If the client closes the connection meanwhile, a request
 * that waits in the watcher is taken back and freed; any other goes on, and its answer is sent as
 * far as that is possible. After a reset the descriptor is closed at once, and the connection is
 * freed when the request comes back (ORPHAN).
 *
 * LINGER: the answer was sent and the server's side is shut down. What the client still sends is
 * dropped, up to a time and a number of bytes: to close a socket with unread bytes would reset the
 * connection, and the client would lose the answer.
 *
 * Threads: that of the loop, except where a field says otherwise. */
#ifndef PEN_HTTP_INTERNAL_CONN_H
#define PEN_HTTP_INTERNAL_CONN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/buf.h"
#include "http/internal/addresses.h"
#include "http/wire.h"

struct loop;
struct request;

enum conn_state {
    CONN_HEAD,
    CONN_BODY,
    CONN_WORK,
    CONN_SEND,
    CONN_STREAM,
    CONN_LINGER,
    CONN_ORPHAN,
    CONN_DEAD
};

/* What a connection waits for: the lists of a loop. In each list the connections are in the order
 * of `since_ns`. Those for which no time is set in the loop wait without a limit. */
enum conn_wait {
    WAIT_IDLE,   /* its next request */
    WAIT_HEAD,   /* the rest of a head, or of a first request */
    WAIT_BODY,   /* the rest of a body */
    WAIT_READER, /* its client, which reads an answer */
    WAIT_LINGER, /* its client, which has been answered for the last time */
    WAIT_WORK,   /* its answer, or the next event of its stream */
    WAITS
};

struct conn {
    struct loop *loop, *walk_from; /* walk_from: the first loop of this walk, see loop.c */
    bool last_walk; /* for a reserved slot, not for the place of one that can be spared */
    int fd;         /* -1: closed */
    enum conn_state state;
    struct pen_address_key address; /* of the client */

    enum conn_wait wait;
    struct conn *previous, *next; /* in the list of `wait` */
    int64_t since_ns;             /* when it came to the end of that list */
    int64_t begun_ns;             /* when it began to linger */
    uint64_t window_bytes;        /* of the body, received when its window began */
    uint64_t sent_bytes;          /* of answers, given to the kernel */
    uint64_t window_taken;        /* of them, by the client when its window of the answer began */
    bool windowed;                /* such a window has begun */

    bool watched;            /* the kernel tells the loop of it: see pen_http_loop_watch */
    bool readable, writable; /* as far as the kernel has told */
    bool half_closed;        /* the client sends nothing more */
    bool reset;              /* the connection is broken */
    bool used;               /* a request was answered */
    bool reserved;           /* it holds a slot that is kept for short requests */
    bool ready;              /* it is in the loop's list of connections that can go on */
    bool wakened;            /* the request that it has now was resumed */
    struct conn *next_ready;

    const char *data; /* received and not yet read: in `kept`, or in the loop's buffer while the
                       * loop runs this connection */
    size_t bytes;
    struct pen_buf kept;
    struct pen_head_scan scan;
    struct pen_chunks chunks;

    struct request *request; /* NULL: none */
    bool all_came;           /* all that was announced with it, and nothing behind it */
    struct pen_buf out;      /* the head of an answer, or a piece of a stream */
    size_t out_sent;
    size_t body_sent; /* bytes of the answer's body */
    size_t dropped;   /* bytes, while it lingers */
    bool stream_over; /* `out` holds the last piece */

    bool resumed;              /* guarded by the loop's lock: it is in the loop's list of those */
    struct conn *next_resumed; /* guarded by the loop's lock */
};

/* Goes on with a connection as far as the kernel allows. */
void pen_http_conn_run(struct conn *conn);

/* The request was resumed: its answer is ready, or more of its stream. */
void pen_http_conn_resume(struct conn *conn);

/* The time for which a connection may wait in its list is over. */
void pen_http_conn_expire(struct conn *conn);

/* Ends a connection at once. */
void pen_http_conn_close(struct conn *conn);

/* Ends the request and frees it. */
void pen_http_conn_end_request(struct conn *conn, bool complete);

/* How a step of a connection ended. */
enum conn_step {
    STEP_ON,   /* go on with the next one */
    STEP_WAIT, /* nothing more can be done now */
    STEP_END   /* the connection was closed or is to be */
};

/* Whether so much is kept of what clients have sent that this one's unread bytes may not be. */
bool pen_http_conn_holds_much(const struct conn *conn);

/* Begins to send the answer of the request. */
void pen_http_conn_answer(struct conn *conn);

/* Sends more of an answer, or of an event stream. */
enum conn_step pen_http_conn_send(struct conn *conn);
enum conn_step pen_http_conn_send_stream(struct conn *conn);

/* Begins a window of the answer (loop.h) if the client has taken the last one, or if it is the
 * first. Returns whether it did. */
bool pen_http_conn_begin_window(struct conn *conn);

/* The server's side was shut down: what the client still sends is dropped. */
void pen_http_conn_linger(struct conn *conn);

#endif
