/* SPDX-License-Identifier: MIT */
/* The n-th allocation fails, and all after it, for every n unless a test says otherwise. A handle
 * that has run out of memory keeps no lock that others wait for, and running out of memory is no
 * fault of the store. */
#include <errno.h>
#include <unistd.h>

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
    (void)number;
    return pen_store_claim(store, "w", 60000, &claim, &found, st);
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

typedef bool work_fn(struct pen_store *store, int number, struct pen_status *st);

/* How long a handle takes to write, the shortest of a few times: it waits for 5 s for a lock that
 * another one keeps, each time. */
static int64_t shortest_write_ms(struct pen_store *store)
{
    enum { TRIES = 3, SHORT_MS = 4000 };
    struct pen_status st;
    int64_t took_ms = SHORT_MS;
    for (int i = 0; i < TRIES && took_ms >= SHORT_MS; i++) {
        const int64_t begun_ns = pen_clock_ns();
        store_must(pen_store_probe(store, &st), &st, "another handle writes");
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
    store_must(work(store, 2000 + (int)n, st), st, "and so does this one");
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

START_TEST(test_memory__of_a_submit_keeps_no_lock)
{
    fail_every_allocation(submit);
}
END_TEST

START_TEST(test_memory__of_a_claim_keeps_no_lock)
{
    fail_every_allocation(claim);
}
END_TEST

START_TEST(test_memory__of_a_list_keeps_no_lock)
{
    fail_every_allocation(list);
}
END_TEST

/* Makes a sync fail: the store has a fault until a call recovers it. */
static void make_faulty(void)
{
    struct pen_status st;
    struct fault_plan plan = {.calls = FAULT_SYNC, .mode = FAULT_FROM, .n = 1, .error = EIO};
    faults_arm(&plan);
    ck_assert(!pen_store_probe(bed.store, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_int_gt(faults_disarm(), 0);
}

/* A recovery runs out of memory at its n-th allocation. The next one must not wait half a second,
 * as it would after a fault of the disk, unless this one took long (125 ms). */
static bool recovers_next(long n, bool *failed)
{
    struct pen_status st = {0};
    make_faulty();
    int64_t begun_ns = pen_clock_ns();
    alloc_fail_after(n);
    *failed = !pen_store_probe(bed.store, &st);
    bool refused = alloc_succeed();
    int64_t took_ms = (pen_clock_ns() - begun_ns) / 1000000;
    ck_assert_msg(!*failed || (refused && st.code == PEN_NO_MEMORY), "allocation %ld: %s", n,
                  st.msg);
    while (!pen_store_probe(bed.store, &st)) {
        ck_assert_msg(took_ms >= 100, "allocation %ld, next: %s", n, st.msg);
        usleep(20000);
    }
    return refused;
}

START_TEST(test_memory__of_a_recovery_does_not_delay_the_next)
{
    bool failed;
    long n = 0, failures = 0;
    pen_log_set_level(PEN_LOG_ERROR + 1);
    faults_install();
    store_bed_open(&bed);
    while (recovers_next(n, &failed)) {
        failures += failed;
        n += random_stride() *
             (n < random_some(200, 40) ? 1 : random_some(41, 211)); /* one check makes thousands */
    }
    ck_assert_int_gt(failures, random_some(200, 40));
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store memory", test_memory__of_a_submit_keeps_no_lock,
          test_memory__of_a_claim_keeps_no_lock, test_memory__of_a_list_keeps_no_lock,
          test_memory__of_a_recovery_does_not_delay_the_next)
