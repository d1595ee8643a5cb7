/* SPDX-License-Identifier: MIT */
/* How many transactions a worker makes: with a queue of small jobs they are most of its cost. */
#include <string.h>

#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;

enum { CLAIM, COMMIT, FAIL, RELEASE, HEARTBEAT, COMPRESS, OTHER, KINDS };
static const char *const names[OTHER] = {
    [CLAIM] = "claim",     [COMMIT] = "commit",       [FAIL] = "fail",
    [RELEASE] = "release", [HEARTBEAT] = "heartbeat", [COMPRESS] = "compress",
};

static struct {
    pthread_mutex_t lock;
    int calls[KINDS];        /* guarded by lock */
    int transactions[KINDS]; /* guarded by lock */
} seen = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void count(void *user, const struct pen_store_call *call)
{
    int kind = 0;
    (void)user;
    while (kind < OTHER && strcmp(names[kind], call->name) != 0)
        kind++;
    ck_assert(call->wall_ns >= 0 && call->cpu_ns >= 0);
    pthread_mutex_lock(&seen.lock);
    seen.calls[kind]++;
    seen.transactions[kind] += (int)call->transactions;
    pthread_mutex_unlock(&seen.lock);
}

static const struct pen_store_observer observer = {.called = count};

static void *work(void *user)
{
    struct jobs_bed *b = user;
    struct pen_worker_options options = {.store_url = b->bed.url,
                                         .id = "test:1:1",
                                         .threads = 2,
                                         .lease_ms = STORE_LEASE_MS, /* is never extended */
                                         .observer = &observer};
    struct pen_status st;
    return pen_worker_run(&options, &b->stop, &st) ? b : NULL;
}

static void start_observed(void)
{
    atomic_store(&bed.stop, false);
    ck_assert_int_eq(pthread_create(&bed.thread, NULL, work, &bed), 0);
    bed.working = true;
}

static const char small[] = ", \"render\": {\"width\": 40, \"height\": 30}";

START_TEST(test_traffic__small_job_is_one_claim_and_one_commit)
{
    char id[PEN_ID_BYTES];
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(small), id);
    start_observed();
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    ck_assert_int_eq(seen.transactions[CLAIM], 1);
    ck_assert_int_eq(seen.transactions[COMMIT], 1);
    ck_assert_int_eq(seen.calls[COMMIT], 1);
    ck_assert_int_eq(seen.transactions[FAIL] + seen.transactions[RELEASE], 0);
    ck_assert_int_eq(seen.transactions[HEARTBEAT], 0);
    ck_assert_int_eq(seen.calls[COMPRESS], 1);
    ck_assert_int_eq(seen.transactions[OTHER], 2); /* worker_seen and worker_gone */
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
    start_observed();
    for (int i = 0; i < JOBS; i++)
        ck_assert_int_eq(jobs_wait(&bed, id[i]), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    ck_assert_int_eq(seen.transactions[CLAIM], 1);
    ck_assert_int_eq(seen.transactions[COMMIT], JOBS);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_traffic__job_of_several_batches_is_a_commit_for_each)
{
    static const char several[] =
        ", \"render\": {\"width\": 150, \"height\": 110, \"samples_per_pixel\": 400, \"tile\": 8}";
    char id[PEN_ID_BYTES];
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(several), id);
    start_observed();
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
    jobs_worker_stop(&bed);
    ck_assert_int_gt(seen.calls[COMPRESS], 1);
    ck_assert_int_eq(seen.transactions[CLAIM], 1);
    ck_assert_int_eq(seen.transactions[COMMIT], seen.calls[COMPRESS] + 1); /* and the picture */
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("jobs traffic", test_traffic__small_job_is_one_claim_and_one_commit,
          test_traffic__claim_shares_the_transaction_of_the_commit_before,
          test_traffic__job_of_several_batches_is_a_commit_for_each)
