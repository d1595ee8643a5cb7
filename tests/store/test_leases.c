/* SPDX-License-Identifier: MIT */
/* Leases that end, lost workers, charges and quarantine. */
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/suite.h"

enum { LEASE_MS = 10000 };

static struct store_bed bed;
static struct store_job job;
static int64_t time_ms, serial;

static void begin(int batches)
{
    store_bed_open(&bed);
    time_ms = 1000000;
    store_bed_set_clock(&bed, &time_ms);
    store_job_init(&job, 1, 1, batches);
    store_job_submit(bed.store, &job);
}

static bool try_claim(const char *worker, struct pen_claim *claim)
{
    struct pen_status st;
    bool found;
    store_must(pen_store_claim(bed.store, worker, LEASE_MS, ++serial, claim, &found, &st), &st,
               "claim");
    return found;
}

static int expire(void)
{
    struct pen_status st;
    int opened;
    store_must(pen_store_expire_leases(bed.store, &opened, &st), &st, "expire");
    return opened;
}

static char *make_error(void *user, const struct pen_claim *claim, int charges)
{
    *(int *)user = charges;
    ck_assert_str_eq(claim->job_id, job.id);
    return strdup("{\"title\": \"crash\"}");
}

static int end_worker(const char *worker, enum pen_worker_end end, int *charges)
{
    struct pen_status st;
    const struct pen_worker_death death = {worker, end, make_error, charges};
    int opened;
    store_must(pen_store_worker_ended(bed.store, &death, &opened, &st), &st, "ended");
    return opened;
}

START_TEST(test_leases__ended_are_opened_and_quarantined)
{
    struct pen_claim first, second, none;
    begin(3);
    ck_assert(try_claim("v", &first));
    time_ms += LEASE_MS - 1;
    ck_assert_int_eq(expire(), 0);
    time_ms += 1;
    ck_assert_int_eq(expire(), 1);
    ck_assert_int_eq(store_commit(bed.store, &first), PEN_STALE);
    /* A worker that holds a batch is not given the quarantined one, and nothing beside it. */
    ck_assert(try_claim("w", &second));
    ck_assert(try_claim("w", &none));
    ck_assert_int_ne(second.batch, first.batch);
    ck_assert_int_ne(none.batch, first.batch);
    ck_assert(!try_claim("w", &none));
    ck_assert(try_claim("x", &second));
    ck_assert_int_eq(second.batch, first.batch);
    ck_assert_int_eq(second.attempt, 2);
    ck_assert_int_eq(store_commit(bed.store, &second), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__a_clock_set_back_lets_them_begin_now)
{
    struct pen_claim claim;
    begin(1);
    store_worker_seen(bed.store, "v");
    struct pen_status st;
    const struct pen_worker_new worker = {.id = "v", .threads = 1, .lease_ms = LEASE_MS};
    store_must(pen_store_worker_seen(bed.store, &worker, &st), &st, "seen");
    ck_assert(try_claim("v", &claim));
    time_ms -= 500000;
    ck_assert_int_eq(expire(), 0);
    time_ms += LEASE_MS;
    ck_assert_int_eq(expire(), 1);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__a_heartbeat_extends_after_a_third_and_adds_time)
{
    struct pen_claim claim;
    struct pen_status st;
    bool held;
    begin(1);
    ck_assert(try_claim("v", &claim));
    time_ms += LEASE_MS / 2;
    claim.spent_us = 5000;
    store_must(pen_store_heartbeat(bed.store, &claim, LEASE_MS, &held, &st), &st, "heartbeat");
    ck_assert(held);
    time_ms += LEASE_MS - 1;
    ck_assert_int_eq(expire(), 0);
    time_ms += 1;
    ck_assert_int_eq(expire(), 1);
    store_must(pen_store_heartbeat(bed.store, &claim, LEASE_MS, &held, &st), &st, "heartbeat");
    ck_assert(!held);
    ck_assert(try_claim("v", &claim));
    ck_assert_int_eq(claim.job_spent_us, 5000);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__crashes_of_one_job_are_charged_until_it_fails)
{
    struct pen_claim claim;
    int charges = 0;
    begin(2);
    for (int i = 1; i <= 3; i++) {
        struct pen_job_record record = store_job_get(bed.store, job.id);
        ck_assert_int_eq(record.attempts, i == 1 ? 0 : i);
        pen_job_record_release(&record);
        ck_assert(try_claim("v", &claim));
        ck_assert_int_eq(end_worker("v", PEN_WORKER_CRASHED, &charges), i < 3 ? 1 : 0);
    }
    ck_assert_int_eq(charges, 3);
    struct pen_job_record record = store_job_get(bed.store, job.id);
    ck_assert_int_eq(record.state, PEN_JOB_FAILED);
    ck_assert_int_eq(record.attempts, 3);
    ck_assert_str_eq(record.error, "{\"title\": \"crash\"}");
    pen_job_record_release(&record);
    ck_assert(!try_claim("v", &claim));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__a_crash_with_batches_of_two_jobs_is_not_charged)
{
    struct pen_claim claim;
    struct store_job other;
    int charges = 0;
    begin(1);
    store_job_init(&other, 2, 1, 1);
    store_job_submit(bed.store, &other);
    ck_assert(try_claim("v", &claim));
    ck_assert(try_claim("v", &claim));
    ck_assert_int_eq(end_worker("v", PEN_WORKER_CRASHED, &charges), 2);
    struct pen_job_record record = store_job_get(bed.store, job.id);
    ck_assert_int_eq(record.attempts, 1);
    pen_job_record_release(&record);
    record = store_job_get(bed.store, other.id);
    ck_assert_int_eq(record.attempts, 1);
    pen_job_record_release(&record);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__a_second_loss_lets_the_job_come_after_others)
{
    struct pen_claim claim;
    struct store_job other;
    begin(1);
    for (int i = 0; i < 2; i++) {
        ck_assert(try_claim("v", &claim));
        ck_assert_int_eq(end_worker("v", PEN_WORKER_DIED, NULL), 1);
    }
    store_job_init(&other, 2, 1, 1);
    store_job_submit(bed.store, &other);
    ck_assert(try_claim("v", &claim));
    ck_assert_str_eq(claim.job_id, other.id);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert(try_claim("v", &claim)); /* nothing else waits */
    ck_assert_str_eq(claim.job_id, job.id);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_leases__a_worker_that_left_leaves_no_quarantine)
{
    struct pen_claim claim;
    begin(2);
    ck_assert(try_claim("v", &claim));
    ck_assert_int_eq(end_worker("v", PEN_WORKER_LEFT, NULL), 1);
    ck_assert(try_claim("w", &claim));
    ck_assert(try_claim("w", &claim));
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store leases", test_leases__ended_are_opened_and_quarantined,
          test_leases__a_clock_set_back_lets_them_begin_now,
          test_leases__a_heartbeat_extends_after_a_third_and_adds_time,
          test_leases__crashes_of_one_job_are_charged_until_it_fails,
          test_leases__a_crash_with_batches_of_two_jobs_is_not_charged,
          test_leases__a_second_loss_lets_the_job_come_after_others,
          test_leases__a_worker_that_left_leaves_no_quarantine)
