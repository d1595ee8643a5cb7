/* SPDX-License-Identifier: MIT */
/* How many transactions a worker makes: with a queue of small jobs they are most of its cost. */
#include <pthread.h>

#include "base/clock.h"
#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;

/* Write transactions of this process so far. */
static uint64_t writes(void)
{
    const int first = PEN_COUNT_TIMINGS + PEN_TIMING_WRITE * (PEN_TIMING_BUCKETS + 2);
    struct pen_counters counters;
    struct pen_status st;
    uint64_t sum = 0;
    store_must(pen_store_counters(bed.bed.store, &counters, &st), &st, "counters");
    for (int i = 0; i <= PEN_TIMING_BUCKETS; i++)
        sum += counters.count[first + i];
    return sum;
}

static uint64_t commits(void)
{
    struct pen_counters counters;
    struct pen_status st;
    store_must(pen_store_counters(bed.bed.store, &counters, &st), &st, "counters");
    return counters.count[PEN_COUNT_COMMIT_OK];
}

static void *work(void *user)
{
    struct jobs_bed *b = user;
    struct pen_worker_options options = {.store_url = b->bed.url,
                                         .id = "test:1:1",
                                         .threads = 2,
                                         .housekeeping_ms = 3600000,
                                         .lease_ms = STORE_LEASE_MS}; /* is never extended */
    struct pen_status st;
    return pen_worker_run(&options, &b->stop, &st) ? b : NULL;
}

/* Works the jobs off; returns the write transactions that this took. */
static uint64_t work_off(char id[][PEN_ID_BYTES], int count)
{
    const uint64_t before = writes();
    atomic_store(&bed.stop, false);
    ck_assert_int_eq(pthread_create(&bed.thread, NULL, work, &bed), 0);
    bed.working = true;
    for (int i = 0; i < count; i++)
        ck_assert_int_eq(jobs_wait(&bed, id[i]), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    return writes() - before;
}

/* Its row when it comes, when it knows its rate, and when it goes. */
enum { OF_WORKER = 3 };

static const char small[] = ", \"render\": {\"width\": 40, \"height\": 30}";

START_TEST(test_traffic__small_job_is_one_claim_and_one_commit)
{
    char id[1][PEN_ID_BYTES];
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(small), id[0]);
    ck_assert_uint_eq(work_off(id, 1), OF_WORKER + 2);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_traffic__claim_shares_the_transaction_of_the_commit_before)
{
    enum { JOBS = 12 };
    char id[JOBS][PEN_ID_BYTES];
    jobs_bed_open(&bed);
    for (int i = 0; i < JOBS; i++)
        jobs_submit(&bed, jobs_scene(small), id[i]);
    ck_assert_uint_eq(work_off(id, JOBS), OF_WORKER + 1 + JOBS);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_traffic__job_of_several_batches_is_a_commit_for_each)
{
    static const char several[] =
        ", \"render\": {\"width\": 150, \"height\": 110, \"samples_per_pixel\": 400, \"tile\": 8}";
    char id[1][PEN_ID_BYTES];
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(several), id[0]);
    const int64_t begun = pen_clock_ns();
    const uint64_t before = commits(), took = work_off(id, 1), made = commits() - before;
    const uint64_t seconds = (uint64_t)((pen_clock_ns() - begun) / 1000000000);
    ck_assert_uint_gt(made, 2); /* batches, and the picture */
    ck_assert_uint_ge(took, OF_WORKER + 1 + made);
    ck_assert_uint_le(took, OF_WORKER + 3 + made + 2 * seconds); /* and what heartbeats told */
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("jobs traffic", test_traffic__small_job_is_one_claim_and_one_commit,
          test_traffic__claim_shares_the_transaction_of_the_commit_before,
          test_traffic__job_of_several_batches_is_a_commit_for_each)
