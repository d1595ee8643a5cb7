/* SPDX-License-Identifier: MIT */
/* A clock that jumps. Stored times that lie in its future: turns, waiting, leases and pauses last
 * no longer for that. Durations of jobs: they are those of the boot. */
#include <string.h>

#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job[3];
static int64_t time_ms;

enum { HOUR_MS = 3600000, DAY_MS = 24 * HOUR_MS };

static void open_bed(void)
{
    time_ms = INT64_C(1800000000000);
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &time_ms);
}

/* Number n is the job's place, too. */
static void submit(int n, const char *client, int priority)
{
    store_job_init(&job[n], n, 1, 1);
    job[n].job.client = client;
    job[n].job.priority = priority;
    store_job_submit(bed.store, &job[n]);
}

static struct pen_claim claim_of(int n)
{
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_str_eq(claim.job_id, job[n].id);
    return claim;
}

static bool outranked(const struct pen_claim *claim)
{
    struct pen_status st;
    bool yes;
    store_must(pen_store_outranked(bed.store, claim, &yes, &st), &st, "outranked");
    return yes;
}

static void extend(struct pen_claim *claim)
{
    struct pen_status st;
    bool held;
    store_must(pen_store_heartbeat(bed.store, claim, STORE_LEASE_MS, &held, &st), &st, "heartbeat");
    ck_assert(held);
}

static int expire(void)
{
    struct pen_status st;
    int opened;
    store_must(pen_store_expire_leases(bed.store, NULL, &opened, &st), &st, "expire");
    return opened;
}

START_TEST(test_times__turn_from_the_future_is_over)
{
    struct pen_status st;
    open_bed();
    submit(0, "10.0.0.1", 0);
    submit(1, "10.0.0.2", 0);
    struct pen_claim claim = claim_of(0);
    ck_assert(!outranked(&claim));
    time_ms -= DAY_MS;
    ck_assert(outranked(&claim));
    claim.spent_us = 1000000;
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    claim = claim_of(1);
    ck_assert(!outranked(&claim));
    time_ms += 60000;
    ck_assert(outranked(&claim));
    store_bed_close(&bed);
}
END_TEST

/* From when the clock is set back on, also while a worker does nothing but extend a lease. */
START_TEST(test_times__waiting_goes_on)
{
    for (int held = 0; held < 2; held++) {
        struct pen_claim claim = {0};
        open_bed();
        submit(0, "10.0.0.1", 1);
        submit(1, "10.0.0.2", 0);
        if (held)
            claim = claim_of(0);
        time_ms -= DAY_MS;
        if (held)
            extend(&claim);
        else
            ck_assert_int_eq(expire(), 0);
        time_ms += 119000;
        ck_assert(!held || !outranked(&claim));
        time_ms += 2000;
        ck_assert(!held || outranked(&claim));
        if (!held)
            claim_of(1);
        store_bed_close(&bed);
    }
}
END_TEST

static bool is_seen_now(void *user, const struct pen_worker_record *worker)
{
    *(int *)user += worker->seen_ms == time_ms;
    return true;
}

START_TEST(test_times__lease_lasts_no_longer_than_a_lease)
{
    struct pen_status st;
    int seen = 0;
    open_bed();
    submit(0, "10.0.0.1", 0);
    store_worker_seen(bed.store, "w");
    struct pen_claim claim = claim_of(0);
    time_ms -= DAY_MS;
    ck_assert_int_eq(expire(), 0); /* its worker may live */
    store_must(pen_store_workers(bed.store, is_seen_now, &seen, &st), &st, "workers");
    ck_assert_int_eq(seen, 1);
    time_ms += STORE_LEASE_MS / 2;
    ck_assert_int_eq(expire(), 0);
    extend(&claim);
    time_ms -= DAY_MS;
    extend(&claim);
    time_ms += STORE_LEASE_MS - 1000;
    ck_assert_int_eq(expire(), 0);
    time_ms += 2000;
    ck_assert_int_eq(expire(), 1);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_times__pause_from_the_future_is_over)
{
    struct pen_status st;
    for (int back = 0; back < 2; back++) {
        bool done;
        open_bed();
        submit(0, "10.0.0.1", 1);
        struct pen_claim claim = claim_of(0);
        store_must(pen_store_set_back(bed.store, &claim, "{}", true, &done, &st), &st, "set back");
        ck_assert(done);
        submit(1, "10.0.0.2", 0);
        time_ms -= back ? DAY_MS : 0;
        claim_of(back ? 0 : 1);
        store_bed_close(&bed);
    }
}
END_TEST

enum { SECOND_US = 1000000 };

static struct pen_job_record record_of(int n)
{
    struct pen_job_record record;
    struct pen_status st;
    store_must(pen_store_job(bed.store, job[n].id, &record, &st), &st, "job");
    pen_job_record_release(&record); /* its numbers stay */
    return record;
}

static void submit_now(void)
{
    open_bed();
    store_job_init(&job[0], 0, 1, 2);
    job[0].job.created_ms = time_ms;
    job[0].job.created = pen_clock_moment();
    store_job_submit(bed.store, &job[0]);
}

static void commit(const struct pen_claim *claim)
{
    ck_assert_int_eq(store_commit(bed.store, claim), PEN_OK);
}

/* The clock jumps while the job waits and while it runs; the whole takes far less than an hour. */
START_TEST(test_times__durations_do_not_follow_a_clock_that_jumps)
{
    static const int64_t jumps_ms[] = {-2 * HOUR_MS, 3 * (int64_t)DAY_MS};
    for (int i = 0; i < 2; i++) {
        submit_now();
        time_ms += jumps_ms[i];
        struct pen_claim claim = store_claim(bed.store, "w");
        time_ms += jumps_ms[i];
        commit(&claim);
        time_ms += jumps_ms[i];
        store_work_off(bed.store, "w");
        const struct pen_job_record record = record_of(0);
        ck_assert_int_eq(record.state, PEN_JOB_SUCCEEDED);
        ck_assert_int_ge(record.queue_us, 0);
        ck_assert_int_ge(record.told_elapsed_us, record.queue_us);
        ck_assert_int_gt(record.elapsed_us, record.queue_us);
        ck_assert_int_lt(record.elapsed_us, (int64_t)HOUR_MS * 1000);
        store_bed_close(&bed);
    }
}
END_TEST

/* Between two boots five seconds pass, or the clock is set back: then what was measured stays. */
START_TEST(test_times__durations_over_two_boots_follow_the_clock_but_not_back)
{
    for (int back = 0; back < 2; back++) {
        submit_now();
        struct pen_claim claim = store_claim(bed.store, "w");
        store_run_sql(&bed, "UPDATE job SET moment_boot = moment_boot / 2, elapsed_us = 7000000",
                      NULL, 0);
        time_ms += back ? -HOUR_MS : 5000;
        commit(&claim);
        const int64_t least_us = (back ? 7 : 12) * (int64_t)SECOND_US;
        ck_assert_int_eq(record_of(0).elapsed_us, least_us);
        time_ms += HOUR_MS; /* in this boot again */
        store_work_off(bed.store, "w");
        ck_assert_int_gt(record_of(0).elapsed_us, least_us);
        ck_assert_int_lt(record_of(0).elapsed_us, (int64_t)HOUR_MS * 1000);
        store_bed_close(&bed);
    }
}
END_TEST

/* What is rendered after a restart counts from the first claim on, also if the clock was set back.
 */
START_TEST(test_times__measuring_begins_with_the_first_claim_of_a_boot)
{
    submit_now();
    struct pen_claim claim = store_claim(bed.store, "w");
    store_run_sql(&bed, "UPDATE job SET moment_boot = moment_boot / 2, elapsed_us = 7000000", NULL,
                  0);
    time_ms -= HOUR_MS;
    struct pen_claim second = store_claim(bed.store, "v");
    time_ms += HOUR_MS;
    commit(&second);
    commit(&claim);
    ck_assert_int_gt(record_of(0).elapsed_us, 7 * SECOND_US);
    ck_assert_int_lt(record_of(0).elapsed_us, (int64_t)HOUR_MS * 1000);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("clocks that jump", test_times__durations_do_not_follow_a_clock_that_jumps,
          test_times__durations_over_two_boots_follow_the_clock_but_not_back,
          test_times__measuring_begins_with_the_first_claim_of_a_boot,
          test_times__turn_from_the_future_is_over, test_times__waiting_goes_on,
          test_times__lease_lasts_no_longer_than_a_lease, test_times__pause_from_the_future_is_over)
