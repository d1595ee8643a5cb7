/* SPDX-License-Identifier: MIT */
/* Contract of a driver: rows of jobs. What a job was submitted with is read back, lists are in
 * order and filtered, and every change of state happens only from the states it may begin in. */
#include <stdio.h>
#include <string.h>

#include "support/driver.h"

static struct driver_bed bed;

START_TEST(test_driver_jobs__job_is_read_as_written)
{
    struct store_job in;
    driver_bed_open(&bed, _i);
    store_job_init(&in, 1, 2, 3);
    in.job.priority = -3;
    in.job.max_attempts = 4;
    in.job.timeout_ms = 5000;
    in.job.created_ms = 123456789012345;
    in.job.request = "{\"name\": \"\xc3\xa4 'quoted' \\\"\"}";
    struct driver_job job = driver_submit(bed.driver, &in);
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    const struct pen_job_record *record = &row.record;
    ck_assert_int_eq(record->number, job.number);
    ck_assert_str_eq(record->id, in.id);
    ck_assert_int_eq(record->state, PEN_JOB_QUEUED);
    ck_assert_int_eq(record->revision, 1);
    ck_assert_str_eq(record->kind, "render");
    ck_assert_str_eq(record->request, in.job.request);
    ck_assert_ptr_null(record->error);
    ck_assert_int_eq(record->priority, -3);
    ck_assert_int_eq(record->max_attempts, 4);
    ck_assert_int_eq(record->attempts, 0);
    ck_assert_int_eq(record->timeout_ms, 5000);
    ck_assert_int_eq(record->created_ms, 123456789012345);
    ck_assert_int_eq(record->updated_ms, 123456789012345);
    ck_assert_int_eq(record->started_ms, 0);
    ck_assert_int_eq(record->finished_ms, 0);
    ck_assert_int_eq(record->done_pixels, 0);
    ck_assert_int_eq(record->total_pixels, 6 * 16);
    ck_assert_int_eq(row.charges, 0);
    ck_assert_int_eq(row.scene, job.scene);
    pen_job_record_release(&row.record);
    struct pen_job_row none;
    bool found = true;
    DRIVER_DO(bed.driver, job_get, "nobody", &none, &found);
    ck_assert(!found);
    driver_bed_close(&bed);
}
END_TEST

static bool end_job(struct pen_driver *driver, int64_t job, enum pen_job_state state)
{
    bool changed = false;
    DRIVER_RUN(driver, begin_write);
    DRIVER_DO(driver, job_end, job, state, state == PEN_JOB_FAILED ? "{}" : NULL, 77, &changed);
    DRIVER_RUN(driver, commit);
    return changed;
}

static bool start_job(struct pen_driver *driver, int64_t job, int64_t now_ms)
{
    bool changed = false;
    DRIVER_RUN(driver, begin_write);
    DRIVER_DO(driver, job_start, job, now_ms, &changed);
    DRIVER_RUN(driver, commit);
    return changed;
}

/* The last digits of the ids on a page, and the number of the last job. */
static int64_t page(const struct pen_job_filter *filter, const char *expected)
{
    struct pen_job_row rows[8];
    char text[9] = "";
    int64_t last = 0;
    int count = -1;
    DRIVER_DO(bed.driver, job_page, filter, rows, &count);
    for (int i = 0; i < count; i++) {
        text[i] = rows[i].record.id[PEN_ID_BYTES - 2];
        last = rows[i].record.number;
        pen_job_record_release(&rows[i].record);
    }
    ck_assert_str_eq(text, expected);
    return last;
}

START_TEST(test_driver_jobs__pages_are_newest_first_and_filtered)
{
    driver_bed_open(&bed, _i);
    for (int n = 0; n < 7; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 1);
        in.job.kind = n % 2 ? "render" : "effects";
        struct driver_job job = driver_submit(bed.driver, &in);
        if (n >= 4)
            end_job(bed.driver, job.number, PEN_JOB_CANCELLED);
    }
    struct pen_job_filter filter = {.state = -1, .limit = 3};
    filter.below = page(&filter, "654");
    filter.below = page(&filter, "321");
    page(&filter, "0");
    filter = (struct pen_job_filter){.state = PEN_JOB_CANCELLED, .limit = 8};
    page(&filter, "654");
    filter.kind = "effects";
    page(&filter, "64");
    filter.state = -1;
    page(&filter, "6420");
    filter.state = PEN_JOB_QUEUED;
    filter.limit = 1;
    filter.below = page(&filter, "2");
    page(&filter, "0");
    filter.kind = "none";
    page(&filter, "");
    driver_bed_close(&bed);
}
END_TEST

/* The job that brings them to more than the bound is the last one, unless it is the first. */
START_TEST(test_driver_jobs__a_page_ends_where_its_texts_are_long)
{
    char request[1001];
    driver_bed_open(&bed, _i);
    for (int n = 0; n < 5; n++) {
        struct store_job in;
        store_job_init(&in, n, 1, 1);
        snprintf(request, sizeof request, "{\"name\": \"%0*d\"}", 900, n);
        in.job.request = request;
        driver_submit(bed.driver, &in);
    }
    struct pen_job_filter filter = {.state = -1, .limit = 8, .text_bytes = 2000};
    filter.below = page(&filter, "432");
    page(&filter, "10");
    filter = (struct pen_job_filter){.state = -1, .limit = 8, .text_bytes = 1};
    page(&filter, "43");
    filter.limit = 1;
    page(&filter, "4");
    filter = (struct pen_job_filter){.state = -1, .limit = 8};
    page(&filter, "43210");
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_jobs__key_of_a_job_has_its_state_and_scene)
{
    struct store_job in;
    struct pen_job_key key;
    bool found;
    driver_bed_open(&bed, _i);
    driver_submit_new(bed.driver, 1, 1, 1, 0);
    driver_submit_new(bed.driver, 9, 1, 1, 0); /* of the same scene: numbers differ from here on */
    struct driver_job job = driver_submit_new(bed.driver, 2, 1, 1, 0);
    ck_assert_int_ne(job.number, job.scene);
    start_job(bed.driver, job.number, 50);
    end_job(bed.driver, job.number, PEN_JOB_FAILED);
    store_job_init(&in, 2, 1, 1);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_find, in.id, &key, &found);
    ck_assert(found);
    ck_assert_int_eq(key.number, job.number);
    ck_assert_int_eq(key.scene, job.scene);
    ck_assert_int_eq(key.state, PEN_JOB_FAILED);
    DRIVER_DO(bed.driver, job_find, "nobody", &key, &found);
    ck_assert(!found);
    bed.driver->ops->rollback(bed.driver);
    driver_bed_close(&bed);
}
END_TEST

static bool is_of(const char *id, const char *client)
{
    bool is;
    DRIVER_DO(bed.driver, job_is_of, id, client, &is);
    return is;
}

START_TEST(test_driver_jobs__client_of_a_job_outlives_its_row)
{
    struct store_job in;
    driver_bed_open(&bed, _i);
    store_job_init(&in, 1, 1, 1);
    in.job.client = "token:a";
    struct driver_job job = driver_submit(bed.driver, &in);
    ck_assert(is_of(in.id, "token:a"));
    ck_assert(!is_of(in.id, "token:b"));
    ck_assert(!is_of(in.id, ""));
    ck_assert(!is_of("nobody", ""));
    end_job(bed.driver, job.number, PEN_JOB_CANCELLED);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_mark_removed, job.number, 9);
    DRIVER_DO(bed.driver, removed_add, in.id, 9, NULL);
    DRIVER_DO(bed.driver, job_remove, job.number);
    DRIVER_DO(bed.driver, scene_remove_unused, job.scene);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(is_of(in.id, "token:a"));
    ck_assert(!is_of(in.id, ""));
    driver_bed_close(&bed);
}
END_TEST

/* Jobs 1 to 5 in the order of their states, with two batches each; the running one holds one. */
static void one_job_in_each_state(int64_t numbers[PEN_JOB_STATE_COUNT])
{
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++) {
        struct driver_job job = driver_submit_new(bed.driver, 1 + s, 1, 2, 0);
        numbers[s] = job.number;
        if (s == PEN_JOB_RUNNING || s == PEN_JOB_SUCCEEDED || s == PEN_JOB_FAILED)
            start_job(bed.driver, job.number, 50);
        if (s == PEN_JOB_RUNNING)
            ck_assert(driver_lease(bed.driver, job.batch[0], 1, "w", 1000));
        if (s == PEN_JOB_FAILED || s == PEN_JOB_CANCELLED)
            end_job(bed.driver, job.number, (enum pen_job_state)s);
        DRIVER_RUN(bed.driver, begin_write);
        if (s == PEN_JOB_SUCCEEDED)
            DRIVER_DO(bed.driver, job_succeed, job.number, 60);
        if (s >= PEN_JOB_SUCCEEDED)
            DRIVER_DO(bed.driver, job_end_batches, job.number);
        DRIVER_RUN(bed.driver, commit);
    }
}

START_TEST(test_driver_jobs__counts_are_by_state)
{
    struct pen_counts counts = {.open_batches = 99};
    int64_t numbers[PEN_JOB_STATE_COUNT];
    driver_bed_open(&bed, _i);
    DRIVER_DO(bed.driver, job_counts, &counts);
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_int_eq(counts.jobs[s], 0);
    ck_assert_int_eq(counts.open_batches, 0);
    one_job_in_each_state(numbers);
    for (int n = 10; n < 12; n++)
        driver_submit_new(bed.driver, n, 1, 3, 0);
    DRIVER_DO(bed.driver, job_counts, &counts);
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_int_eq(counts.jobs[s], s == PEN_JOB_QUEUED ? 3 : 1);
    ck_assert_int_eq(counts.open_batches, 2 + 1 + 2 * 3);
    ck_assert_int_eq(counts.leased_batches, 1);
    driver_bed_close(&bed);
}
END_TEST

/* A change of state: what it does to a job in each state. */
static void expect_states(const int64_t *numbers, const enum pen_job_state *after,
                          const int64_t *revisions)
{
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++) {
        struct pen_job_row row = driver_job_row(bed.driver, 1 + s);
        ck_assert_int_eq(row.record.number, numbers[s]);
        ck_assert_msg(row.record.state == after[s], "job in state %d: now %d", s, row.record.state);
        ck_assert_msg(row.record.revision == revisions[s], "job in state %d: revision %lld", s,
                      (long long)row.record.revision);
        pen_job_record_release(&row.record);
    }
}

START_TEST(test_driver_jobs__only_a_queued_job_is_started)
{
    int64_t numbers[PEN_JOB_STATE_COUNT];
    driver_bed_open(&bed, _i);
    one_job_in_each_state(numbers);
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_int_eq(start_job(bed.driver, numbers[s], 99), s == PEN_JOB_QUEUED);
    expect_states(numbers,
                  (const enum pen_job_state[]){PEN_JOB_RUNNING, PEN_JOB_RUNNING, PEN_JOB_SUCCEEDED,
                                               PEN_JOB_FAILED, PEN_JOB_CANCELLED},
                  (const int64_t[]){2, 2, 2, 3, 2});
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.record.started_ms, 99);
    ck_assert_int_eq(row.record.updated_ms, 99);
    pen_job_record_release(&row.record);
    row = driver_job_row(bed.driver, 2);
    ck_assert_int_eq(row.record.started_ms, 50);
    pen_job_record_release(&row.record);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_jobs__only_a_running_job_succeeds)
{
    int64_t numbers[PEN_JOB_STATE_COUNT];
    driver_bed_open(&bed, _i);
    one_job_in_each_state(numbers);
    DRIVER_RUN(bed.driver, begin_write);
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        DRIVER_DO(bed.driver, job_succeed, numbers[s], 99);
    DRIVER_RUN(bed.driver, commit);
    expect_states(numbers,
                  (const enum pen_job_state[]){PEN_JOB_QUEUED, PEN_JOB_SUCCEEDED, PEN_JOB_SUCCEEDED,
                                               PEN_JOB_FAILED, PEN_JOB_CANCELLED},
                  (const int64_t[]){1, 2, 2, 3, 2});
    struct pen_job_row row = driver_job_row(bed.driver, 2);
    ck_assert_int_eq(row.record.finished_ms, 99);
    pen_job_record_release(&row.record);
    row = driver_job_row(bed.driver, 3);
    ck_assert_int_eq(row.record.finished_ms, 60);
    pen_job_record_release(&row.record);
    driver_bed_close(&bed);
}
END_TEST

static void expect_end(int n, enum pen_job_state end)
{
    struct pen_job_row row = driver_job_row(bed.driver, n);
    ck_assert_int_eq(row.record.finished_ms, 77);
    ck_assert_int_eq(row.record.updated_ms, 77);
    ck_assert_int_eq(row.record.error != NULL, end == PEN_JOB_FAILED);
    if (row.record.error)
        ck_assert_str_eq(row.record.error, "{}");
    pen_job_record_release(&row.record);
}

START_TEST(test_driver_jobs__only_jobs_that_go_on_are_cancelled)
{
    int64_t numbers[PEN_JOB_STATE_COUNT];
    driver_bed_open(&bed, _i);
    one_job_in_each_state(numbers);
    for (int s = 0; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_int_eq(end_job(bed.driver, numbers[s], PEN_JOB_CANCELLED),
                         s == PEN_JOB_QUEUED || s == PEN_JOB_RUNNING);
    expect_states(numbers,
                  (const enum pen_job_state[]){PEN_JOB_CANCELLED, PEN_JOB_CANCELLED,
                                               PEN_JOB_SUCCEEDED, PEN_JOB_FAILED,
                                               PEN_JOB_CANCELLED},
                  (const int64_t[]){2, 3, 2, 3, 2});
    expect_end(1, PEN_JOB_CANCELLED);
    expect_end(2, PEN_JOB_CANCELLED);
    driver_bed_close(&bed);
}
END_TEST

/* A queued job cannot fail: the database itself refuses a change that states.h does not list. */
START_TEST(test_driver_jobs__only_a_running_job_fails)
{
    int64_t numbers[PEN_JOB_STATE_COUNT];
    struct pen_status st = {0};
    bool changed;
    driver_bed_open(&bed, _i);
    one_job_in_each_state(numbers);
    DRIVER_RUN(bed.driver, begin_write);
    ck_assert(!bed.driver->ops->job_end(bed.driver, numbers[PEN_JOB_QUEUED], PEN_JOB_FAILED, "{}",
                                        77, &changed, &st));
    ck_assert_int_eq(st.code, PEN_INTERNAL);
    bed.driver->ops->rollback(bed.driver);
    for (int s = PEN_JOB_RUNNING; s < PEN_JOB_STATE_COUNT; s++)
        ck_assert_int_eq(end_job(bed.driver, numbers[s], PEN_JOB_FAILED), s == PEN_JOB_RUNNING);
    expect_states(numbers,
                  (const enum pen_job_state[]){PEN_JOB_QUEUED, PEN_JOB_FAILED, PEN_JOB_SUCCEEDED,
                                               PEN_JOB_FAILED, PEN_JOB_CANCELLED},
                  (const int64_t[]){1, 3, 2, 3, 2});
    expect_end(2, PEN_JOB_FAILED);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_jobs__open_and_leased_batches_are_ended_and_done_ones_stay)
{
    bool changed;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 3, 0);
    struct driver_job other = driver_submit_new(bed.driver, 2, 1, 1, 0);
    driver_lease(bed.driver, job.batch[0], 1, "w", 1000);
    driver_lease(bed.driver, job.batch[1], 1, "w", 1000);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_done, job.batch[0], 1, &(struct pen_batch_end){"{}", 9, 0},
              &changed);
    DRIVER_DO(bed.driver, job_end_batches, job.number);
    DRIVER_RUN(bed.driver, commit);
    ck_assert_int_eq(driver_batch_row(bed.driver, job.batch[0]).state, PEN_BATCH_DONE);
    ck_assert_int_eq(driver_batch_row(bed.driver, job.batch[1]).state, PEN_BATCH_ENDED);
    ck_assert_int_eq(driver_batch_row(bed.driver, job.batch[2]).state, PEN_BATCH_ENDED);
    ck_assert_int_eq(driver_batch_row(bed.driver, other.batch[0]).state, PEN_BATCH_OPEN);
    driver_bed_close(&bed);
}
END_TEST

static void progress(int64_t job, int64_t pixels, bool add, bool forgive, int64_t now_ms)
{
    struct pen_progress in = {
        .job = job, .pixels = pixels, .now_ms = now_ms, .add = add, .forgive = forgive};
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_progress, &in);
    DRIVER_RUN(bed.driver, commit);
}

static void expect_progress(int64_t pixels, int64_t charges, int64_t revision)
{
    struct pen_job_row row = driver_job_row(bed.driver, 1);
    ck_assert_int_eq(row.record.done_pixels, pixels);
    ck_assert_int_eq(row.charges, charges);
    ck_assert_int_eq(row.record.revision, revision);
    ck_assert_int_eq(row.record.updated_ms, 10 * revision);
    pen_job_record_release(&row.record);
}

START_TEST(test_driver_jobs__progress_is_added_or_set_and_may_forgive_charges)
{
    driver_bed_open(&bed, _i);
    int64_t job = driver_submit_new(bed.driver, 1, 1, 2, 0).number; /* 32 pixels */
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_set_deaths, job, 2, 0);
    DRIVER_DO(bed.driver, job_set_charges, job, 2, 20);
    DRIVER_RUN(bed.driver, commit);
    expect_progress(0, 2, 2);
    progress(job, 10, true, false, 30);
    expect_progress(10, 2, 3);
    progress(job, 6, true, false, 40);
    expect_progress(16, 2, 4);
    progress(job, 5, false, false, 50);
    expect_progress(5, 2, 5);
    progress(job, 1000, false, false, 60);
    expect_progress(32, 2, 6);
    progress(job, 0, false, true, 70);
    expect_progress(0, 0, 7);
    driver_bed_close(&bed);
}
END_TEST

/* Two batches of 16 pixels: one tells of a part of its own, then the other is done, then the first.
 */
START_TEST(test_driver_jobs__progress_is_raised_and_never_lowered)
{
    bool done;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 2, 0);
    const int64_t batch[] = {job.batch[0], job.batch[1]};
    static const struct {
        int64_t pixels, expected;
        int done; /* the batch that is done with it; -1: none */
    } steps[] = {{5, 5, -1}, {3, 5, -1}, {16, 16, 1}, {4, 20, -1}, {16, 32, 0}};
    for (int i = 0; i < 2; i++)
        driver_lease(bed.driver, batch[i], 1, "w", 1000);
    for (int i = 0; i < 5; i++) {
        struct pen_progress in = {
            .job = job.number, .pixels = steps[i].pixels, .add = true, .raise = true};
        DRIVER_RUN(bed.driver, begin_write);
        DRIVER_DO(bed.driver, job_progress, &in);
        if (steps[i].done >= 0)
            DRIVER_DO(bed.driver, batch_done, batch[steps[i].done], 1,
                      &(struct pen_batch_end){"{}", 9, 0}, &done);
        DRIVER_RUN(bed.driver, commit);
        struct pen_job_row row = driver_job_row(bed.driver, 1);
        ck_assert_int_eq(row.record.done_pixels, steps[i].expected);
        pen_job_record_release(&row.record);
    }
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_jobs__progress_keeps_the_last_estimate)
{
    driver_bed_open(&bed, _i);
    const int64_t job = driver_submit_new(bed.driver, 1, 1, 2, 0).number,
                  estimates[][2] = {{0, 0}, {7000, 7000}, {0, 7000}, {90, 90}};
    for (int i = 0; i < 4; i++) {
        struct pen_progress in = {
            .job = job, .add = true, .now_ms = 20 + 10 * i, .estimate_ms = estimates[i][0]};
        DRIVER_RUN(bed.driver, begin_write);
        DRIVER_DO(bed.driver, job_progress, &in);
        DRIVER_RUN(bed.driver, commit);
        struct pen_job_row row = driver_job_row(bed.driver, 1);
        ck_assert_int_eq(row.record.estimate_ms, estimates[i][1]);
        pen_job_record_release(&row.record);
        expect_progress(0, 0, 2 + i);
    }
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_jobs__views_are_counted_off)
{
    int64_t open = -1;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 3, 1, 0);
    DRIVER_RUN(bed.driver, begin_write);
    for (int left = 2; left >= 0; left--) {
        DRIVER_DO(bed.driver, job_view_ended, job.number, &open);
        ck_assert_int_eq(open, left);
    }
    bed.driver->ops->rollback(bed.driver);
    driver_bed_close(&bed);
}
END_TEST

/* Stores pixels of a batch, statistics and a picture of a job. */
static int64_t store_results(const struct driver_job *job)
{
    struct pen_blob_start data = {.total = 4, .data = "data", .bytes = 4};
    struct pen_artefact_key key = {job->number, 0, "beauty", "png"};
    int64_t artefact;
    bool changed;
    driver_lease(bed.driver, job->batch[0], 1, "w", 1000);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_done, job->batch[0], 1, &(struct pen_batch_end){"{}", 9, 0},
              &changed);
    DRIVER_DO(bed.driver, pixels_add, job->batch[0], &data);
    DRIVER_DO(bed.driver, artefact_put, &key, 1, &data, &artefact);
    DRIVER_RUN(bed.driver, commit);
    return artefact;
}

static bool is_blob(enum pen_blob_kind kind, int64_t number)
{
    struct pen_status st = {0};
    char data[4];
    bool there = bed.driver->ops->blob_read(bed.driver, kind, number, 0, data, 4, &st);
    ck_assert(there || st.code == PEN_NOT_FOUND);
    return there;
}

START_TEST(test_driver_jobs__removed_job_leaves_nothing_and_others_stay)
{
    struct pen_batch_row batch;
    struct pen_job_row row;
    struct store_job in;
    bool changed, found;
    driver_bed_open(&bed, _i);
    struct driver_job gone = driver_submit_new(bed.driver, 1, 2, 2, 0);
    struct driver_job kept = driver_submit_new(bed.driver, 9, 2, 2, 0); /* of the same scene */
    ck_assert_int_eq(gone.scene, kept.scene);
    int64_t gone_picture = store_results(&gone), kept_picture = store_results(&kept);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_end, gone.number, PEN_JOB_CANCELLED, NULL, 9, &changed);
    DRIVER_DO(bed.driver, job_remove, gone.number);
    DRIVER_DO(bed.driver, scene_remove_unused, gone.scene);
    DRIVER_RUN(bed.driver, commit);
    store_job_init(&in, 1, 1, 1);
    DRIVER_DO(bed.driver, job_get, in.id, &row, &found);
    ck_assert(!found);
    DRIVER_DO(bed.driver, batch_get, gone.batch[0], &batch, &found);
    ck_assert(!found);
    ck_assert(!is_blob(PEN_BLOB_PIXELS, gone.batch[0]));
    ck_assert(!is_blob(PEN_BLOB_ARTEFACT, gone_picture));
    ck_assert(is_blob(PEN_BLOB_PIXELS, kept.batch[0]));
    ck_assert(is_blob(PEN_BLOB_ARTEFACT, kept_picture));
    ck_assert(is_blob(PEN_BLOB_SCENE, kept.scene));
    ck_assert_int_eq(driver_batch_row(bed.driver, kept.batch[3]).state, PEN_BATCH_OPEN);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: jobs", test_driver_jobs__job_is_read_as_written,
             test_driver_jobs__pages_are_newest_first_and_filtered,
             test_driver_jobs__a_page_ends_where_its_texts_are_long,
             test_driver_jobs__client_of_a_job_outlives_its_row,
             test_driver_jobs__key_of_a_job_has_its_state_and_scene,
             test_driver_jobs__counts_are_by_state, test_driver_jobs__only_a_queued_job_is_started,
             test_driver_jobs__only_a_running_job_succeeds,
             test_driver_jobs__only_jobs_that_go_on_are_cancelled,
             test_driver_jobs__only_a_running_job_fails,
             test_driver_jobs__open_and_leased_batches_are_ended_and_done_ones_stay,
             test_driver_jobs__progress_is_added_or_set_and_may_forgive_charges,
             test_driver_jobs__progress_is_raised_and_never_lowered,
             test_driver_jobs__progress_keeps_the_last_estimate,
             test_driver_jobs__views_are_counted_off,
             test_driver_jobs__removed_job_leaves_nothing_and_others_stay)
