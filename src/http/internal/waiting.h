/* SPDX-License-Identifier: MIT */
/* The requests that wait for the threads of one queue, and which of them is next.
 *
 * First in, first out, or by turns. By turns, next is a request of the client (by address) that was
 * not served for longest, and of that one's the request that takes the least work: so neither many
 * requests of one client nor a long one hold up others for longer than a turn. For a quarter of the
 * time, but never twice in a row, it is the oldest request, so that none is overtaken for ever.
 *
 * Clients are told apart as far as they have addresses of their own: behind a proxy that is not
 * trusted, or on the machine itself, they are one.
 *
 * Threads: the caller has a lock. */
#ifndef PEN_HTTP_INTERNAL_WAITING_H
#define PEN_HTTP_INTERNAL_WAITING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "http/internal/addresses.h"

struct request;

enum { SERVED_MAX = 64 }; /* clients that are remembered; one that is not counts as never served */

struct waiting {
    bool by_turns;
    struct request *head, **tail; /* the oldest first, linked by request->next */
    int count;
    /* By turns: time spent on requests that were chosen for their turn, and as the oldest, since
     * nothing waited; and whether the last one was chosen as the oldest. */
    int64_t turn_ns, oldest_ns;
    bool was_oldest;
    uint64_t turns; /* how many requests were taken */
    struct served {
        struct pen_address_key client;
        uint64_t turn; /* of `turns`, when it was served last; 0: nobody's */
    } served[SERVED_MAX];
};

void pen_http_waiting_init(struct waiting *waiting, bool by_turns);

void pen_http_waiting_add(struct waiting *waiting, struct request *request);

/* Takes the next request out; NULL: none waits. *oldest tells why it was chosen, which the caller
 * gives back with the time that it took. */
struct request *pen_http_waiting_take(struct waiting *waiting, bool *oldest);
void pen_http_waiting_spent(struct waiting *waiting, bool oldest, int64_t ns);

#endif
