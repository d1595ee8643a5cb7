/* SPDX-License-Identifier: MIT */
/* Submit, claim, commit: from a queued job to its end; the fence; repeated calls. */
#include <string.h>

#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job;

static void begin(int views, int batches)
{
    store_bed_open(&bed);
    store_job_init(&job, 1, views, batches);
    store_job_submit(bed.store, &job);
}

START_TEST(
    test_commit__the_last_batch_of_a_view_adds_the_assemble_batch_and_the_last_view_ends_the_job)
{
    begin(2, 3);
    ck_assert_int_eq(store_job_state(bed.store, job.id), PEN_JOB_QUEUED);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 2 * (3 + 1));
    struct pen_job_record record = store_job_get(bed.store, job.id);
    ck_assert_int_eq(record.state, PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(record.done_pixels, record.total_pixels);
    ck_assert_int_ge(record.work, PEN_WORK_ALL - 10);
    ck_assert_int_eq(record.attempts, 1);
    ck_assert_int_gt(record.finished_ms, 0);
    pen_job_record_release(&record);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_commit__repeated_changes_nothing_and_stale_is_refused)
{
    struct pen_status st;
    begin(1, 2);
    struct pen_claim claim = store_claim(bed.store, "w");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    struct pen_job_record record = store_job_get(bed.store, job.id);
    ck_assert_int_eq(record.done_pixels, STORE_JOB_TILE * STORE_JOB_TILE);
    pen_job_record_release(&record);
    claim = store_claim(bed.store, "w");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    const struct pen_claim again = store_claim(bed.store, "w");
    ck_assert_int_eq(again.attempt, claim.attempt + 1);
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_STALE);
    store_must(pen_store_cancel(bed.store, job.id, NULL, &st), &st, "cancel");
    ck_assert_int_eq(store_commit(bed.store, &again), PEN_STALE);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_commit__a_part_leaves_the_other_tiles_as_an_open_batch)
{
    struct pen_status st;
    enum { PIXELS = STORE_JOB_TILE * STORE_JOB_TILE };
    static const float rgb[PIXELS * 3];
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 2);
    job.batch[0].tile_count = 2;
    job.batch[0].pixels = 2 * PIXELS;
    job.job.batch_count = 1;
    store_job_submit(bed.store, &job);
    const struct pen_claim claim = store_claim(bed.store, "w");
    const struct pen_result part = {.rgb = rgb, .pixels = PIXELS, .part_tiles = 1, .stats = "{}"};
    store_must(pen_store_commit(bed.store, &claim, &part, NULL, &st), &st, "commit");
    const struct pen_claim rest = store_claim(bed.store, "w");
    ck_assert_int_eq(rest.first_tile, 1);
    ck_assert_int_eq(rest.tile_count, 1);
    ck_assert_int_eq(rest.pixels, PIXELS);
    ck_assert_int_eq(rest.view_batches, 2);
    ck_assert_int_eq(store_commit(bed.store, &rest), PEN_OK);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 1);
    ck_assert_int_eq(store_job_state(bed.store, job.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_commit__a_claim_repeated_with_its_serial_gets_the_same_batch)
{
    struct pen_status st;
    struct pen_claim first, second;
    bool found;
    begin(1, 3);
    store_must(pen_store_claim(bed.store, "v", 1000, 7, &first, &found, &st), &st, "claim");
    store_must(pen_store_claim(bed.store, "v", 1000, 7, &second, &found, &st), &st, "claim");
    ck_assert(found);
    ck_assert_int_eq(first.batch, second.batch);
    ck_assert_int_eq(first.attempt, second.attempt);
    store_must(pen_store_claim(bed.store, "v", 1000, 8, &second, &found, &st), &st, "claim");
    ck_assert_int_ne(first.batch, second.batch);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE(
    "store commit",
    test_commit__the_last_batch_of_a_view_adds_the_assemble_batch_and_the_last_view_ends_the_job,
    test_commit__repeated_changes_nothing_and_stale_is_refused,
    test_commit__a_part_leaves_the_other_tiles_as_an_open_batch,
    test_commit__a_claim_repeated_with_its_serial_gets_the_same_batch)
