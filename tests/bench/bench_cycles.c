/* SPDX-License-Identifier: MIT */
/* How many batches a store takes in a second. bench_cycles STORE [CONNECTIONS [SECONDS]] fills a
 * new store. Its threads commit batches, each with a result of about 64 KiB, and claim the next
 * ones in the same transactions. It renders nothing. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench/submit.h"

enum { CONNECTIONS = 16, SECONDS = 10, JOBS = 64, BATCHES = 1024, PIXELS = 6272 };

static const char *url;
static atomic_bool stop;
static atomic_llong cycles;
static float rgb[3 * PIXELS]; /* random, so that they take their full size */

static struct pen_store *open_store(void)
{
    struct pen_status st;
    struct pen_store *store = pen_store_open(url, true, &st);
    if (!store)
        die("open", &st);
    return store;
}

static void *work(void *user)
{
    static const struct pen_result result = {
        .rgb = rgb, .pixels = PIXELS, .stats = "{}", .work = 1000};
    struct pen_store *store = open_store();
    struct pen_next next = {.worker = user, .lease_ms = 60000, .serial = 1};
    struct pen_status st;
    if (!pen_store_claim(store, next.worker, next.lease_ms, 1, &next.claim, &next.found, &st))
        die("claim", &st);
    while (next.found && !atomic_load(&stop)) {
        const struct pen_claim claim = next.claim;
        next.serial++;
        if (!pen_store_commit(store, &claim, &result, &next, &st))
            die("commit", &st);
        atomic_fetch_add(&cycles, 1);
    }
    pen_store_close(store);
    return NULL;
}

int main(int argc, char **argv)
{
    const int connections = argc > 2 ? atoi(argv[2]) : CONNECTIONS;
    const int seconds = argc > 3 ? atoi(argv[3]) : SECONDS;
    static pthread_t threads[256];
    static char names[256][16];
    if (argc < 2 || connections < 1 || connections > 256 || seconds < 1) {
        fprintf(stderr, "usage: bench_cycles STORE [CONNECTIONS [SECONDS]]\n");
        return 2;
    }
    url = argv[1];
    for (int i = 0; i < 3 * PIXELS; i++)
        rgb[i] = (float)rand() / (float)RAND_MAX;
    struct pen_store *store = open_store();
    for (int n = 0; n < JOBS; n++)
        submit(store, n, n, BATCHES, PIXELS); /* each of its own client: they take turns */
    for (int i = 0; i < connections; i++) {
        snprintf(names[i], sizeof names[i], "worker%d", i);
        pthread_create(&threads[i], NULL, work, names[i]);
    }
    const int64_t begun_ns = pen_clock_ns();
    struct timespec pause = {.tv_sec = seconds};
    nanosleep(&pause, NULL);
    atomic_store(&stop, true);
    for (int i = 0; i < connections; i++)
        pthread_join(threads[i], NULL);
    const double s = (double)(pen_clock_ns() - begun_ns) * 1e-9;
    printf("%d connections: %.0f batches a second\n", connections,
           (double)atomic_load(&cycles) / s);
    pen_store_close(store);
    return 0;
}
