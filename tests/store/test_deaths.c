/* SPDX-License-Identifier: MIT */
/* Workers that end: which batches are quarantined, which workers get those, which job is charged.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;
static struct pen_claim blamed; /* the claim that the last error was made from */
static int64_t time_ms;

static char *death_error(void *user, const struct pen_claim *claim, int charges)
{
    char *text = malloc(64);
    ck_assert_ptr_nonnull(text);
    blamed = *claim;
    snprintf(text, 64, "{\"%s\": %d}", (const char *)user, charges);
    return text;
}

static char why[] = "why";

static int end_worker(const char *worker, enum pen_worker_end end)
{
    struct pen_status st;
    struct pen_worker_death death = {
        .worker = worker, .end = end, .error = death_error, .user = why};
    int opened = -1;
    store_must(pen_store_worker_ended(bed.store, &death, &opened, &st), &st, "worker ended");
    return opened;
}

static bool claim_any(const char *worker, struct pen_claim *claim)
{
    struct pen_status st;
    bool found = false;
    store_must(pen_store_claim(bed.store, worker, 60000, claim, &found, &st), &st, "claim");
    return found;
}

static void submit(struct store_job *job, int n, int batches, int max_attempts)
{
    store_job_init(job, n, 1, batches);
    job->job.max_attempts = max_attempts;
    store_job_submit(bed.store, job);
}

static int attempts(const struct store_job *in)
{
    struct pen_job_record job = store_job_get(bed.store, in->id);
    int count = job.attempts;
    pen_job_record_release(&job);
    return count;
}

static bool count_quarantined(void *user, const struct pen_batch_record *batch)
{
    *(int *)user += batch->quarantined;
    return true;
}

static int quarantined_batches(const struct store_job *in)
{
    struct pen_status st;
    int count = 0;
    store_must(pen_store_batches(bed.store, in->id, count_quarantined, &count, &st), &st,
               "batches");
    return count;
}

START_TEST(test_deaths__crash_over_one_job_is_charged_up_to_its_failure)
{
    struct store_job in;
    struct pen_claim claim;
    store_bed_open(&bed);
    submit(&in, 1, 3, 3);
    for (int charges = 1; charges <= 3; charges++) {
        ck_assert_int_eq(attempts(&in), charges == 1 ? 0 : charges);
        claim = store_claim(bed.store, "w");
        ck_assert_int_eq(claim.first_tile, 0);
        ck_assert_int_eq(end_worker("w", PEN_WORKER_CRASHED), charges < 3);
        store_audit_clean(bed.store);
    }
    struct pen_job_record job = store_job_get(bed.store, in.id);
    ck_assert_int_eq(job.state, PEN_JOB_FAILED);
    ck_assert_str_eq(job.error, "{\"why\": 3}");
    ck_assert_int_eq(job.attempts, 3);
    pen_job_record_release(&job);
    ck_assert_int_eq(blamed.batch, claim.batch);
    ck_assert_int_eq(blamed.attempt, claim.attempt);
    ck_assert_str_eq(blamed.job_id, in.id);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    ck_assert(!claim_any("w", &claim));
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_deaths__other_ends_are_not_charged)
{
    struct store_job in;
    struct pen_status st;
    int opened;
    store_bed_open(&bed);
    submit(&in, 1, 2, 1);
    for (int i = 0; i < 4; i++) {
        store_claim(bed.store, "w");
        ck_assert_int_eq(end_worker("w", PEN_WORKER_LEFT), 1);
        ck_assert_int_eq(quarantined_batches(&in), 0);
    }
    for (int i = 0; i < 4; i++) {
        store_claim(bed.store, "w");
        ck_assert_int_eq(end_worker("w", PEN_WORKER_DIED), 1);
        ck_assert_int_eq(quarantined_batches(&in), 1);
        store_claim(bed.store, "w");
        store_must(pen_store_expire_leases(bed.store, "w", &opened, &st), &st, "expire");
        ck_assert_int_eq(opened, 1);
        ck_assert_int_eq(attempts(&in), 1);
    }
    ck_assert_int_eq(end_worker("nobody", PEN_WORKER_CRASHED), 0);
    store_work_off(bed.store, "w");
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(quarantined_batches(&in), 0);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_deaths__crash_over_two_jobs_charges_neither_and_quarantined_batches_are_tried_alone)
{
    struct store_job bad, good, other;
    struct pen_claim one, two, claim;
    store_bed_open(&bed);
    submit(&bad, 1, 1, 1);
    submit(&good, 2, 1, 1);
    submit(&other, 3, 4, 1);
    one = store_claim(bed.store, "w");
    two = store_claim(bed.store, "w");
    ck_assert_str_eq(two.job_id, good.id);
    ck_assert_int_eq(end_worker("w", PEN_WORKER_CRASHED), 2);
    ck_assert_int_eq(quarantined_batches(&bad) + quarantined_batches(&good), 2);

    /* A worker with a quarantined batch holds nothing else. */
    one = store_claim(bed.store, "w");
    ck_assert_str_eq(one.job_id, bad.id);
    ck_assert(!claim_any("w", &claim));
    two = store_claim(bed.store, "v");
    ck_assert_str_eq(two.job_id, good.id);
    ck_assert(!claim_any("v", &claim));
    claim = store_claim(bed.store, "u");
    ck_assert_str_eq(claim.job_id, other.id);
    store_audit_clean(bed.store);

    /* A worker that holds a batch gets no quarantined one, but the next of the others. */
    end_worker("v", PEN_WORKER_LEFT);
    claim = store_claim(bed.store, "u");
    ck_assert_str_eq(claim.job_id, other.id);

    ck_assert_int_eq(end_worker("w", PEN_WORKER_CRASHED), 0);
    ck_assert_int_eq(store_job_state(bed.store, bad.id), PEN_JOB_FAILED);
    store_work_off(bed.store, "w");
    ck_assert_int_eq(store_job_state(bed.store, good.id), PEN_JOB_SUCCEEDED);
    end_worker("u", PEN_WORKER_LEFT);
    store_work_off(bed.store, "w");
    ck_assert_int_eq(store_job_state(bed.store, other.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_deaths__any_commit_of_the_job_takes_its_charges_back)
{
    struct store_job in;
    struct pen_claim bad, good;
    store_bed_open(&bed);
    submit(&in, 1, 3, 2);
    bad = store_claim(bed.store, "w");
    end_worker("w", PEN_WORKER_CRASHED);
    ck_assert_int_eq(attempts(&in), 2);
    bad = store_claim(bed.store, "w");
    good = store_claim(bed.store, "v");
    ck_assert_int_ne(good.batch, bad.batch);
    ck_assert_int_eq(store_commit(bed.store, &good), PEN_OK);
    ck_assert_int_eq(attempts(&in), 1);
    ck_assert_int_eq(end_worker("w", PEN_WORKER_CRASHED), 1);
    ck_assert_int_eq(attempts(&in), 2);
    bad = store_claim(bed.store, "w");
    ck_assert_int_eq(end_worker("w", PEN_WORKER_CRASHED), 0);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_FAILED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_deaths__job_that_keeps_losing_workers_is_paused_while_others_are_open)
{
    struct store_job bad, good;
    struct pen_claim claim;
    time_ms = INT64_C(1800000000000);
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &time_ms);
    submit(&bad, 1, 1, 10);
    claim = store_claim(bed.store, "w");
    end_worker("w", PEN_WORKER_DIED);
    submit(&good, 2, 4, 3);
    claim = store_claim(bed.store, "w"); /* the first death does not pause the job */
    ck_assert_str_eq(claim.job_id, bad.id);
    end_worker("w", PEN_WORKER_DIED);
    claim = store_claim(bed.store, "w");
    ck_assert_str_eq(claim.job_id, good.id);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    time_ms += 600;
    claim = store_claim(bed.store, "w"); /* the pause is over */
    ck_assert_str_eq(claim.job_id, bad.id);
    end_worker("w", PEN_WORKER_DIED);
    for (int i = 0; i < 4; i++) {
        claim = store_claim(bed.store, "w");
        ck_assert_str_eq(claim.job_id, good.id);
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    }
    claim = store_claim(bed.store, "w"); /* a paused job goes on when no other job is open */
    ck_assert_str_eq(claim.job_id, bad.id);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_bed_close(&bed);
}
END_TEST

static bool set_back(const struct pen_claim *claim, bool always)
{
    struct pen_status st;
    bool done = false;
    store_must(pen_store_set_back(bed.store, claim, "{\"status\": 507}", always, &done, &st), &st,
               "set back");
    return done;
}

/* A batch whose result finds no space: without a charge or a quarantine, its job is paused for
 * longer and longer, and fails in the end, but not within ten minutes. */
START_TEST(test_deaths__batch_that_is_set_back_lets_others_go_first)
{
    enum { TRIES = 16 };
    struct store_job large, other;
    struct pen_claim claim;
    time_ms = INT64_C(1800000000000);
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &time_ms);
    submit(&large, 1, 1, 1);
    claim = store_claim(bed.store, "w");
    ck_assert(!set_back(&claim, false)); /* nobody waits */
    submit(&other, 2, 2 * TRIES, 1);
    ck_assert(set_back(&claim, false));
    ck_assert(set_back(&claim, false)); /* it is no longer held: nothing happens */
    for (int i = 1; i < 2 * TRIES; i++) {
        claim = store_claim(bed.store, "w");
        ck_assert_str_eq(claim.job_id, other.id);
        ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
        time_ms += 500LL << (i < 7 ? i - 1 : 7);
        ck_assert(claim_any("w", &claim));
        if (i == 2 * TRIES - 1 || strcmp(claim.job_id, large.id) != 0)
            break;
        ck_assert_int_eq(attempts(&large), 1);
        ck_assert(set_back(&claim, false));
        if (store_job_state(bed.store, large.id) == PEN_JOB_FAILED) {
            ck_assert_int_ge(i, TRIES - 1);
            break;
        }
    }
    struct pen_job_record job = store_job_get(bed.store, large.id);
    ck_assert_int_eq(job.state, PEN_JOB_FAILED);
    ck_assert_str_eq(job.error, "{\"status\": 507}");
    ck_assert_int_ge(job.finished_ms - job.started_ms, 600000);
    pen_job_record_release(&job);
    store_work_off(bed.store, "w");
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_deaths__store_of_the_first_schema_is_migrated)
{
    struct store_job in;
    store_bed_open(&bed);
    submit(&in, 1, 3, 3);
    store_claim(bed.store, "w");
    pen_store_close(bed.store);
    store_downgrade(bed.url, 1);
    bed.store = store_bed_handle(&bed);
    ck_assert_int_eq(end_worker("w", PEN_WORKER_CRASHED), 1);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 4);
    ck_assert_int_eq(store_job_state(bed.store, in.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store deaths", test_deaths__crash_over_one_job_is_charged_up_to_its_failure,
          test_deaths__other_ends_are_not_charged,
          test_deaths__crash_over_two_jobs_charges_neither_and_quarantined_batches_are_tried_alone,
          test_deaths__any_commit_of_the_job_takes_its_charges_back,
          test_deaths__batch_that_is_set_back_lets_others_go_first,
          test_deaths__job_that_keeps_losing_workers_is_paused_while_others_are_open,
          test_deaths__store_of_the_first_schema_is_migrated)
