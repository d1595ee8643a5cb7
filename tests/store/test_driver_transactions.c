/* SPDX-License-Identifier: MIT */
/* Contract of a driver: transactions. What is committed is seen by all handles, what is not is seen
 * by none; a read transaction sees one state; transactions that meet neither lose an update nor do
 * a thing twice. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/driver.h"

static struct driver_bed bed;

static int64_t count_jobs(struct pen_driver *driver)
{
    struct pen_counts counts;
    int64_t sum = 0;
    DRIVER_DO(driver, job_counts, &counts);
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++)
        sum += counts.jobs[i];
    return sum;
}

static bool has_key(struct pen_driver *driver, const char *key)
{
    unsigned char body[32];
    bool found;
    DRIVER_DO(driver, key_get, "", key, body, NULL, &found);
    return found;
}

/* A key, a scene, a job with a view and a batch, and a worker; the transaction stays open. */
static void write_rows(struct pen_driver *driver)
{
    static const unsigned char body[32];
    struct store_job in;
    struct pen_key_row key = {
        .client = "", .key = "k", .body_sha256 = body, .answer = "a", .created_ms = 1};
    struct pen_worker_new worker = {.id = "w", .host = "h", .pid = 1, .threads = 1};
    int64_t scene, number;
    bool added;
    store_job_init(&in, 1, 1, 1);
    struct pen_blob_start document = {
        .total = in.job.scene_bytes, .data = in.job.scene, .bytes = in.job.scene_bytes};
    struct pen_batch_add batch = {.batch = in.batch[0]};
    DRIVER_RUN(driver, begin_write);
    DRIVER_DO(driver, key_add, &key, &added);
    DRIVER_DO(driver, scene_add, in.sha256, &document, &scene, &added);
    DRIVER_DO(driver, job_add, &in.job, scene, 16, &number, &added);
    DRIVER_DO(driver, view_add, number, 0, &in.view[0], 1);
    batch.job = number;
    DRIVER_DO(driver, batch_add, &batch, &added);
    DRIVER_DO(driver, worker_put, &worker, 5);
}

static void expect_rows(struct pen_driver *driver, bool there)
{
    static const unsigned char hash[32] = {1};
    struct pen_worker_record *workers;
    struct pen_arena *arena = pen_arena_new(0);
    int64_t scene;
    int count;
    bool found, open;
    ck_assert_int_eq(has_key(driver, "k"), there);
    DRIVER_DO(driver, scene_find, hash, &scene, &found);
    ck_assert_int_eq(found, there);
    ck_assert_int_eq(count_jobs(driver), there);
    DRIVER_DO(driver, any_open, &open);
    ck_assert_int_eq(open, there);
    DRIVER_DO(driver, worker_list, arena, &workers, &count);
    ck_assert_int_eq(count, there);
    pen_arena_free(arena);
}

START_TEST(test_driver_transactions__changes_are_seen_by_others_once_committed)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    write_rows(bed.driver);
    expect_rows(bed.driver, true);
    expect_rows(other, false);
    DRIVER_RUN(bed.driver, commit);
    expect_rows(other, true);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_transactions__changes_rolled_back_are_gone)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    write_rows(bed.driver);
    bed.driver->ops->rollback(bed.driver);
    expect_rows(bed.driver, false);
    expect_rows(other, false);
    write_rows(bed.driver); /* the handle goes on */
    DRIVER_RUN(bed.driver, commit);
    expect_rows(other, true);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_transactions__only_committed_writing_ones_are_counted)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *driver = bed.driver;
    int64_t before = driver->transactions;
    write_rows(driver);
    driver->ops->rollback(driver);
    DRIVER_RUN(driver, begin_read);
    driver->ops->rollback(driver);
    ck_assert_int_eq(driver->transactions, before);
    write_rows(driver);
    DRIVER_RUN(driver, commit);
    ck_assert_int_eq(driver->transactions, before + 1);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_transactions__process_that_dies_leaves_nothing_and_blocks_nobody)
{
    int ready[2];
    char byte;
    driver_bed_open(&bed, _i);
    bed.driver->ops->close(bed.driver);
    ck_assert_int_eq(pipe(ready), 0);
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0) {
        write_rows(driver_bed_handle(&bed));
        if (write(ready[1], "x", 1) != 1)
            _exit(1);
        for (;;)
            pause();
    }
    close(ready[1]); /* a child that fails ends the read */
    ck_assert_int_eq(read(ready[0], &byte, 1), 1);
    bed.driver = driver_bed_handle(&bed);
    expect_rows(bed.driver, false);
    ck_assert_int_eq(kill(pid, SIGKILL), 0);
    ck_assert_int_eq(waitpid(pid, NULL, 0), pid);
    write_rows(bed.driver);
    DRIVER_RUN(bed.driver, commit);
    expect_rows(bed.driver, true);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_transactions__read_sees_one_state_until_it_ends)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    driver_submit_new(other, 1, 1, 1, 0);
    DRIVER_RUN(bed.driver, begin_read);
    ck_assert_int_eq(count_jobs(bed.driver), 1);
    driver_submit_new(other, 2, 1, 1, 0);
    ck_assert_int_eq(count_jobs(other), 2);
    ck_assert_int_eq(count_jobs(bed.driver), 1);
    bed.driver->ops->rollback(bed.driver);
    ck_assert_int_eq(count_jobs(bed.driver), 2);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

/* A list read in pages inside a read transaction has neither holes nor repeats. */
START_TEST(test_driver_transactions__pages_of_one_read_belong_together)
{
    driver_bed_open(&bed, _i);
    struct pen_driver *other = driver_bed_handle(&bed);
    struct driver_job job = driver_submit_new(other, 1, 1, 4, 0);
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_batch_record rows[2];
    struct pen_status st;
    bool changed;
    int count;
    DRIVER_RUN(bed.driver, begin_read);
    DRIVER_DO(bed.driver, batch_page, job.number, 0, arena, rows, 2, &count);
    ck_assert_int_eq(count, 2);
    DRIVER_RUN(other, begin_write);
    DRIVER_DO(other, job_end, job.number, PEN_JOB_CANCELLED, NULL, 9, &changed);
    DRIVER_DO(other, job_remove, job.number);
    DRIVER_DO(other, scene_remove_unused, job.scene);
    DRIVER_RUN(other, commit);
    DRIVER_DO(bed.driver, batch_page, job.number, rows[1].batch, arena, rows, 2, &count);
    ck_assert_int_eq(count, 2);
    ck_assert_int_eq(rows[0].batch, job.batch[2]);
    ck_assert_int_eq(rows[0].state, PEN_BATCH_OPEN);
    bed.driver->ops->rollback(bed.driver);
    store_must(bed.driver->ops->batch_page(bed.driver, job.number, 0, arena, rows, 2, &count, &st),
               &st, "batches");
    ck_assert_int_eq(count, 0);
    pen_arena_free(arena);
    other->ops->close(other);
    driver_bed_close(&bed);
}
END_TEST

enum { STEPS = 16 };

static bool write_progress(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    struct pen_progress progress = {.job = *(const int64_t *)arg, .pixels = 1, .add = true};
    return driver->ops->job_progress(driver, &progress, st);
}

static bool add_progress(struct pen_driver *driver, struct driver_race *race, int racer,
                         struct pen_status *st)
{
    int64_t job = *(const int64_t *)race->user;
    (void)racer;
    for (int i = 0; i < STEPS; i++) {
        if (!driver_write(driver, write_progress, &job, st))
            return false;
    }
    return true;
}

static void add_up(enum driver_racers racers, int n)
{
    struct store_job in;
    store_job_init(&in, n, 1, 1);
    in.batch[0].pixels = DRIVER_RACERS * STEPS;
    struct driver_job job = driver_submit(bed.driver, &in);
    driver_race(&bed, racers, add_progress, &job.number);
    struct pen_job_row row = driver_job_row(bed.driver, n);
    ck_assert_int_eq(row.record.done_pixels, DRIVER_RACERS * STEPS);
    ck_assert_int_eq(row.record.revision, 1 + DRIVER_RACERS * STEPS);
    pen_job_record_release(&row.record);
}

START_TEST(test_driver_transactions__no_update_is_lost)
{
    driver_bed_open(&bed, _i);
    for (int racers = 0; racers < DRIVER_RACER_KINDS; racers++)
        add_up((enum driver_racers)racers, racers);
    driver_bed_close(&bed);
}
END_TEST

struct countdown {
    int64_t job, *sum;
};

static bool write_countdown(struct pen_driver *driver, void *arg, struct pen_status *st)
{
    struct countdown *in = arg;
    int64_t batches, open;
    if (!driver->ops->view_batch_done(driver, in->job, 0, &batches, &open, st))
        return false;
    in->sum[open] = 1;
    return true;
}

static bool count_down(struct pen_driver *driver, struct driver_race *race, int racer,
                       struct pen_status *st)
{
    struct countdown in = {*(const int64_t *)race->user, race->value[racer]};
    return driver_write(driver, write_countdown, &in, st) &&
           driver_write(driver, write_countdown, &in, st);
}

/* Each of the racers counts two batches of one view off: every number is seen by exactly one, so
 * one of them sees that it was the last. */
START_TEST(test_driver_transactions__of_several_last_ones_one_sees_that_it_is_the_last)
{
    driver_bed_open(&bed, _i);
    for (int racers = 0; racers < DRIVER_RACER_KINDS; racers++) {
        struct driver_job job = driver_submit_new(bed.driver, racers, 1, 2 * DRIVER_RACERS, 0);
        const struct driver_race *race =
            driver_race(&bed, (enum driver_racers)racers, count_down, &job.number);
        for (int open = 0; open < 2 * DRIVER_RACERS; open++) {
            int64_t seen = 0;
            for (int i = 0; i < DRIVER_RACERS; i++)
                seen += race->value[i][open];
            ck_assert_msg(seen == 1, "%d left: seen by %d", open, (int)seen);
        }
    }
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: transactions",
             test_driver_transactions__changes_are_seen_by_others_once_committed,
             test_driver_transactions__changes_rolled_back_are_gone,
             test_driver_transactions__only_committed_writing_ones_are_counted,
             test_driver_transactions__process_that_dies_leaves_nothing_and_blocks_nobody,
             test_driver_transactions__read_sees_one_state_until_it_ends,
             test_driver_transactions__pages_of_one_read_belong_together,
             test_driver_transactions__no_update_is_lost,
             test_driver_transactions__of_several_last_ones_one_sees_that_it_is_the_last)
