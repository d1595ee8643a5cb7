/* SPDX-License-Identifier: MIT */
/* Contract of a driver: what a failed operation has done and what it reports, and the operations
 * that keep a store in order. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "support/driver.h"
#include "support/suite.h"

static struct driver_bed bed;

static void open_faulty(int kind)
{
    pen_log_set_level(PEN_LOG_ERROR + 1);
    driver_kinds[kind].install_failures();
    driver_bed_open(&bed, kind);
}

/* A transaction that adds a job, up to its commit. */
static bool begin_submit(struct pen_driver *driver, int n, struct pen_status *st)
{
    struct store_job in;
    int64_t scene, number;
    bool found, added;
    store_job_init(&in, n, 1, 1);
    struct pen_blob_start document = {
        .total = in.job.scene_bytes, .data = in.job.scene, .bytes = in.job.scene_bytes};
    const struct pen_driver_ops *ops = driver->ops;
    return ops->begin_write(driver, st) && ops->scene_find(driver, in.sha256, &scene, &found, st) &&
           (found || ops->scene_add(driver, in.sha256, &document, &scene, &added, st)) &&
           ops->job_add(driver, &in.job, scene, 16, &number, &added, st) &&
           ops->view_add(driver, number, 0, &in.view[0], 1, st);
}

static bool is_there(struct pen_driver *driver, int n)
{
    struct store_job in;
    struct pen_job_key key;
    bool found;
    store_job_init(&in, n, 1, 1);
    DRIVER_DO(driver, job_find, in.id, &key, &found);
    return found;
}

START_TEST(test_driver_failures__full_storage_changes_nothing)
{
    struct pen_status st = {0};
    open_faulty(_i);
    driver_submit_new(bed.driver, 1, 1, 1, 0);
    bed.kind->break_storage(DRIVER_FULL);
    bool ok = begin_submit(bed.driver, 2, &st) && bed.driver->ops->commit(bed.driver, &st);
    bed.kind->heal();
    ck_assert(!ok);
    ck_assert_msg(st.code == PEN_STORAGE_FULL, "%s", st.msg);
    ck_assert_msg(strstr(st.msg, bed.driver->name) != NULL, "%s", st.msg);
    ck_assert(!bed.driver->outcome_unknown);
    ck_assert_uint_eq(bed.driver->faults, 1u << PEN_FAULT_FULL);
    bed.driver->ops->rollback(bed.driver);
    bed.driver->faults = 0;
    ck_assert(!is_there(bed.driver, 2));
    driver_submit_new(bed.driver, 2, 1, 1, 0); /* the handle goes on */
    ck_assert_uint_eq(bed.driver->faults, 0);
    driver_bed_close(&bed);
}
END_TEST

/* All or nothing: after the handle was reopened, the job is there with its view or not at all. */
START_TEST(test_driver_failures__lost_commit_is_of_unknown_outcome)
{
    struct pen_status st = {0};
    open_faulty(_i);
    driver_submit_new(bed.driver, 1, 1, 1, 0);
    store_must(begin_submit(bed.driver, 2, &st), &st, "submit");
    int64_t transactions = bed.driver->transactions;
    bed.kind->break_storage(DRIVER_COMMIT_LOST);
    bool ok = bed.driver->ops->commit(bed.driver, &st);
    bed.kind->heal();
    ck_assert(!ok);
    ck_assert(st.code == PEN_STORAGE || st.code == PEN_UNAVAILABLE);
    ck_assert(bed.driver->outcome_unknown);
    ck_assert_int_eq(bed.driver->transactions, transactions);
    bed.driver->ops->rollback(bed.driver);
    DRIVER_RUN(bed.driver, reopen);
    bed.driver->faults = 0;
    ck_assert(is_there(bed.driver, 1));
    if (!is_there(bed.driver, 2))
        driver_submit_new(bed.driver, 2, 1, 1, 0); /* what a caller does */
    ck_assert(is_there(bed.driver, 2));
    DRIVER_RUN(bed.driver, begin_write); /* a new transaction forgets it */
    ck_assert(!bed.driver->outcome_unknown);
    bed.driver->ops->rollback(bed.driver);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_failures__handle_is_reopened_with_its_lock_and_signals)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    bool lives = false;
    driver_submit_new(bed.driver, 1, 1, 1, 0);
    DRIVER_DO(bed.driver, worker_lock, "w");
    DRIVER_RUN(bed.driver, reopen);
    ck_assert(is_there(bed.driver, 1));
    DRIVER_DO(other, worker_lives, "w", &lives);
    ck_assert(lives);
    uint32_t seen = UINT32_MAX;
    other->ops->wait(other, PEN_SIGNAL_WORK, &seen, 0);
    uint32_t before = seen;
    bed.driver->ops->wake(bed.driver, PEN_SIGNAL_WORK);
    other->ops->wait(other, PEN_SIGNAL_WORK, &seen, 10000);
    ck_assert_uint_ne(seen, before);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

/* Another handle's transaction, which has changed a job and stays open for a time. */
struct holder {
    struct pen_driver *driver;
    int64_t job;
    unsigned ms;
};

static void *hold(void *arg)
{
    struct holder *holder = arg;
    usleep(holder->ms * 1000);
    DRIVER_RUN(holder->driver, commit);
    return NULL;
}

static bool write_deaths(struct pen_driver *driver, int64_t job, struct pen_status *st)
{
    return driver->ops->begin_write(driver, st) &&
           driver->ops->job_set_charges(driver, job, 2, 20, st);
}

/* A short wait for another's transaction is no failure. */
START_TEST(test_driver_failures__writers_wait_for_each_other)
{
    pthread_t thread;
    struct pen_status st;
    driver_bed_open(&bed, _i);
    struct holder holder = {.driver = driver_bed_handle(&bed), .ms = 200};
    holder.job = driver_submit_new(bed.driver, 1, 1, 1, 0).number;
    DRIVER_RUN(holder.driver, begin_write);
    DRIVER_DO(holder.driver, job_set_charges, holder.job, 1, 10);
    ck_assert_int_eq(pthread_create(&thread, NULL, hold, &holder), 0);
    store_must(write_deaths(bed.driver, holder.job, &st), &st, "write");
    DRIVER_RUN(bed.driver, commit);
    pthread_join(thread, NULL);
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.record.revision, 3);
    ck_assert_int_eq(row.charges, 2);
    pen_job_record_release(&row.record);
    holder.driver->ops->close(holder.driver);
    driver_bed_close(&bed);
}
END_TEST

/* One that does not end is refused in time, without effect and without a fault of the store. */
START_TEST(test_driver_failures__wait_for_another_ends)
{
    struct pen_status st = {0};
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    int64_t job = driver_submit_new(bed.driver, 1, 1, 1, 0).number;
    DRIVER_RUN(other, begin_write);
    DRIVER_DO(other, job_set_charges, job, 1, 10);
    int64_t begin = pen_clock_ns();
    ck_assert(!write_deaths(bed.driver, job, &st));
    ck_assert_int_lt((pen_clock_ns() - begin) / 1000000000, SUITE_HANG_S);
    ck_assert_msg(st.code == PEN_UNAVAILABLE, "%s", st.msg);
    ck_assert_uint_eq(bed.driver->faults, 0);
    ck_assert(!bed.driver->outcome_unknown);
    bed.driver->ops->rollback(bed.driver);
    DRIVER_RUN(other, commit);
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.charges, 1);
    pen_job_record_release(&row.record);
    store_must(write_deaths(bed.driver, job, &st), &st, "again");
    DRIVER_RUN(bed.driver, commit);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

/* A job may not name a scene that is not there; the driver refuses, and goes on. */
START_TEST(test_driver_failures__row_without_its_owner_is_refused)
{
    struct store_job in;
    struct pen_status st = {0};
    struct pen_blob_start data = {.total = 1, .data = "x", .bytes = 1};
    int64_t number;
    bool added;
    driver_bed_open(&bed, _i);
    store_job_init(&in, 1, 1, 1);
    DRIVER_RUN(bed.driver, begin_write);
    bool ok = bed.driver->ops->job_add(bed.driver, &in.job, 4711, 16, &number, &added, &st);
    ok = ok && bed.driver->ops->commit(bed.driver, &st);
    ck_assert(!ok);
    bed.driver->ops->rollback(bed.driver);
    DRIVER_RUN(bed.driver, begin_write);
    ok = bed.driver->ops->pixels_add(bed.driver, 4711, &data, &st);
    ok = ok && bed.driver->ops->commit(bed.driver, &st);
    ck_assert(!ok);
    bed.driver->ops->rollback(bed.driver);
    ck_assert(!is_there(bed.driver, 1));
    ck_assert(!bed.driver->outcome_unknown);
    driver_submit_new(bed.driver, 1, 1, 1, 0);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_failures__trial_writes_leave_nothing_behind)
{
    struct pen_status st = {0};
    open_faulty(_i);
    DRIVER_RUN(bed.driver, probe);
    DRIVER_RUN(bed.driver, space);
    driver_audit_clean(bed.driver);
    bed.kind->break_storage(DRIVER_FULL);
    bool ok = bed.driver->ops->space(bed.driver, &st);
    bed.kind->heal();
    ck_assert(!ok);
    ck_assert_int_eq(st.code, PEN_STORAGE_FULL);
    bed.kind->break_storage(DRIVER_COMMIT_LOST);
    ok = bed.driver->ops->probe(bed.driver, &st);
    bed.kind->heal();
    ck_assert(!ok);
    DRIVER_RUN(bed.driver, reopen);
    bed.driver->faults = 0;
    DRIVER_RUN(bed.driver, probe);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_failures__checkpoint_and_reclaim_change_nothing_that_is_seen)
{
    driver_bed_open(&bed, _i);
    for (int n = 0; n < 20; n++)
        driver_submit_new(bed.driver, n, 1, 4, 0);
    DRIVER_RUN(bed.driver, checkpoint);
    bool more = true;
    while (more)
        DRIVER_DO(bed.driver, reclaim, &more);
    for (int n = 0; n < 20; n++)
        ck_assert(is_there(bed.driver, n));
    driver_audit_clean(bed.driver);
    DRIVER_RUN(bed.driver, check);
    driver_bed_close(&bed);
}
END_TEST

/* A batch is done without pixels, and its view still counts it. */
START_TEST(test_driver_failures__audit_finds_contradictions)
{
    struct pen_buf findings = {0};
    int found = 0, sentences = 0;
    bool changed;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 2, 0);
    driver_audit_clean(bed.driver);
    driver_lease(bed.driver, job.batch[0], 1, "w", 1000);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_done, job.batch[0], 1, &(struct pen_batch_end){"{}", 9, 0},
              &changed);
    DRIVER_RUN(bed.driver, commit);
    DRIVER_DO(bed.driver, audit, &findings, &found);
    ck_assert_int_ge(found, 2);
    for (size_t at = 0; at < findings.bytes; at += strlen((const char *)findings.data + at) + 1)
        sentences++;
    ck_assert_int_eq(sentences, found);
    pen_buf_release(&findings);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: failures", test_driver_failures__full_storage_changes_nothing,
             test_driver_failures__lost_commit_is_of_unknown_outcome,
             test_driver_failures__handle_is_reopened_with_its_lock_and_signals,
             test_driver_failures__writers_wait_for_each_other,
             test_driver_failures__wait_for_another_ends,
             test_driver_failures__row_without_its_owner_is_refused,
             test_driver_failures__trial_writes_leave_nothing_behind,
             test_driver_failures__checkpoint_and_reclaim_change_nothing_that_is_seen,
             test_driver_failures__audit_finds_contradictions)
