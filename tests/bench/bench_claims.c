/* SPDX-License-Identifier: MIT */
/* How long a claim takes while many jobs wait. bench_claims STORE [JOBS [CLIENTS]] fills a new
 * store and prints the time of a submit and of a claim. It also prints the time to submit one job
 * with as many batches as a job may have. It renders nothing. */
#include <stdlib.h>

#include "bench/submit.h"

enum { JOBS = 24000, CLAIMS = 400 };

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int number(char **argv, int argc, int i, int otherwise)
{
    const int given = argc > i ? atoi(argv[i]) : 0;
    return given > 0 ? given : otherwise;
}

/* Claims a batch and commits it; returns the time of the claim. */
static double work(struct pen_store *store, int serial)
{
    static const float rgb[48];
    const struct pen_result result = {.rgb = rgb,
                                      .pixels = 16,
                                      .stats = "{}",
                                      .layer = "beauty",
                                      .format = "png",
                                      .artefact = "p",
                                      .artefact_bytes = 1};
    struct pen_claim claim;
    struct pen_status st;
    bool found = false;
    const int64_t begun_ns = pen_clock_ns();
    if (!pen_store_claim(store, "w", 60000, serial, &claim, &found, &st) || !found)
        die("claim", &st);
    const double ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    claim.spent_us = 1000;
    if (!pen_store_commit(store, &claim, &result, NULL, &st))
        die("commit", &st);
    return ms;
}

int main(int argc, char **argv)
{
    double ms[CLAIMS];
    struct pen_status st;
    const int jobs = number(argv, argc, 2, JOBS), clients = number(argv, argc, 3, 1000);
    const int claims = jobs < CLAIMS ? jobs : CLAIMS;
    if (argc < 2) {
        fprintf(stderr, "usage: bench_claims STORE [JOBS [CLIENTS]]\n");
        return 2;
    }
    struct pen_store *store = pen_store_open(argv[1], true, &st);
    if (!store)
        die("open", &st);
    int64_t begun_ns = pen_clock_ns();
    for (int n = 0; n < jobs; n++)
        submit(store, n, n % clients, 1, 16);
    printf("%d jobs of %d clients: %.3f ms per submit\n", jobs, clients,
           (double)(pen_clock_ns() - begun_ns) * 1e-6 / jobs);
    for (int i = 0; i < claims; i++)
        ms[i] = work(store, i + 1);
    qsort(ms, (size_t)claims, sizeof *ms, by_value);
    printf("a claim takes %.3f ms (median), %.3f ms (95 of 100)\n", ms[claims / 2],
           ms[claims * 95 / 100]);
    begun_ns = pen_clock_ns();
    submit(store, jobs, jobs % clients, SUBMIT_BATCHES, 16);
    printf("a submit of %d batches takes %.1f ms\n", SUBMIT_BATCHES,
           (double)(pen_clock_ns() - begun_ns) * 1e-6);
    pen_store_close(store);
    return 0;
}
