/* SPDX-License-Identifier: MIT */
/* Pauses before accepting, against clients on a clock of the test's own. */
#include <stdio.h>

#include "http/internal/pace.h"
#include "support/suite.h"

enum { CLIENTS_MAX = 256, SECONDS = 4, ACCEPT_NS = 4000, ANSWER_NS = 20000, AGAIN_NS = 30000 };
enum { WAKE_NS = 100000, STALL_NS = 10000000 };
static const int64_t second_ns = INT64_C(1000000000);

/* Clients of a server with one thread that accepts and one that answers. The latter takes
 * connections once it has answered those it had, WAKE_NS after it was woken if it had none. */
struct world {
    int64_t now_ns;
    int64_t answered_ns;      /* when the last of the connections that were taken has its answer */
    int64_t taken_ns;         /* when the thread takes those that arrive */
    bool woken;               /* it was woken for them */
    int arriving;             /* accepted, not taken yet ... */
    int whose[PACE_ARRIVING]; /* ... and of these clients */
    int clients;              /* each connects again AGAIN_NS after its answer ... */
    int per_second; /* ... or so many connect in a second, whatever becomes of the others */
    int64_t due_ns[CLIENTS_MAX]; /* when each client connects next; while it waits, never */
    int64_t begun;               /* of those that come in any case */
};

/* When the next connection comes, and whose it is. */
static int64_t next_ns(const struct world *world, int *client)
{
    *client = 0;
    if (world->per_second > 0)
        return world->begun * second_ns / world->per_second;
    for (int i = 1; i < world->clients; i++)
        *client = world->due_ns[i] < world->due_ns[*client] ? i : *client;
    return world->due_ns[*client];
}

/* The answering thread takes what has arrived. */
static void take(struct world *world)
{
    if (world->answered_ns < world->taken_ns)
        world->answered_ns = world->taken_ns;
    for (int i = 0; i < world->arriving; i++) {
        world->answered_ns += ANSWER_NS;
        world->due_ns[world->whose[i]] = world->answered_ns + AGAIN_NS;
    }
    world->arriving = 0;
    world->woken = false;
}

static void wake(struct world *world)
{
    if (world->woken)
        return;
    const bool idle = world->answered_ns <= world->now_ns;
    world->taken_ns = idle ? world->now_ns + WAKE_NS : world->answered_ns;
    world->woken = true;
}

static void pass_time(struct world *world, int64_t until_ns)
{
    if (world->woken && world->taken_ns <= until_ns) {
        world->now_ns = world->taken_ns > world->now_ns ? world->taken_ns : world->now_ns;
        take(world);
    }
    world->now_ns = until_ns > world->now_ns ? until_ns : world->now_ns;
}

/* Accepts a burst. Returns its number. */
static int accept_burst(struct world *world, bool together)
{
    int count = 0, client;
    while (count < PACE_BURST && world->arriving < PACE_ARRIVING &&
           next_ns(world, &client) <= world->now_ns) {
        world->whose[world->arriving++] = client;
        world->due_ns[client] = INT64_MAX;
        world->begun++;
        count++;
        pass_time(world, world->now_ns + ACCEPT_NS);
        if (!together)
            wake(world);
    }
    if (count > 0)
        wake(world);
    return count;
}

/* The acceptor waits so long, or for the next connection. */
static void wait_for_more(struct world *world, int64_t wait_ns)
{
    int client;
    if (wait_ns > 0)
        pass_time(world, world->now_ns + wait_ns);
    for (int64_t next; wait_ns == 0 && (next = next_ns(world, &client)) > world->now_ns;)
        pass_time(world, world->woken && world->taken_ns < next ? world->taken_ns : next);
}

struct result {
    double per_second, per_wake;
    bool rush;
};

/* What comes of it in the last of some seconds, with pauses or without any. In the second one the
 * acceptor gets no processor for a while. */
static struct result run(int clients, int per_second, bool pauses)
{
    struct world world = {.clients = clients, .per_second = per_second};
    struct pace pace = {0};
    struct result result = {0};
    int accepted = 0, wakes = 0;
    for (bool stalled = false; world.now_ns < SECONDS * second_ns;) {
        if (!stalled && world.now_ns > second_ns) {
            pass_time(&world, world.now_ns + STALL_NS);
            stalled = true;
        }
        const int64_t wait_ns = pen_http_pace_wait(&pace, world.now_ns, world.arriving);
        const bool pause = pauses || world.arriving == PACE_ARRIVING;
        wait_for_more(&world, pause ? wait_ns : 0);
        const int count = accept_burst(&world, pauses && pace.pause_ns > 0);
        pen_http_pace_count(&pace, count);
        if (world.now_ns > (SECONDS - 1) * second_ns) {
            accepted += count;
            wakes += count > 0;
            result.rush = pace.rush;
        }
    }
    result.per_second = accepted;
    result.per_wake = (double)accepted / wakes;
    return result;
}

/* Where connections come fast whatever becomes of them, a pause gathers some twenty. */
START_TEST(test_pace__pauses_gather_what_comes_fast)
{
    static const struct {
        int per_second;
        double least, most; /* connections at a wake */
        bool rush;
    } rows[] = {{100, 1, 1, false},   {3000, 1, 1, false},   {5000, 1, 2, true},
                {7000, 3, 5, true},   {10000, 15, 25, true}, {20000, 15, 30, true},
                {40000, 15, 30, true}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const struct result got = run(0, rows[i].per_second, true);
        printf("# %d in a second: %.1f at a wake\n", rows[i].per_second, got.per_wake);
        ck_assert_double_ge(got.per_wake, rows[i].least);
        ck_assert_double_le(got.per_wake, rows[i].most);
        ck_assert_int_eq(got.rush, rows[i].rush);
        ck_assert_double_gt(got.per_second, 0.99 * rows[i].per_second);
    }
}
END_TEST

/* Clients that wait for their answers are held up by pauses, but not below what is promised: nearly
 * all that they would get without pauses where there are one or two, or more than a burst, else
 * thousands in a second. */
START_TEST(test_pace__clients_that_wait_are_not_held_up_much)
{
    for (int clients = 1; clients <= CLIENTS_MAX; clients += clients < 20 ? 1 : 4) {
        const struct result with = run(clients, 0, true), without = run(clients, 0, false);
        const bool all = clients < 3 || clients > 2 * PACE_BURST;
        const double promised = all ? without.per_second : clients > 4 ? 7500 : 5000;
        if ((clients & (clients - 1)) == 0)
            printf("# %d clients: %.0f in a second, %.0f without pauses\n", clients,
                   with.per_second, without.per_second);
        ck_assert_double_ge(with.per_second, 0.9 * promised);
    }
}
END_TEST

/* Pauses are for connections to come: where they have, or the loops are to look at them first,
 * there is nothing to wait for, or not for long. */
START_TEST(test_pace__a_full_burst_is_followed_at_once)
{
    const int64_t most_ns = 1000000;
    struct pace pace = {0};
    int64_t now_ns = 0;
    for (; now_ns < second_ns; now_ns += 1000000) {
        pen_http_pace_wait(&pace, now_ns, 0);
        pen_http_pace_count(&pace, 10);
    }
    ck_assert_int_gt(pen_http_pace_wait(&pace, now_ns, 0), 0);
    pen_http_pace_count(&pace, PACE_BURST);
    ck_assert_int_eq(pen_http_pace_wait(&pace, now_ns, 0), 0);
    ck_assert_int_gt(pen_http_pace_wait(&pace, now_ns, PACE_ARRIVING), 0);
    ck_assert_int_le(pen_http_pace_wait(&pace, now_ns, PACE_ARRIVING), most_ns);
    pen_http_pace_count(&pace, 0);
    ck_assert_int_eq(pen_http_pace_wait(&pace, now_ns, 0), 0);
}
END_TEST

PEN_SUITE("pace", test_pace__pauses_gather_what_comes_fast,
          test_pace__clients_that_wait_are_not_held_up_much,
          test_pace__a_full_burst_is_followed_at_once)
