/* SPDX-License-Identifier: MIT */
/* Objects: pixels, statistics, commits, artefacts of any length, what a batch keeps, the scene.
 * Slices remove all of them with their job. */
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/suite.h"

enum { LONG_BYTES = (5 << 20) + 3 };

static struct store_bed bed;
static struct store_job job;
static struct pen_status st;

static void begin(int views, int batches)
{
    store_bed_open(&bed);
    store_job_init(&job, 1, views, batches);
    store_job_submit(bed.store, &job);
}

static unsigned char *long_value(unsigned seed)
{
    unsigned char *data = malloc(LONG_BYTES);
    for (size_t i = 0; i < LONG_BYTES; i++)
        data[i] = (unsigned char)((seed = seed * 1664525 + 1013904223) >> 24);
    return data;
}

static bool count_pixels(void *user, int first_tile, int tile_count, const float *rgb,
                         int64_t pixels)
{
    int *next = user;
    ck_assert_int_eq(first_tile, *next);
    ck_assert_int_eq(pixels, tile_count * STORE_JOB_TILE * STORE_JOB_TILE);
    ck_assert_ptr_nonnull(rgb);
    *next += tile_count;
    return true;
}

static bool count_stats(void *user, const struct pen_batch_stats *batch)
{
    ck_assert_int_eq(batch->stats[0], '{');
    ++*(int *)user;
    return true;
}

static bool count_commits(void *user, const struct pen_commit_record *commit)
{
    int64_t *last = user;
    ck_assert_int_gt(commit->revision, *last);
    *last = commit->revision;
    return true;
}

START_TEST(test_results__what_was_committed_is_read_in_order)
{
    int next = 0, stats = 0;
    int64_t last = 0;
    struct pen_buf scene = {0};
    begin(1, 3);
    ck_assert_int_eq(store_work_off(bed.store, "w"), 4);
    store_must(pen_store_pixels(bed.store, job.id, 0, count_pixels, &next, &st), &st, "pixels");
    ck_assert_int_eq(next, 3);
    store_must(pen_store_stats(bed.store, job.id, count_stats, &stats, &st), &st, "stats");
    ck_assert_int_eq(stats, 4);
    store_must(pen_store_commits(bed.store, job.id, 0, count_commits, &last, &st), &st, "commits");
    ck_assert_int_gt(last, 1);
    store_must(pen_store_scene(bed.store, job.id, &scene, &st), &st, "scene");
    ck_assert_uint_eq(scene.bytes, job.job.scene_bytes);
    ck_assert_mem_eq(scene.data, job.job.scene, scene.bytes);
    pen_buf_release(&scene);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_results__a_long_value_replaces_another_and_a_stale_claim_stores_none)
{
    unsigned char *data[2] = {long_value(1), long_value(2)};
    struct pen_buf out = {0};
    begin(1, 2);
    const struct pen_claim claim = store_claim(bed.store, "w");
    for (int i = 0; i < 2; i++) {
        store_must(
            pen_store_artefact_put(bed.store, &claim, "depth", "pfm", data[i], LONG_BYTES, &st),
            &st, "put");
        out.bytes = 0;
        store_must(pen_store_artefact(bed.store, job.id, 0, "depth", "pfm", &out, &st), &st, "get");
        ck_assert_uint_eq(out.bytes, LONG_BYTES);
        ck_assert_mem_eq(out.data, data[i], LONG_BYTES);
    }
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert(!pen_store_artefact_put(bed.store, &claim, "depth", "pfm", "x", 1, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    ck_assert(!pen_store_artefact_put(bed.store, &claim, "depth", "pfm", data[0], LONG_BYTES, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    ck_assert(!pen_store_artefact(bed.store, job.id, 0, "depth", "png", &out, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    pen_buf_release(&out);
    free(data[0]);
    free(data[1]);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_results__what_a_batch_keeps_is_read_by_the_next_holder)
{
    unsigned char *data = long_value(3);
    struct pen_buf out = {0};
    bool outranked;
    store_bed_open(&bed);
    store_study_init(&job, 1, 10);
    store_job_submit(bed.store, &job);
    struct pen_claim claim = store_claim(bed.store, "w");
    const struct pen_kept_part part = {"part", data, LONG_BYTES};
    const struct pen_kept kept = {
        .done = 4, .data = "state", .bytes = 5, .parts = &part, .part_count = 1};
    store_must(pen_store_keep(bed.store, &claim, &kept, &outranked, &st), &st, "keep");
    ck_assert(!outranked);
    store_must(pen_store_release(bed.store, &claim, &st), &st, "release");
    ck_assert(!pen_store_keep(bed.store, &claim, &kept, &outranked, &st));
    ck_assert_int_eq(st.code, PEN_STALE);
    claim = store_claim(bed.store, "v");
    store_must(pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &out, &st), &st, "kept");
    ck_assert_uint_eq(out.bytes, 5);
    out.bytes = 0;
    store_must(pen_store_kept(bed.store, &claim, "part", &out, &st), &st, "kept");
    ck_assert_uint_eq(out.bytes, LONG_BYTES);
    ck_assert_mem_eq(out.data, data, LONG_BYTES);
    ck_assert(!pen_store_kept(bed.store, &claim, "other", &out, &st));
    struct pen_job_record record = store_job_get(bed.store, job.id);
    ck_assert_int_eq(record.done_pixels, 4);
    pen_job_record_release(&record);
    pen_buf_release(&out);
    free(data);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_results__slices_remove_a_deleted_job_and_give_its_space_back)
{
    unsigned char *data = long_value(4);
    struct pen_counts before, full, after;
    bool more = true;
    int slices = 0;
    store_bed_open(&bed);
    store_must(pen_store_counts(bed.store, &before, &st), &st, "counts");
    store_job_init(&job, 1, 1, 3);
    store_job_submit(bed.store, &job);
    const struct pen_claim claim = store_claim(bed.store, "w");
    for (int i = 0; i < 4; i++) {
        const char layer[] = {(char)('a' + i), '\0'};
        store_must(pen_store_artefact_put(bed.store, &claim, layer, "pfm", data, LONG_BYTES, &st),
                   &st, "put");
    }
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_work_off(bed.store, "w");
    store_must(pen_store_counts(bed.store, &full, &st), &st, "counts");
    store_must(pen_store_delete(bed.store, job.id, NULL, "{}", &st), &st, "delete");
    while (more && slices++ < 1000)
        store_must(pen_store_purge(bed.store, &more, &st), &st, "purge");
    ck_assert_int_gt(slices, 6); /* 20 MiB in slices of 4 */
    ck_assert_int_lt(slices, 60);
    store_must(pen_store_counts(bed.store, &after, &st), &st, "counts");
    ck_assert_int_eq(after.jobs[PEN_JOB_SUCCEEDED], 0);
    struct pen_buf stats = {0};
    store_must(pen_store_removed_stats(bed.store, job.id, &stats, &st), &st, "stats");
    ck_assert_uint_eq(stats.bytes, 2);
    pen_buf_release(&stats);
    free(data);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store results", test_results__what_was_committed_is_read_in_order,
          test_results__a_long_value_replaces_another_and_a_stale_claim_stores_none,
          test_results__what_a_batch_keeps_is_read_by_the_next_holder,
          test_results__slices_remove_a_deleted_job_and_give_its_space_back)
