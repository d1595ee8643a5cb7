/* SPDX-License-Identifier: MIT */
/* Large values: no transaction writes much of one, readers see it whole or not at all, and what is
 * left of one that was replaced, removed or never finished goes in slices. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/random.h"
#include "support/store_sql.h"
#include "support/suite.h"

enum { MIB = 1 << 20, LARGE = 5 * MIB + 17, WIDTH = 640, HEIGHT = 480, PIXELS = WIDTH * HEIGHT };

static struct store_bed bed;
static struct store_job job;
static struct pen_claim claim;
static int64_t time_ms;
static char *noise;

/* A store with a job of one batch, which is leased. */
static void open_bed(void)
{
    struct random random = random_begin(7);
    time_ms = INT64_C(1800000000000);
    noise = malloc(2 * LARGE);
    for (size_t i = 0; i < 2 * LARGE; i++)
        noise[i] = (char)random_bits(&random);
    store_bed_open(&bed);
    store_bed_set_clock(&bed, &time_ms);
    store_job_init(&job, 1, 1, 1);
    job.view[0].width = WIDTH;
    job.view[0].height = HEIGHT;
    job.batch[0].pixels = PIXELS;
    store_job_submit(bed.store, &job);
    claim = store_claim(bed.store, "w");
}

static void close_bed(void)
{
    free(noise);
    store_bed_close(&bed);
}

/* The number of write transactions that handles have made. */
static int64_t writes(void)
{
    const struct pen_histogram h = pen_store_timing(bed.store, PEN_TIMING_WRITE);
    int64_t sum = 0;
    for (int i = 0; i <= PEN_TIMING_BUCKETS; i++)
        sum += (int64_t)h.count[i];
    return sum;
}

static bool keep(const char *data, size_t bytes, struct pen_status *st)
{
    const struct pen_kept kept = {.data = data, .bytes = bytes};
    bool outranked;
    return pen_store_keep(bed.store, &claim, &kept, &outranked, st);
}

static void expect_kept(const char *data, size_t bytes)
{
    struct pen_buf out = {0};
    struct pen_status st;
    store_must(pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &out, &st), &st, "kept");
    ck_assert_uint_eq(out.bytes, bytes);
    ck_assert(memcmp(out.data, data, bytes) == 0);
    pen_buf_release(&out);
}

static void expect_objects_gone(void)
{
    store_purge_slices(bed.store);
    store_run_sql(&bed, "SELECT id FROM large_object", NULL, 0); /* which gives no row */
    store_run_sql(&bed, "SELECT object FROM large_object_part", NULL, 0);
}

START_TEST(test_values__are_written_in_several_transactions)
{
    struct pen_status st;
    open_bed();
    int64_t before = writes();
    store_must(keep(noise, LARGE, &st), &st, "keep");
    ck_assert_int_ge(writes() - before, LARGE / MIB);
    before = writes();
    store_must(pen_store_cache_put(bed.store, job.id, 0, "beauty", "pfm", noise, LARGE, &st), &st,
               "form");
    ck_assert_int_ge(writes() - before, LARGE / MIB);
    before = writes();
    store_must(pen_store_artefact_put(bed.store, &claim, "depth", "pfm", noise, LARGE, &st), &st,
               "picture");
    ck_assert_int_ge(writes() - before, LARGE / MIB);
    before = writes();
    store_must(keep(noise, 100, &st), &st, "keep");
    ck_assert_int_eq(writes() - before, 1); /* a small one needs no more */
    close_bed();
}
END_TEST

START_TEST(test_values__one_replaces_another_at_once_and_that_goes_in_slices)
{
    struct pen_status st;
    open_bed();
    store_must(keep(noise, LARGE, &st), &st, "keep");
    expect_kept(noise, LARGE);
    store_must(keep(noise + LARGE, LARGE - 1, &st), &st, "keep");
    expect_kept(noise + LARGE, LARGE - 1);
    store_audit_clean(bed.store);
    ck_assert_int_gt(store_purge_slices(bed.store), 1);
    expect_kept(noise + LARGE, LARGE - 1);
    store_must(keep("small", 5, &st), &st, "keep");
    expect_kept("small", 5);
    expect_objects_gone();
    close_bed();
}
END_TEST

START_TEST(test_values__of_a_lost_claim_are_refused_and_leave_nothing)
{
    struct pen_status st;
    open_bed();
    store_must(keep(noise, LARGE, &st), &st, "keep");
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    const struct pen_claim again = store_claim(bed.store, "v");
    ck_assert(!keep(noise + LARGE, LARGE, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    claim = again;
    expect_kept(noise, LARGE);
    store_must(keep("small", 5, &st), &st, "keep");
    expect_objects_gone();
    close_bed();
}
END_TEST

static void end_by_cancel(void)
{
    struct pen_status st;
    store_must(pen_store_cancel(bed.store, job.id, NULL, &st), &st, "cancel");
}

static void end_by_fail(void)
{
    struct pen_status st;
    store_must(pen_store_fail(bed.store, &claim, "{}", &st), &st, "fail");
}

static char *death_error(void *user, const struct pen_claim *held, int charges)
{
    (void)user, (void)held, (void)charges;
    return strdup("{}");
}

static void end_by_crashes(void)
{
    const struct pen_worker_death death = {
        .worker = "w", .end = PEN_WORKER_CRASHED, .error = death_error};
    struct pen_status st;
    int opened;
    for (int i = 0; i < job.job.max_attempts; i++) {
        if (i > 0)
            claim = store_claim(bed.store, "w");
        store_must(pen_store_worker_ended(bed.store, &death, &opened, &st), &st, "death");
    }
}

/* What was kept goes with the job's end, and the worker that goes on for a while keeps no more. */
START_TEST(test_values__kept_by_a_job_go_when_it_is_cancelled_or_fails)
{
    static void (*const ends[])(void) = {end_by_cancel, end_by_fail, end_by_crashes};
    static const char *const names[] = {PEN_KEPT_STATE, "part"};
    for (int i = 0; i < 3; i++) {
        struct pen_status st;
        struct pen_buf out = {0};
        bool outranked;
        open_bed();
        const struct pen_kept_part part = {"part", noise, LARGE};
        const struct pen_kept kept = {.data = "state", .bytes = 5, .parts = &part, .part_count = 1};
        store_must(pen_store_keep(bed.store, &claim, &kept, &outranked, &st), &st, "keep");
        ends[i]();
        ck_assert(pen_job_state_ended(store_job_state(bed.store, job.id)));
        for (int tries = 0; tries < 2; tries++) {
            for (int k = 0; k < 2; k++) {
                ck_assert(!pen_store_kept(bed.store, &claim, names[k], &out, &st));
                ck_assert_int_eq(st.code, PEN_NOT_FOUND);
            }
            expect_objects_gone();
            ck_assert(!pen_store_keep(bed.store, &claim, &kept, &outranked, &st));
            ck_assert_int_eq(st.code, PEN_STALE);
        }
        close_bed();
    }
}
END_TEST

static void expect_layer(const void *data, size_t bytes)
{
    struct pen_buf out = {0};
    struct pen_status st;
    store_must(pen_store_artefact(bed.store, job.id, 0, "depth", "pfm", &out, &st), &st, "layer");
    ck_assert_uint_eq(out.bytes, bytes);
    ck_assert(memcmp(out.data, data, bytes) == 0);
    pen_buf_release(&out);
}

/* A worker that was stopped, whose batch another has committed, comes back with its layer. A small
 * one is refused by the transaction of its row, a large one by that of its first range. */
START_TEST(test_values__layers_of_a_lost_claim_are_refused_and_change_no_ended_job)
{
    static const size_t sizes[] = {5, LARGE};
    struct pen_status st;
    open_bed();
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    const struct pen_claim again = store_claim(bed.store, "v");
    store_must(pen_store_artefact_put(bed.store, &again, "depth", "pfm", noise, LARGE, &st), &st,
               "put");
    for (int ended = 0; ended < 2; ended++) {
        for (int i = 0; i < 2; i++) {
            const char *late = noise + LARGE;
            ck_assert(
                !pen_store_artefact_put(bed.store, &claim, "depth", "pfm", late, sizes[i], &st));
            ck_assert_int_eq(st.code, PEN_STALE);
            expect_layer(noise, LARGE);
            ck_assert_int_eq(store_purge_slices(bed.store), 0); /* nothing was written */
        }
        if (!ended)
            ck_assert_int_eq(store_commit(bed.store, &again), PEN_OK);
    }
    close_bed();
}
END_TEST

/* What a process that was killed has left. */
START_TEST(test_values__that_were_not_finished_go_after_a_minute)
{
    open_bed();
    char sql[120];
    snprintf(sql, sizeof sql, "INSERT INTO large_object (bytes, expires_ms) VALUES (9999, %lld)",
             (long long)time_ms + 60000);
    store_run_sql(&bed, sql, NULL, 0);
    store_run_sql(&bed, "INSERT INTO large_object_part SELECT id, 0, ? FROM large_object", noise,
                  MIB);
    time_ms += 60000;
    ck_assert_int_eq(store_purge_slices(bed.store), 0);
    time_ms++;
    ck_assert_int_gt(store_purge_slices(bed.store), 0);
    expect_objects_gone();
    /* by a clock that was an hour ahead when it was killed */
    snprintf(sql, sizeof sql, "INSERT INTO large_object (bytes, expires_ms) VALUES (9999, %lld)",
             (long long)time_ms + 3600000);
    store_run_sql(&bed, sql, NULL, 0);
    store_run_sql(&bed, "INSERT INTO large_object_part SELECT id, 0, ? FROM large_object", noise,
                  MIB);
    ck_assert_int_gt(store_purge_slices(bed.store), 0);
    expect_objects_gone();
    close_bed();
}
END_TEST

static bool compare(void *user, int first_tile, int tile_count, const float *rgb, int64_t pixels)
{
    (void)tile_count;
    ck_assert_int_eq(first_tile, 0);
    ck_assert_int_eq(pixels, PIXELS);
    ck_assert(memcmp(rgb, user, (size_t)pixels * 3 * sizeof *rgb) == 0);
    return true;
}

START_TEST(test_values__of_a_commit_are_read_back_and_go_with_their_job)
{
    static float rgb[3 * PIXELS];
    struct random random = random_begin(3);
    struct pen_status st;
    struct pen_buf out = {0};
    open_bed();
    for (size_t i = 0; i < 3 * PIXELS; i++)
        rgb[i] = (float)(random_bits(&random) >> 40);
    const struct pen_result result = {.rgb = rgb,
                                      .pixels = PIXELS,
                                      .stats = "{}",
                                      .layer = "beauty",
                                      .format = "png",
                                      .artefact = noise,
                                      .artefact_bytes = LARGE};
    store_must(keep(noise, LARGE, &st), &st, "keep");
    const int64_t before = writes();
    store_must(pen_store_commit(bed.store, &claim, &result, &st), &st, "commit");
    ck_assert_int_gt(writes() - before, LARGE / MIB + 2); /* the pixels are large, too */
    store_must(pen_store_commit(bed.store, &claim, &result, &st), &st, "commit again");
    store_must(pen_store_pixels(bed.store, job.id, 0, compare, rgb, &st), &st, "pixels");
    store_must(pen_store_artefact(bed.store, job.id, 0, "beauty", "png", &out, &st), &st,
               "picture");
    ck_assert_uint_eq(out.bytes, LARGE);
    ck_assert(memcmp(out.data, noise, LARGE) == 0);
    pen_buf_release(&out);
    struct pen_scrub scrub = {0};
    for (bool more = true; more;)
        store_must(pen_store_scrub(bed.store, &scrub, &more, &st), &st, "scrub");
    ck_assert_uint_eq(pen_store_tally(bed.store, PEN_TALLY_DAMAGED), 0);
    store_purge_slices(bed.store); /* what was kept */
    store_audit_clean(bed.store);
    store_must(pen_store_delete(bed.store, job.id, NULL, NULL, &st), &st, "delete");
    expect_objects_gone();
    close_bed();
}
END_TEST

START_TEST(test_values__damage_in_a_part_is_noticed)
{
    struct pen_status st;
    struct pen_buf out = {0};
    open_bed();
    store_must(keep(noise, LARGE, &st), &st, "keep");
    store_run_sql(&bed, "UPDATE large_object_part SET data = ? WHERE part = 2", noise, MIB);
    ck_assert(!pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &out, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    store_run_sql(&bed, "DELETE FROM large_object_part WHERE part = 2", NULL, 0);
    ck_assert(!pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &out, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    pen_buf_release(&out);
    store_must(keep("small", 5, &st), &st, "keep");
    expect_objects_gone();
    close_bed();
}
END_TEST

PEN_SUITE("large values", test_values__are_written_in_several_transactions,
          test_values__one_replaces_another_at_once_and_that_goes_in_slices,
          test_values__of_a_lost_claim_are_refused_and_leave_nothing,
          test_values__kept_by_a_job_go_when_it_is_cancelled_or_fails,
          test_values__layers_of_a_lost_claim_are_refused_and_change_no_ended_job,
          test_values__that_were_not_finished_go_after_a_minute,
          test_values__of_a_commit_are_read_back_and_go_with_their_job,
          test_values__damage_in_a_part_is_noticed)
