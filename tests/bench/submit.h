/* SPDX-License-Identifier: MIT */
/* A job for benches of the store, which never renders. */
#ifndef TESTS_BENCH_SUBMIT_H
#define TESTS_BENCH_SUBMIT_H

#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "store/store.h"

enum { SUBMIT_BATCHES = 16384 };

static inline void die(const char *what, const struct pen_status *st)
{
    fprintf(stderr, "%s: %s\n", what, st->msg);
    exit(1);
}

/* Stores job n of client number `client`, with at most SUBMIT_BATCHES batches. Each batch has
 * `pixels` pixels. */
static inline void submit(struct pen_store *store, int n, int client, int batches, int pixels)
{
    static const unsigned char sha256[32];
    static struct pen_batch_new batch[SUBMIT_BATCHES];
    const struct pen_view_new view = {"main", pixels, batches};
    char id[PEN_ID_BYTES], address[32];
    struct pen_buf answer = {0};
    struct pen_status st;
    enum pen_submit_result result;
    snprintf(id, sizeof id, "01900000-0000-7000-8000-%012d", n);
    snprintf(address, sizeof address, "10.0.%d.%d", client / 250, client % 250);
    for (int i = 0; i < batches; i++)
        batch[i] = (struct pen_batch_new){.first_tile = i, .tile_count = 1, .pixels = pixels};
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
                                    .batch_count = batches,
                                    .batches = batch,
                                    .client = address};
    if (!pen_store_submit(store, &job, &result, &answer, &st))
        die("submit", &st);
    pen_buf_release(&answer);
}

#endif
