/* SPDX-License-Identifier: MIT */
/* Pauses before accepting, against clients on a clock of the test's own. */
#include <stdio.h>

#include "http/internal/pace.h"
#include "support/suite.h"

enum { CLIENTS_MAX = 64, SECONDS = 4, ACCEPT_NS = 4000, ANSWER_NS = 20000, AGAIN_NS = 30000 };
static const int64_t second_ns = INT64_C(1000000000);

/* Clients of a server with one thread that accepts and one that answers. */
struct world {
    int64_t now_ns, answered_ns; /* answered: when the last answer is ready */
    int clients;                 /* each connects again AGAIN_NS after its answer ... */
    int per_second; /* ... or so many connect in a second, whatever becomes of the others */
    int64_t due_ns[CLIENTS_MAX]; /* when each client connects next */
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

/* Accepts all that have come, and has them answered. Returns their number. */
static int accept_all(struct world *world)
{
    int count = 0, client;
    while (next_ns(world, &client) <= world->now_ns) {
        world->now_ns += ACCEPT_NS;
        if (world->answered_ns < world->now_ns)
            world->answered_ns = world->now_ns;
        world->answered_ns += ANSWER_NS;
        world->due_ns[client] = world->answered_ns + AGAIN_NS;
        world->begun++;
        count++;
    }
    return count;
}

struct result {
    double per_second, per_wake;
    bool rush;
};

/* What comes of it in the last of some seconds, with pauses or without any. */
static struct result run(int clients, int per_second, bool pauses)
{
    struct world world = {.clients = clients, .per_second = per_second};
    struct pace pace = {0};
    struct result result = {0};
    int accepted = 0, wakes = 0, client;
    for (int count = 0; world.now_ns < SECONDS * second_ns;) {
        const int64_t pause_ns = pen_http_pace_pause(&pace, world.now_ns);
        const int64_t next = next_ns(&world, &client);
        if (pauses && pause_ns > 0 && count > 0)
            world.now_ns += pause_ns;
        else
            world.now_ns = next > world.now_ns ? next : world.now_ns;
        count = accept_all(&world);
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
 * all that they would get without pauses where there are one or two, else thousands in a second. */
START_TEST(test_pace__clients_that_wait_are_not_held_up_much)
{
    for (int clients = 1; clients <= CLIENTS_MAX; clients += clients < 20 ? 1 : 11) {
        const struct result with = run(clients, 0, true), without = run(clients, 0, false);
        const double promised = clients > 4 ? 7500 : clients > 2 ? 5000 : without.per_second;
        if ((clients & (clients - 1)) == 0)
            printf("# %d clients: %.0f in a second, %.0f without pauses\n", clients,
                   with.per_second, without.per_second);
        ck_assert_double_ge(with.per_second, 0.9 * promised);
    }
}
END_TEST

PEN_SUITE("pace", test_pace__pauses_gather_what_comes_fast,
          test_pace__clients_that_wait_are_not_held_up_much)
