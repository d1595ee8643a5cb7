/* SPDX-License-Identifier: MIT */
#include "http/internal/waiting.h"

#include "http/internal/request.h"

enum { TURN_SHARE = 3 }; /* times as long as for the oldest, threads work for those in turn */

void pen_http_waiting_init(struct waiting *waiting, bool by_turns)
{
    *waiting = (struct waiting){.by_turns = by_turns, .tail = &waiting->head};
}

/* The place of a client that is remembered; else the first of nobody, or of the one that was not
 * served for longest. */
static struct served *place_of(struct waiting *waiting, const struct pen_address_key *client)
{
    struct served *oldest = &waiting->served[0];
    for (int i = 0; i < SERVED_MAX; i++) {
        struct served *served = &waiting->served[i];
        if (served->turn > 0 && pen_http_address_equal(&served->client, client))
            return served;
        if (served->turn < oldest->turn)
            oldest = served;
    }
    return oldest;
}

/* When this client was served last; 0: never, as far as is remembered. */
static uint64_t last_turn(struct waiting *waiting, const struct pen_address_key *client)
{
    const struct served *place = place_of(waiting, client);
    return pen_http_address_equal(&place->client, client) ? place->turn : 0;
}

/* Remembers that a client is being served. */
static void note_served(struct waiting *waiting, const struct pen_address_key *client)
{
    struct served *place = place_of(waiting, client);
    place->client = *client;
    place->turn = ++waiting->turns;
    for (struct request *other = waiting->head; other; other = other->next) {
        if (pen_http_address_equal(&other->client, client))
            other->last_turn = place->turn;
    }
}

void pen_http_waiting_add(struct waiting *waiting, struct request *request)
{
    if (waiting->by_turns)
        request->last_turn = last_turn(waiting, &request->client);
    request->next = NULL;
    *waiting->tail = request;
    waiting->tail = &request->next;
    waiting->count++;
}

static bool is_before(const struct request *a, const struct request *b)
{
    return a->last_turn < b->last_turn ||
           (a->last_turn == b->last_turn && a->work_bytes < b->work_bytes);
}

/* The place of the request that is next, of those that wait. */
static struct request **choose(struct waiting *waiting, bool *oldest)
{
    struct request **chosen = &waiting->head;
    *oldest = !waiting->by_turns ||
              (!waiting->was_oldest && waiting->turn_ns > TURN_SHARE * waiting->oldest_ns);
    waiting->was_oldest = *oldest;
    if (*oldest)
        return chosen;
    for (struct request **link = chosen; *link; link = &(*link)->next) {
        if (is_before(*link, *chosen))
            chosen = link;
    }
    return chosen;
}

struct request *pen_http_waiting_take(struct waiting *waiting, bool *oldest)
{
    if (!waiting->head) {
        waiting->turn_ns = waiting->oldest_ns = 0;
        return NULL;
    }
    struct request **link = choose(waiting, oldest);
    struct request *request = *link;
    *link = request->next;
    if (!request->next)
        waiting->tail = link;
    waiting->count--;
    if (waiting->by_turns)
        note_served(waiting, &request->client);
    return request;
}

void pen_http_waiting_spent(struct waiting *waiting, bool oldest, int64_t ns)
{
    *(oldest ? &waiting->oldest_ns : &waiting->turn_ns) += ns;
}
