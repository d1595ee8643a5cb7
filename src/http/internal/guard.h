/* SPDX-License-Identifier: MIT */
/* Watches the sockets of libmicrohttpd from outside, for four things that the library lacks:
 *   - deadlines for heads, bodies and readers;
 *   - closing idle connections when there are too many;
 *   - noticing that the client of a suspended request has closed its connection;
 *   - lingering closes.
 *
 * There is one slot per descriptor. The threads of libmicrohttpd store a state and a time in it,
 * without a lock. The guard's thread looks at all slots four times a second. The lock is taken when
 * a connection opens or closes, and when a suspended request is watched. libmicrohttpd reports the
 * end of a connection before it closes the descriptor. So the guard never shuts down a descriptor
 * that belongs to another connection by then.
 *
 * libmicrohttpd does not poll a suspended connection (PEER_WORK), and would not notice a shutdown.
 * The guard notifies the owner of the request that the client has gone. The owner resumes it.
 *
 * Locks: the guard's lock comes after the watcher's.
 * Threads: any, except start and stop. */
#ifndef PEN_HTTP_INTERNAL_GUARD_H
#define PEN_HTTP_INTERNAL_GUARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct request;

/* What a connection waits for. */
enum peer_state {
    PEER_FREE,
    PEER_IDLE, /* its next request, or the rest of a request line */
    PEER_HEAD, /* the rest of a head */
    PEER_BODY, /* the rest of a body */
    PEER_WORK, /* its answer, or the next event of its stream: no deadline */
    PEER_SEND, /* its client, which reads an answer */
    PEER_STATES
};

struct guard_options {
    int connections; /* beyond this number, the connections that are idle longest are closed */
    int descriptors; /* size of the table; larger than any descriptor of a connection */
    int idle_ms, head_ms, body_ms, send_ms;
    unsigned body_bytes, send_bytes; /* fewest bytes in each window of body_ms and send_ms */
    /* Called once, without a lock, when the client of a watched request has gone. */
    void (*gone)(struct request *request);
};

struct guard;

/* Starts the guard's thread.
 * Fails: PEN_UNAVAILABLE, PEN_NO_MEMORY. */
struct guard *pen_guard_start(const struct guard_options *options, struct pen_status *st);
/* Ends the thread and frees the guard. No connection may be open. NULL is allowed. */
void pen_guard_stop(struct guard *guard);

/* Notes that a connection was opened, or will be closed. */
void pen_guard_opened(struct guard *guard, int fd);
void pen_guard_closing(struct guard *guard, int fd);

/* Note what a connection waits for, and how many bytes of a body it received.
 * Threads: those of libmicrohttpd. */
void pen_guard_state(struct guard *guard, int fd, enum peer_state state);
void pen_guard_received(struct guard *guard, int fd, size_t bytes);

/* Watches whether the client of a suspended request closes its connection. Exactly one of two
 * things follows: `gone` is called, or pen_guard_unwatch returns true. */
void pen_guard_watch(struct guard *guard, int fd, struct request *request);
bool pen_guard_unwatch(struct guard *guard, int fd);

/* The number of open connections. `counts`, unless NULL, gets the numbers by state. */
int pen_guard_count(struct guard *guard, int counts[PEER_STATES]);

#endif
