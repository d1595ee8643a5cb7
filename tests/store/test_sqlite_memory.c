/* SPDX-License-Identifier: MIT */
/* The n-th allocation fails, and all after it, for every n. A handle that has run out of memory
 * keeps no lock for which others wait. Running out of memory is no fault of the store. */
#include "base/clock.h"
#include "base/log.h"
#include "support/alloc.h"
#include "support/faults.h"
#include "support/random.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

static bool submit(struct pen_store *store, int number, struct pen_status *st)
{
    struct store_job in;
    struct pen_buf answer = {0};
    enum pen_submit_result result;
    store_job_init(&in, number, 1, 1);
    bool ok = pen_store_submit(store, &in.job, &result, &answer, st);
    pen_buf_release(&answer);
    return ok;
}

static bool claim(struct pen_store *store, int number, struct pen_status *st)
{
    struct pen_claim claim;
    bool found;
    return pen_store_claim(store, "w", 60000, number, &claim, &found, st);
}

static bool list(struct pen_store *store, int number, struct pen_status *st)
{
    struct pen_job_filter filter = {.state = -1, .limit = 3};
    struct pen_job_record *jobs;
    int count;
    (void)number;
    bool ok = pen_store_jobs(store, &filter, &jobs, &count, st);
    if (ok)
        pen_job_records_free(jobs, count);
    return ok;
}

/* A job of its own, from its submit to its end, with a value of several parts. */
static bool commit(struct pen_store *store, int number, struct pen_status *st)
{
    static char picture[(1 << 20) + 1000];
    static const float rgb[STORE_JOB_TILE * STORE_JOB_TILE * 3];
    const struct pen_result result = {.rgb = rgb,
                                      .pixels = STORE_JOB_TILE * STORE_JOB_TILE,
                                      .stats = "{}",
                                      .layer = "beauty",
                                      .format = "png",
                                      .artefact = picture,
                                      .artefact_bytes = sizeof picture};
    struct pen_claim claim;
    bool found;
    return submit(store, number, st) &&
           pen_store_claim(store, "v", 60000, number, &claim, &found, st) && found &&
           pen_store_commit(store, &claim, &result, NULL, st);
}

typedef bool work_fn(struct pen_store *store, int number, struct pen_status *st);

/* How long a handle takes to write, the shortest of a few times: it waits for 10 s for a lock that
 * another one keeps, each time. */
static int64_t shortest_write_ms(struct pen_store *store)
{
    enum { TRIES = 3, SHORT_MS = 4000 };
    const struct pen_retention none = {0};
    struct pen_status st;
    int64_t took_ms = SHORT_MS;
    for (int i = 0; i < TRIES && took_ms >= SHORT_MS; i++) {
        const int64_t begun_ns = pen_clock_ns();
        store_must(pen_store_set_retention(store, &none, &st), &st, "another handle writes");
        took_ms = (pen_clock_ns() - begun_ns) / 1000000;
    }
    return took_ms;
}

/* A new handle runs out of memory in its first call; another handle must write afterwards. */
static bool blocks_nobody(work_fn *work, long n, struct pen_store *other, struct pen_status *st)
{
    struct pen_store *store = store_bed_handle(&bed);
    alloc_fail_after(n);
    bool ok = work(store, 1000 + (int)n, st);
    bool refused = alloc_succeed();
    ck_assert_msg(ok || (refused && st->code == PEN_NO_MEMORY), "allocation %ld: %s", n, st->msg);
    ck_assert(shortest_write_ms(other) < 4000 || !suite_timed());
    store_must(work(store, 1000000 + (int)n, st), st, "and so does this one");
    pen_store_close(store);
    return refused;
}

static void fail_every_allocation(work_fn *work)
{
    struct pen_status st = {0};
    long n = 0;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install(); /* its syncs are quick */
    store_bed_open(&bed);
    while (blocks_nobody(work, n, bed.store, &st))
        n += random_stride() * (random_all() || n < 100 ? 1 : 5);
    ck_assert_int_gt(n, 5);
    store_bed_close(&bed);
}

START_TEST(test_sqlite_memory__of_a_submit_keeps_no_lock)
{
    fail_every_allocation(submit);
}
END_TEST

START_TEST(test_sqlite_memory__of_a_claim_keeps_no_lock)
{
    fail_every_allocation(claim);
}
END_TEST

START_TEST(test_sqlite_memory__of_a_commit_keeps_no_lock)
{
    fail_every_allocation(commit);
}
END_TEST

START_TEST(test_sqlite_memory__of_a_list_keeps_no_lock)
{
    fail_every_allocation(list);
}
END_TEST

PEN_SUITE("store memory", test_sqlite_memory__of_a_submit_keeps_no_lock,
          test_sqlite_memory__of_a_claim_keeps_no_lock,
          test_sqlite_memory__of_a_commit_keeps_no_lock,
          test_sqlite_memory__of_a_list_keeps_no_lock)
