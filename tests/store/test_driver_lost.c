/* SPDX-License-Identifier: MIT */
/* Contract of a driver: leases that are lost, by their time or by their worker, and what is charged
 * for it; and the store's clock, by which leases run out. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "support/driver.h"

static struct driver_bed bed;

/* Three jobs of two batches each. Worker a holds both of the first until 1000, b one of the second
 * until 2000 and one of the third until 3000. */
static struct driver_job job[3];

static void lease_some(int kind)
{
    driver_bed_open(&bed, kind);
    for (int i = 0; i < 3; i++) {
        struct store_job in;
        store_job_init(&in, 1 + i, 1, 2);
        in.job.max_attempts = 5 + i;
        job[i] = driver_submit(bed.driver, &in);
    }
    driver_lease(bed.driver, job[0].batch[0], 1, "a", 1000);
    driver_lease(bed.driver, job[0].batch[1], 1, "a", 1000);
    driver_lease(bed.driver, job[1].batch[0], 1, "b", 2000);
    driver_lease(bed.driver, job[2].batch[0], 1, "b", 3000);
}

static bool any_lost(const char *worker, int64_t before_ms)
{
    struct pen_lost lost = {worker, before_ms};
    bool any = false;
    DRIVER_DO(bed.driver, any_lost, &lost, &any);
    return any;
}

static int open_lost(const char *worker, int64_t before_ms, bool quarantine)
{
    struct pen_lost lost = {worker, before_ms};
    int opened = -1;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, open_lost, &lost, quarantine, &opened);
    DRIVER_RUN(bed.driver, commit);
    return opened;
}

static enum pen_batch_state state_of(int64_t batch)
{
    return driver_batch_row(bed.driver, batch).state;
}

START_TEST(test_driver_lost__leases_run_out_at_their_time)
{
    lease_some(_i);
    ck_assert(!any_lost(NULL, 1000)); /* it lasts until then */
    ck_assert(any_lost(NULL, 1001));
    ck_assert_int_eq(open_lost(NULL, 1000, true), 0);
    ck_assert_int_eq(state_of(job[0].batch[0]), PEN_BATCH_LEASED);
    ck_assert_int_eq(open_lost(NULL, 2001, true), 3);
    ck_assert_int_eq(state_of(job[0].batch[0]), PEN_BATCH_OPEN);
    ck_assert_int_eq(state_of(job[0].batch[1]), PEN_BATCH_OPEN);
    ck_assert_int_eq(state_of(job[1].batch[0]), PEN_BATCH_OPEN);
    ck_assert_int_eq(state_of(job[2].batch[0]), PEN_BATCH_LEASED);
    ck_assert(!any_lost(NULL, 2001));
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_lost__leases_of_a_worker_are_lost_with_it)
{
    lease_some(_i);
    ck_assert(any_lost("b", INT64_MIN));
    ck_assert(!any_lost("c", INT64_MIN));
    ck_assert(!any_lost(NULL, INT64_MIN));
    ck_assert_int_eq(open_lost("b", INT64_MIN, true), 2);
    ck_assert_int_eq(state_of(job[0].batch[0]), PEN_BATCH_LEASED);
    ck_assert_int_eq(state_of(job[1].batch[0]), PEN_BATCH_OPEN);
    ck_assert_int_eq(state_of(job[2].batch[0]), PEN_BATCH_OPEN);
    ck_assert(!any_lost("b", INT64_MIN));
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_lost__leases_of_a_worker_and_those_of_their_time_are_opened_together)
{
    lease_some(_i);
    ck_assert(any_lost("c", 1001));
    ck_assert_int_eq(open_lost("b", 1001, false), 4);
    driver_bed_close(&bed);
}
END_TEST

/* Whether a batch is quarantined, as the list of its job's batches has it. */
static bool is_quarantined(int64_t in_job, int index)
{
    struct pen_batch_record rows[DRIVER_BATCHES];
    struct pen_arena *arena = pen_arena_new(0);
    int count = 0;
    DRIVER_DO(bed.driver, batch_page, in_job, 0, arena, rows, DRIVER_BATCHES, &count);
    ck_assert_int_gt(count, index);
    bool quarantined = rows[index].quarantined;
    pen_arena_free(arena);
    return quarantined;
}

START_TEST(test_driver_lost__quarantine_lasts_until_the_batch_is_done)
{
    bool changed = false;
    lease_some(_i);
    ck_assert_int_eq(open_lost("a", INT64_MIN, false), 2);
    ck_assert(!is_quarantined(job[0].number, 0));
    driver_lease(bed.driver, job[0].batch[0], 2, "a", 1000);
    ck_assert_int_eq(open_lost("a", INT64_MIN, true), 1);
    ck_assert(is_quarantined(job[0].number, 0));
    ck_assert(!is_quarantined(job[0].number, 1));
    driver_lease(bed.driver, job[0].batch[0], 3, "a", 1000);
    ck_assert(is_quarantined(job[0].number, 0));
    ck_assert_int_eq(open_lost("a", INT64_MIN, false), 1); /* given back: it stays so */
    ck_assert(is_quarantined(job[0].number, 0));
    driver_lease(bed.driver, job[0].batch[0], 4, "a", 1000);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_done, job[0].batch[0], 4, &(struct pen_batch_end){"{}", 9, 0},
              &changed);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(changed);
    ck_assert(!is_quarantined(job[0].number, 0));
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_lost__jobs_that_lost_leases_are_listed_in_pages)
{
    struct pen_lost lost = {"b", 1001};
    struct pen_lost_job jobs[4];
    int count = -1;
    lease_some(_i);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_set_deaths, job[1].number, 3, 0);
    DRIVER_DO(bed.driver, job_set_charges, job[1].number, 2, 9);
    DRIVER_DO(bed.driver, lost_jobs, &lost, 0, jobs, 4, &count);
    ck_assert_int_eq(count, 3); /* one row for a job, however many its leases */
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(jobs[i].number, job[i].number);
        ck_assert_int_eq(jobs[i].deaths, i == 1 ? 3 : 0);
        ck_assert_int_eq(jobs[i].charges, i == 1 ? 2 : 0);
        ck_assert_int_eq(jobs[i].max_attempts, 5 + i);
    }
    DRIVER_DO(bed.driver, lost_jobs, &lost, job[0].number, jobs, 1, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(jobs[0].number, job[1].number);
    lost.before_ms = INT64_MIN;
    DRIVER_DO(bed.driver, lost_jobs, &lost, 0, jobs, 4, &count);
    ck_assert_int_eq(count, 2);
    ck_assert_int_eq(jobs[0].number, job[1].number);
    bed.driver->ops->rollback(bed.driver);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_lost__charges_are_seen_by_readers_and_deaths_are_not)
{
    lease_some(_i);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_set_deaths, job[0].number, 2, 0);
    DRIVER_RUN(bed.driver, commit);
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.record.revision, 1);
    ck_assert_int_eq(row.charges, 0);
    pen_job_record_release(&row.record);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_set_charges, job[0].number, 1, 99);
    DRIVER_RUN(bed.driver, commit);
    row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.record.revision, 2);
    ck_assert_int_eq(row.record.updated_ms, 99);
    ck_assert_int_eq(row.charges, 1);
    pen_job_record_release(&row.record);
    driver_bed_close(&bed);
}
END_TEST

/* Progress that forgives ends the pause and the charges of its job. */
START_TEST(test_driver_lost__forgiven_job_is_not_paused)
{
    struct pen_progress progress = {.add = true};
    struct pen_lost lost = {"a", INT64_MIN};
    struct pen_lost_job jobs[4];
    struct pen_claim claim;
    int64_t number;
    int count;
    bool found;
    lease_some(_i);
    driver_lease(bed.driver, job[1].batch[1], 1, "b", 1000);
    driver_lease(bed.driver, job[2].batch[1], 1, "b", 1000);
    ck_assert_int_eq(open_lost("a", INT64_MIN, false), 2);
    progress.job = job[0].number;
    for (int forgive = 0; forgive < 2; forgive++) {
        progress.forgive = forgive;
        DRIVER_RUN(bed.driver, begin_write);
        if (!forgive)
            DRIVER_DO(bed.driver, job_set_deaths, job[0].number, 4, 500);
        DRIVER_DO(bed.driver, job_progress, &progress);
        DRIVER_RUN(bed.driver, commit);
        DRIVER_DO(bed.driver, next_open, 499, false, &claim, &number, &found);
        ck_assert_int_eq(found, forgive);
    }
    driver_lease(bed.driver, job[0].batch[0], 2, "a", 1000);
    DRIVER_DO(bed.driver, lost_jobs, &lost, 0, jobs, 4, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(jobs[0].deaths, 0);
    driver_bed_close(&bed);
}
END_TEST

static int64_t now(struct pen_driver *driver)
{
    int64_t now_ms = 0;
    DRIVER_DO(driver, now, &now_ms);
    return now_ms;
}

/* A lease of 60 ms that is taken with one handle runs out by the clock of another. */
START_TEST(test_driver_lost__leases_run_out_by_the_stores_clock)
{
    enum { LEASE_MS = 60 };
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    struct driver_job one = driver_submit_new(bed.driver, 1, 1, 1, 0);
    int64_t begin_ms = now(bed.driver);
    ck_assert_int_gt(begin_ms, 1600000000000); /* ms since 1970 */
    driver_lease(bed.driver, one.batch[0], 1, "w", begin_ms + LEASE_MS);
    struct pen_lost lost = {NULL, now(other)};
    bool any = true;
    DRIVER_DO(other, any_lost, &lost, &any);
    ck_assert(!any || lost.before_ms > begin_ms + LEASE_MS);
    for (int i = 0; i < 1000 && !any; i++) {
        usleep(5000);
        lost.before_ms = now(other);
        DRIVER_DO(other, any_lost, &lost, &any);
        ck_assert_int_eq(any, lost.before_ms > begin_ms + LEASE_MS);
    }
    ck_assert(any);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

/* Handles that ask in turn never see time go backwards: it is one clock. */
START_TEST(test_driver_lost__all_handles_have_one_clock)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    int64_t last_ms = now(bed.driver);
    for (int i = 0; i < 200; i++) {
        int64_t now_ms = now(i % 2 ? bed.driver : other);
        ck_assert_int_ge(now_ms, last_ms);
        ck_assert_int_lt(now_ms, last_ms + 60000);
        last_ms = now_ms;
    }
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: lost leases", test_driver_lost__leases_run_out_at_their_time,
             test_driver_lost__leases_of_a_worker_are_lost_with_it,
             test_driver_lost__leases_of_a_worker_and_those_of_their_time_are_opened_together,
             test_driver_lost__quarantine_lasts_until_the_batch_is_done,
             test_driver_lost__jobs_that_lost_leases_are_listed_in_pages,
             test_driver_lost__charges_are_seen_by_readers_and_deaths_are_not,
             test_driver_lost__forgiven_job_is_not_paused,
             test_driver_lost__leases_run_out_by_the_stores_clock,
             test_driver_lost__all_handles_have_one_clock)
