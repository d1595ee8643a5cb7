/* SPDX-License-Identifier: MIT */
/* How long a claim takes while many jobs wait: bench_claims STORE [JOBS [ADDRESSES]] fills a new
 * store and prints the time of a submit and of a claim. Nothing is rendered. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "store/store.h"

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

static void die(const char *what, const struct pen_status *st)
{
    fprintf(stderr, "bench_claims: %s: %s\n", what, st->msg);
    exit(1);
}

/* Stores job n, of one batch, from one of so many addresses. */
static void submit(struct pen_store *store, int n, int addresses)
{
    static const unsigned char sha256[32];
    const struct pen_view_new view = {"main", 4, 4};
    const struct pen_batch_new batch = {.tile_count = 1, .pixels = 16};
    char id[PEN_ID_BYTES], address[32];
    struct pen_buf answer = {0};
    struct pen_status st;
    enum pen_submit_result result;
    snprintf(id, sizeof id, "01900000-0000-7000-8000-%012d", n);
    snprintf(address, sizeof address, "10.0.%d.%d", n % addresses / 250, n % addresses % 250);
    const struct pen_job_new job = {.id = id,
                                    .created_ms = pen_clock_wall_ms(),
                                    .kind = "render",
                                    .request = "{}",
                                    .scene = "{}",
                                    .scene_bytes = 2,
                                    .scene_sha256 = sha256,
                                    .max_attempts = 3,
                                    .view_count = 1,
                                    .views = &view,
                                    .batch_count = 1,
                                    .batches = &batch,
#ifndef BEFORE
                                    .client = address
#endif
    };
    if (!pen_store_submit(store, &job, &result, &answer, &st))
        die("submit", &st);
    pen_buf_release(&answer);
}

/* Claims a batch and commits it; returns the time of the claim. */
static double work(struct pen_store *store)
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
    if (!pen_store_claim(store, "w", 60000, &claim, &found, &st) || !found)
        die("claim", &st);
    const double ms = (double)(pen_clock_ns() - begun_ns) * 1e-6;
    claim.spent_us = 1000;
    if (!pen_store_commit(store, &claim, &result, &st))
        die("commit", &st);
    return ms;
}

int main(int argc, char **argv)
{
    double ms[CLAIMS];
    struct pen_status st;
    const int jobs = number(argv, argc, 2, JOBS), addresses = number(argv, argc, 3, 1);
    const int claims = jobs < CLAIMS ? jobs : CLAIMS;
    if (argc < 2) {
        fprintf(stderr, "usage: bench_claims STORE [JOBS [ADDRESSES]]\n");
        return 2;
    }
    struct pen_store *store = pen_store_open(argv[1], &st);
    if (!store)
        die("open", &st);
    int64_t begun_ns = pen_clock_ns();
    for (int n = 0; n < jobs; n++)
        submit(store, n, addresses);
    printf("%d jobs of %d addresses: %.3f ms per submit\n", jobs, addresses,
           (double)(pen_clock_ns() - begun_ns) * 1e-6 / jobs);
    for (int i = 0; i < claims; i++)
        ms[i] = work(store);
    qsort(ms, (size_t)claims, sizeof *ms, by_value);
    printf("a claim takes %.3f ms (median), %.3f ms (95 of 100)\n", ms[claims / 2],
           ms[claims * 95 / 100]);
    pen_store_close(store);
    return 0;
}
