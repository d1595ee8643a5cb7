/* SPDX-License-Identifier: MIT */
/* Contract of a driver: batches and leases. The next batch is found by priority and age; a batch is
 * leased once; whatever is done under a lease is done only while the batch is leased under the same
 * attempt. */
#include <stdio.h>
#include <string.h>

#include "support/driver.h"

static struct driver_bed bed;

enum { NOBODY_PAUSED = 0 };

/* The next batch, which the transaction of the caller may lease. */
static bool next_open(int64_t paused_until_ms, bool quarantined, struct pen_claim *claim)
{
    int64_t job;
    bool found = false;
    DRIVER_DO(bed.driver, next_open, paused_until_ms, quarantined, claim, &job, &found);
    return found;
}

static int64_t take_next(const char *worker)
{
    struct pen_claim claim;
    bool changed = false;
    DRIVER_RUN(bed.driver, begin_write);
    bool found = next_open(NOBODY_PAUSED, false, &claim);
    if (found) {
        DRIVER_DO(bed.driver, batch_lease, claim.batch, claim.attempt + 1, worker, 1000, &changed);
        ck_assert(changed);
    }
    DRIVER_RUN(bed.driver, commit);
    return found ? claim.batch : 0;
}

START_TEST(test_driver_leases__next_is_by_priority_then_job_then_batch)
{
    driver_bed_open(&bed, _i);
    struct driver_job low = driver_submit_new(bed.driver, 1, 1, 2, -5);
    struct driver_job old = driver_submit_new(bed.driver, 2, 1, 2, 0);
    struct driver_job young = driver_submit_new(bed.driver, 3, 1, 2, 0);
    struct driver_job high = driver_submit_new(bed.driver, 4, 1, 2, 9);
    const struct driver_job *order[] = {&high, &old, &young, &low};
    for (int i = 0; i < 8; i++)
        ck_assert_int_eq(take_next("w"), order[i / 2]->batch[i % 2]);
    ck_assert_int_eq(take_next("w"), 0);
    driver_bed_close(&bed);
}
END_TEST

/* A batch that is added later comes after the other batches of its job, before younger jobs. */
START_TEST(test_driver_leases__batch_added_later_comes_by_the_age_of_its_job)
{
    struct pen_batch_add add = {.batch = {.kind = PEN_BATCH_ASSEMBLE}};
    struct pen_claim claim;
    bool added;
    driver_bed_open(&bed, _i);
    struct driver_job old = driver_submit_new(bed.driver, 1, 1, 1, 3);
    struct driver_job young = driver_submit_new(bed.driver, 2, 1, 1, 3);
    add.job = old.number;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_add, &add, &added);
    DRIVER_RUN(bed.driver, commit);
    ck_assert_int_eq(take_next("w"), old.batch[0]);
    ck_assert(next_open(NOBODY_PAUSED, false, &claim));
    ck_assert_int_eq(claim.kind, PEN_BATCH_ASSEMBLE);
    ck_assert_int_ne(take_next("w"), young.batch[0]);
    ck_assert_int_eq(take_next("w"), young.batch[0]);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_leases__claim_tells_all_of_its_batch)
{
    struct store_job in;
    struct pen_claim claim;
    int64_t number = 0;
    bool found, changed;
    driver_bed_open(&bed, _i);
    store_job_init(&in, 1, 2, 2);
    for (int i = 0; i < 2; i++) /* the second view is next */
        in.batch[i] = (struct pen_batch_new){
            .view = 1, .first_tile = 7 + i, .tile_count = 3, .pixels = 40 + i};
    in.batch[2] = in.batch[3] = (struct pen_batch_new){.pixels = 1, .tile_count = 1};
    in.job.timeout_ms = 321;
    struct driver_job job = driver_submit(bed.driver, &in);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_start, job.number, 88, &changed);
    DRIVER_RUN(bed.driver, commit);
    for (int held = 0; held < 2; held++) { /* found open, then held */
        memset(&claim, 0xff, sizeof claim);
        if (!held)
            DRIVER_DO(bed.driver, next_open, 0, false, &claim, &number, &found);
        else
            DRIVER_DO(bed.driver, first_held, "w", &claim, &number, &found);
        ck_assert(found);
        ck_assert_int_eq(number, job.number);
        ck_assert_int_eq(claim.batch, job.batch[0]);
        ck_assert_int_eq(claim.attempt, held ? 5 : 0);
        ck_assert_int_eq(claim.kind, PEN_BATCH_RENDER);
        ck_assert_str_eq(claim.job_id, in.id);
        ck_assert_int_eq(claim.view, 1);
        ck_assert_int_eq(claim.first_tile, 7);
        ck_assert_int_eq(claim.tile_count, 3);
        ck_assert_int_eq(claim.view_batches, 2);
        ck_assert_int_eq(claim.pixels, 40);
        ck_assert_mem_eq(claim.scene_sha256, in.sha256, 32);
        ck_assert_int_eq(claim.submitted_ms, 1001);
        ck_assert_int_eq(claim.started_ms, 88);
        ck_assert_int_eq(claim.timeout_ms, 321);
        if (!held) {
            ck_assert(driver_lease(bed.driver, job.batch[1], 1, "w", 1000));
            ck_assert(driver_lease(bed.driver, job.batch[0], 5, "w", 1000));
        }
    }
    DRIVER_DO(bed.driver, first_held, "nobody", &claim, &number, &found);
    ck_assert(!found);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_leases__paused_jobs_are_passed_over_until_their_time)
{
    struct pen_claim claim;
    driver_bed_open(&bed, _i);
    struct driver_job paused = driver_submit_new(bed.driver, 1, 1, 1, 0);
    struct driver_job other = driver_submit_new(bed.driver, 2, 1, 1, 0);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_set_deaths, paused.number, 2, 500);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(next_open(499, false, &claim));
    ck_assert_int_eq(claim.batch, other.batch[0]);
    ck_assert(next_open(500, false, &claim));
    ck_assert_int_eq(claim.batch, paused.batch[0]);
    ck_assert(next_open(INT64_MAX, false, &claim));
    ck_assert_int_eq(claim.batch, paused.batch[0]);
    driver_bed_close(&bed);
}
END_TEST

static int open_lost(const char *worker, bool quarantine)
{
    struct pen_lost lost = {worker, INT64_MIN};
    int opened = -1;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, open_lost, &lost, quarantine, &opened);
    DRIVER_RUN(bed.driver, commit);
    return opened;
}

START_TEST(test_driver_leases__quarantined_batches_are_found_only_if_wanted)
{
    struct pen_claim claim;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 2, 0);
    driver_lease(bed.driver, job.batch[0], 1, "w", 1000);
    ck_assert_int_eq(open_lost("w", true), 1);
    ck_assert(next_open(NOBODY_PAUSED, false, &claim));
    ck_assert_int_eq(claim.batch, job.batch[1]);
    ck_assert(next_open(NOBODY_PAUSED, true, &claim));
    ck_assert_int_eq(claim.batch, job.batch[0]);
    driver_bed_close(&bed);
}
END_TEST

static void expect_held(const char *worker, int count, int alone)
{
    int held = -1, held_alone = -1;
    DRIVER_DO(bed.driver, held_by, worker, &held, &held_alone);
    ck_assert_int_eq(held, count);
    ck_assert_int_eq(held_alone, alone);
}

START_TEST(test_driver_leases__what_a_worker_holds_is_counted)
{
    struct store_job in;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 3, 0);
    store_study_init(&in, 2, 5);
    struct driver_job study = driver_submit(bed.driver, &in);
    expect_held("a", 0, 0);
    driver_lease(bed.driver, job.batch[0], 1, "a", 1000);
    driver_lease(bed.driver, job.batch[1], 1, "a", 1000);
    driver_lease(bed.driver, job.batch[2], 1, "b", 1000);
    expect_held("a", 2, 0);
    expect_held("b", 1, 0);
    driver_lease(bed.driver, study.batch[0], 1, "b", 1000);
    expect_held("b", 2, 1);
    ck_assert_int_eq(open_lost("a", true), 2);
    expect_held("a", 0, 0);
    driver_lease(bed.driver, job.batch[0], 2, "c", 1000);
    expect_held("c", 1, 1);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_leases__only_an_open_batch_is_leased)
{
    bool open = false;
    driver_bed_open(&bed, _i);
    DRIVER_DO(bed.driver, any_open, &open);
    ck_assert(!open);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 1, 0);
    DRIVER_DO(bed.driver, any_open, &open);
    ck_assert(open);
    ck_assert(driver_lease(bed.driver, job.batch[0], 1, "a", 1000));
    ck_assert(!driver_lease(bed.driver, job.batch[0], 2, "b", 2000));
    DRIVER_DO(bed.driver, any_open, &open);
    ck_assert(!open);
    struct pen_batch_row row = driver_batch_row(bed.driver, job.batch[0]);
    ck_assert_int_eq(row.state, PEN_BATCH_LEASED);
    ck_assert_int_eq(row.attempt, 1);
    ck_assert_int_eq(row.lease_until_ms, 1000);
    ck_assert_int_eq(row.job, job.number);
    ck_assert_int_eq(row.view, 0);
    ck_assert_int_eq(row.kind, PEN_BATCH_RENDER);
    ck_assert_int_eq(row.pixels, 16);
    expect_held("a", 1, 0);
    expect_held("b", 0, 0);
    driver_bed_close(&bed);
}
END_TEST

/* The changes that only the holder of a batch may make. */
enum change { CHANGE_OPEN, CHANGE_DONE, CHANGE_EXTEND, CHANGE_SPLIT, CHANGES };

static bool make_change(enum change change, int64_t batch, int64_t attempt)
{
    bool changed = false;
    DRIVER_RUN(bed.driver, begin_write);
    switch (change) {
    case CHANGE_OPEN:
        DRIVER_DO(bed.driver, batch_open, batch, attempt, &changed);
        break;
    case CHANGE_DONE:
        DRIVER_DO(bed.driver, batch_done, batch, attempt, &(struct pen_batch_end){"{}", 9, 0},
                  &changed);
        break;
    case CHANGE_EXTEND:
        DRIVER_DO(bed.driver, batch_extend, batch, attempt, 5000, &changed);
        break;
    case CHANGE_SPLIT:
        DRIVER_DO(bed.driver, batch_split, batch, attempt, 1, 8, &changed);
        break;
    case CHANGES:
        break;
    }
    DRIVER_RUN(bed.driver, commit);
    return changed;
}

/* The fence: an attempt that is over changes nothing, whatever became of the batch since. */
START_TEST(test_driver_leases__stale_attempt_changes_nothing)
{
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 1, 0);
    int64_t batch = job.batch[0];
    for (int change = 0; change < CHANGES; change++)
        ck_assert(!make_change((enum change)change, batch, 0)); /* open */
    ck_assert(driver_lease(bed.driver, batch, 1, "a", 1000));
    ck_assert_int_eq(open_lost("a", false), 1);
    for (int change = 0; change < CHANGES; change++)
        ck_assert(!make_change((enum change)change, batch, 1)); /* open again */
    ck_assert(driver_lease(bed.driver, batch, 2, "b", 1000));
    for (int change = 0; change < CHANGES; change++)
        ck_assert(!make_change((enum change)change, batch, 1)); /* another holds it */
    struct pen_batch_row row = driver_batch_row(bed.driver, batch);
    ck_assert_int_eq(row.state, PEN_BATCH_LEASED);
    ck_assert_int_eq(row.attempt, 2);
    ck_assert_int_eq(row.lease_until_ms, 1000);
    ck_assert(make_change(CHANGE_EXTEND, batch, 2));
    ck_assert_int_eq(driver_batch_row(bed.driver, batch).lease_until_ms, 5000);
    ck_assert(make_change(CHANGE_DONE, batch, 2));
    for (int change = 0; change < CHANGES; change++) {
        ck_assert(!make_change((enum change)change, batch, 2)); /* done */
        ck_assert_int_eq(driver_batch_row(bed.driver, batch).state, PEN_BATCH_DONE);
    }
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_leases__released_batch_is_found_again_with_its_attempt)
{
    struct pen_claim claim;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 1, 0);
    driver_lease(bed.driver, job.batch[0], 3, "a", 1000);
    ck_assert(make_change(CHANGE_OPEN, job.batch[0], 3));
    ck_assert(next_open(NOBODY_PAUSED, false, &claim)); /* it is not quarantined */
    ck_assert_int_eq(claim.batch, job.batch[0]);
    ck_assert_int_eq(claim.attempt, 3);
    expect_held("a", 0, 0);
    driver_bed_close(&bed);
}
END_TEST

/* Commits two batches in the order 1, 0, each with its progress. */
START_TEST(test_driver_leases__done_takes_the_revision_of_its_job)
{
    struct pen_commit_record commits[4];
    int count = 0;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 3, 0);
    for (int i = 1; i >= 0; i--) {
        struct pen_progress progress = {.job = job.number, .pixels = 16, .add = true};
        driver_lease(bed.driver, job.batch[i], 1, "w", 1000);
        DRIVER_RUN(bed.driver, begin_write);
        DRIVER_DO(bed.driver, job_progress, &progress);
        bool changed = false;
        DRIVER_DO(bed.driver, batch_done, job.batch[i], 1, &(struct pen_batch_end){"{}", 9, 0},
                  &changed);
        DRIVER_RUN(bed.driver, commit);
        ck_assert(changed);
    }
    DRIVER_DO(bed.driver, commit_page, job.number, 0, commits, 4, &count);
    ck_assert_int_eq(count, 2);
    ck_assert_int_eq(commits[0].revision, 2);
    ck_assert_int_eq(commits[0].first_tile, 1);
    ck_assert_int_eq(commits[1].revision, 3);
    ck_assert_int_eq(commits[1].first_tile, 0);
    DRIVER_DO(bed.driver, commit_page, job.number, 2, commits, 4, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(commits[0].revision, 3);
    DRIVER_DO(bed.driver, commit_page, job.number, 0, commits, 1, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(commits[0].revision, 2);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_leases__batches_are_counted_off_their_view)
{
    int64_t batches, open;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 2, 3, 0);
    DRIVER_RUN(bed.driver, begin_write);
    for (int left = 2; left >= 0; left--) {
        DRIVER_DO(bed.driver, view_batch_done, job.number, 1, &batches, &open);
        ck_assert_int_eq(batches, 3);
        ck_assert_int_eq(open, left);
    }
    DRIVER_DO(bed.driver, view_batch_done, job.number, 0, &batches, &open);
    ck_assert_int_eq(open, 2);
    bed.driver->ops->rollback(bed.driver);
    driver_bed_close(&bed);
}
END_TEST

enum { RACE_JOBS = 4 };

struct taking {
    const char *worker;
    int64_t batch;
    bool found;
};

static bool write_taking(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    struct taking *in = arg;
    struct pen_claim claim;
    int64_t job;
    bool changed = false;
    if (!driver->ops->next_open(driver, 0, false, &claim, &job, &in->found, st))
        return false;
    in->batch = in->found ? claim.batch : 0;
    if (!in->found)
        return true;
    return driver->ops->batch_lease(driver, claim.batch, claim.attempt + 1, in->worker, 1000,
                                    &changed, st) &&
           (changed || pen_fail(st, PEN_INTERNAL, "a locked batch was leased to another"));
}

/* Takes batches until none is left, and writes down which. */
static bool take_all(struct pen_driver *driver, struct driver_race *race, int racer,
                     struct pen_status *st)
{
    char name[16];
    struct taking in = {.worker = name};
    bool any = true;
    int count = 0;
    snprintf(name, sizeof name, "w%d", racer);
    while (any) {
        if (!driver_write(driver, write_taking, &in, st))
            return false;
        if (in.found)
            race->value[racer][count++] = in.batch;
        else if (!driver->ops->any_open(driver, &any, st)) /* it may be another's to lease now */
            return false;
    }
    return true;
}

static int times_taken(const struct driver_race *race, int64_t batch)
{
    int times = 0;
    for (int i = 0; i < DRIVER_RACERS; i++) {
        for (int k = 0; k < DRIVER_RACE_VALUES; k++)
            times += race->value[i][k] == batch;
    }
    return times;
}

START_TEST(test_driver_leases__race_for_batches_leases_each_once)
{
    for (int racers = 0; racers < DRIVER_RACER_KINDS; racers++) {
        struct driver_job job[RACE_JOBS];
        driver_bed_open(&bed, _i);
        for (int j = 0; j < RACE_JOBS; j++)
            job[j] = driver_submit_new(bed.driver, j, 1, DRIVER_BATCHES, 0);
        const struct driver_race *race =
            driver_race(&bed, (enum driver_racers)racers, take_all, NULL);
        for (int i = 0; i < RACE_JOBS * DRIVER_BATCHES; i++) {
            int64_t batch = job[i / DRIVER_BATCHES].batch[i % DRIVER_BATCHES];
            ck_assert_int_eq(times_taken(race, batch), 1);
            ck_assert_int_eq(driver_batch_row(bed.driver, batch).attempt, 1);
        }
        driver_bed_close(&bed);
    }
}
END_TEST

static void spend(int64_t batch, int64_t attempt, int64_t spent_us)
{
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_spend, batch, attempt, spent_us);
    DRIVER_RUN(bed.driver, commit);
}

static void expect_spent(int64_t batch, int64_t spent_us, int64_t job_spent_us)
{
    struct pen_batch_row row = driver_batch_row(bed.driver, batch);
    ck_assert_int_eq(row.spent_us, spent_us);
    ck_assert_int_eq(row.job_spent_us, job_spent_us);
}

START_TEST(test_driver_leases__time_is_spent_under_a_lease_and_added_to_the_job)
{
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 2, 0);
    spend(job.batch[0], 0, 10); /* open */
    expect_spent(job.batch[0], 0, 0);
    ck_assert(driver_lease(bed.driver, job.batch[0], 1, "a", 1000));
    ck_assert(driver_lease(bed.driver, job.batch[1], 1, "b", 1000));
    spend(job.batch[0], 1, 10);
    spend(job.batch[0], 2, 50); /* another attempt */
    expect_spent(job.batch[0], 10, 10);
    spend(job.batch[1], 1, 5);
    spend(job.batch[0], 1, 30);
    spend(job.batch[0], 1, 20); /* less than before */
    expect_spent(job.batch[0], 30, 35);
    ck_assert(make_change(CHANGE_OPEN, job.batch[0], 1));
    ck_assert(driver_lease(bed.driver, job.batch[0], 2, "b", 1000));
    expect_spent(job.batch[0], 0, 35);
    spend(job.batch[0], 2, 7);
    expect_spent(job.batch[0], 7, 42);
    driver_bed_close(&bed);
}
END_TEST

/* Leases of a second, all of which began at 0 but one. */
START_TEST(test_driver_leases__untold_time_is_charged_up_to_the_length_of_a_lease)
{
    const struct pen_worker_new worker = {
        .id = "a", .host = "host", .pid = 1, .threads = 1, .lease_ms = 1000};
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 4, 0);
    struct driver_job other = driver_submit_new(bed.driver, 2, 1, 1, 0);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, worker_put, &worker, 0);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(driver_lease(bed.driver, job.batch[0], 1, "a", 1000));
    ck_assert(driver_lease(bed.driver, job.batch[1], 1, "a", 1200)); /* began at 200 */
    ck_assert(driver_lease(bed.driver, job.batch[2], 1, "stranger", 1000));
    ck_assert(driver_lease(bed.driver, other.batch[0], 1, "a", 1000));
    spend(job.batch[0], 1, 50);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_charge_leases, job.number, 300);
    DRIVER_RUN(bed.driver, commit);
    expect_spent(job.batch[0], 300050, 400050);
    expect_spent(job.batch[1], 100000, 400050);
    expect_spent(job.batch[2], 0, 400050); /* nobody knows when that lease began */
    expect_spent(job.batch[3], 0, 400050); /* open */
    expect_spent(other.batch[0], 0, 0);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_charge_leases, other.number, 5000);
    DRIVER_RUN(bed.driver, commit);
    expect_spent(other.batch[0], 1000000, 1000000);
    driver_bed_close(&bed);
}
END_TEST

static bool any_ahead(int64_t now_ms)
{
    bool any;
    DRIVER_DO(bed.driver, times_ahead, now_ms, &any);
    return any;
}

/* A lease of a second that was taken at 4000, and a peer and a worker of then, as 3000 sees them.
 */
START_TEST(test_driver_leases__times_that_lie_ahead_are_mended)
{
    const struct pen_worker_new worker = {
        .id = "a", .host = "host", .pid = 1, .threads = 1, .lease_ms = 1000};
    struct pen_lost lost = {NULL, 4001};
    bool any;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 2, 0);
    ck_assert(driver_lease(bed.driver, job.batch[0], 1, "a", 5000));
    ck_assert(driver_lease(bed.driver, job.batch[1], 1, "stranger", 5000));
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, share_served, job.batch[0], 4000);
    DRIVER_DO(bed.driver, worker_put, &worker, 4000);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(!any_ahead(4000));
    ck_assert(any_ahead(3999));
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, times_mend, 3000);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(!any_ahead(3000));
    ck_assert(any_ahead(2999));
    DRIVER_DO(bed.driver, any_lost, &lost, &any);
    ck_assert(any);
    lost.before_ms = 4000;
    DRIVER_DO(bed.driver, any_lost, &lost, &any);
    ck_assert(!any);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: leases", test_driver_leases__times_that_lie_ahead_are_mended,
             test_driver_leases__untold_time_is_charged_up_to_the_length_of_a_lease,
             test_driver_leases__next_is_by_priority_then_job_then_batch,
             test_driver_leases__batch_added_later_comes_by_the_age_of_its_job,
             test_driver_leases__claim_tells_all_of_its_batch,
             test_driver_leases__paused_jobs_are_passed_over_until_their_time,
             test_driver_leases__quarantined_batches_are_found_only_if_wanted,
             test_driver_leases__what_a_worker_holds_is_counted,
             test_driver_leases__only_an_open_batch_is_leased,
             test_driver_leases__stale_attempt_changes_nothing,
             test_driver_leases__released_batch_is_found_again_with_its_attempt,
             test_driver_leases__done_takes_the_revision_of_its_job,
             test_driver_leases__time_is_spent_under_a_lease_and_added_to_the_job,
             test_driver_leases__batches_are_counted_off_their_view,
             test_driver_leases__race_for_batches_leases_each_once)
