/* SPDX-License-Identifier: MIT */
/* What happens to a request between its connection and its handler.
 *
 * Threads: that of the connection's loop. */
#ifndef PEN_HTTP_INTERNAL_EXCHANGE_H
#define PEN_HTTP_INTERNAL_EXCHANGE_H

#include <stdbool.h>
#include <stddef.h>

struct conn;
struct request;

/* Makes the request of a head that has arrived, and checks it. Returns NULL when out of memory. */
struct request *pen_http_exchange_begin(struct conn *conn, const char *head, size_t bytes);

/* The body is complete: answers the request at once if its route can (it is then in
 * PHASE_ANSWERED), otherwise gives it to the executor (PHASE_WORK). */
void pen_http_exchange_dispatch(struct request *request);

/* The client has closed the connection, and the request is in PHASE_WORK. Returns whether the
 * request is the loop's again, without an answer; otherwise it will be resumed. */
bool pen_http_exchange_abandon(struct request *request);

/* The client has closed its side, and the request is in PHASE_WORK. Returns true once for a request
 * that takes long and of which nothing comes but its answer: an interim answer is to be sent. A
 * client that has closed its socket, which looks the same, refuses that with a reset; the request
 * is then unwanted. One that has only ended its side reads on, as HTTP/1.1 asks of it. */
bool pen_http_exchange_probes(struct request *request);

/* Ends a request that the loop has: logs and frees it. */
void pen_http_exchange_end(struct request *request, bool complete);

#endif
