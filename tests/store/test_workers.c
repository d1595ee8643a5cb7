/* SPDX-License-Identifier: MIT */
/* The list of workers, workers whose process is gone, and their counters. */
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;

static bool count_held(void *user, const struct pen_worker_record *worker)
{
    int *held = user;
    ck_assert_int_eq(worker->threads, 2);
    held[worker->job_id ? 1 : 0]++;
    return true;
}

static void expect_held(int idle, int held)
{
    struct pen_status st;
    int count[2] = {0};
    store_must(pen_store_workers(bed.store, count_held, count, &st), &st, "workers");
    ck_assert_int_eq(count[0], idle);
    ck_assert_int_eq(count[1], held);
}

START_TEST(test_workers__are_listed_with_each_batch_that_they_hold)
{
    struct store_job job;
    struct pen_status st;
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 2);
    store_job_submit(bed.store, &job);
    store_worker_seen(bed.store, "v");
    store_worker_seen(bed.store, "w");
    store_worker_seen(bed.store, "w");
    expect_held(2, 0);
    store_claim(bed.store, "v");
    store_claim(bed.store, "v");
    expect_held(1, 2);
    store_must(pen_store_worker_gone(bed.store, "w", &st), &st, "gone");
    expect_held(0, 2);
    store_bed_close(&bed);
}
END_TEST

/* A worker's process that claims a batch, counts something and ends. */
static void lost_worker(void)
{
    store_bed_open(&bed);
    pen_store_count(PEN_COUNT_RAYS, 7);
    store_worker_seen(bed.store, "lost");
    store_claim(bed.store, "lost");
    _exit(0);
}

START_TEST(test_workers__whose_process_is_gone_give_batches_and_counters_back)
{
    struct pen_counters counters;
    struct store_job job;
    struct pen_status st;
    int opened;
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 1);
    store_job_submit(bed.store, &job);
    pen_store_close(bed.store);
    const pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0)
        lost_worker();
    ck_assert_int_eq(waitpid(child, NULL, 0), child);
    store_bed_open(&bed);
    store_worker_seen(bed.store, "lives");
    expect_held(1, 1);
    store_must(pen_store_release_gone(bed.store, &opened, &st), &st, "gone");
    ck_assert_int_eq(opened, 1);
    expect_held(1, 0);
    store_must(pen_store_counters(bed.store, &counters, &st), &st, "counters");
    ck_assert_uint_eq(counters.count[PEN_COUNT_RAYS], 7);
    ck_assert_uint_eq(counters.count[PEN_COUNT_LEASES_LOST], 1);
    store_bed_close(&bed);
}
END_TEST

/* A worker that is told to stop leaves the list and its numbers. */
START_TEST(test_workers__that_leave_have_their_counters_stay)
{
    struct pen_counters counters;
    struct pen_status st;
    store_bed_open(&bed);
    pen_store_close(bed.store);
    for (int i = 0; i < 2; i++) {
        const pid_t child = fork();
        ck_assert_int_ge(child, 0);
        if (child == 0) {
            store_bed_open(&bed);
            store_worker_seen(bed.store, "v");
            pen_store_count(PEN_COUNT_RAYS, 7);
            store_worker_seen(bed.store, "v");
            pen_store_count(PEN_COUNT_RAYS, 5);
            store_must(pen_store_worker_gone(bed.store, "v", &st), &st, "gone");
            store_must(pen_store_counters(bed.store, &counters, &st), &st, "counters");
            _exit((int)counters.count[PEN_COUNT_RAYS]);
        }
        int status;
        ck_assert_int_eq(waitpid(child, &status, 0), child);
        ck_assert_int_eq(WEXITSTATUS(status), 12 * (i + 1));
    }
    store_bed_open(&bed);
    expect_held(0, 0);
    pen_store_count(PEN_COUNT_RAYS, 1);
    store_must(pen_store_counters(bed.store, &counters, &st), &st, "counters");
    ck_assert_uint_eq(counters.count[PEN_COUNT_RAYS], 25);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store workers", test_workers__that_leave_have_their_counters_stay,
          test_workers__are_listed_with_each_batch_that_they_hold,
          test_workers__whose_process_is_gone_give_batches_and_counters_back)
