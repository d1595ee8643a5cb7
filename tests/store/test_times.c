/* SPDX-License-Identifier: MIT */
/* A clock that is set back, which leaves stored times that lie in its future: turns, waiting,
 * leases and pauses last no longer for that. */
#include <string.h>

#include "support/store.h"
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

PEN_SUITE("times in the future", test_times__turn_from_the_future_is_over,
          test_times__waiting_goes_on, test_times__lease_lasts_no_longer_than_a_lease,
          test_times__pause_from_the_future_is_over)
