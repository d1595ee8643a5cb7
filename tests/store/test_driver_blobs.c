/* SPDX-License-Identifier: MIT */
/* Contract of a driver: blobs, which are written and read in ranges, and lists, which are read in
 * pages. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/driver.h"
#include "support/random.h"

static struct driver_bed bed;

enum { RANGE = PEN_BLOB_RANGE_BYTES, LARGEST = 3 * RANGE + 17 };

static const size_t sizes[] = {0, 1, 4096, RANGE - 1, RANGE, RANGE + 1, 2 * RANGE, LARGEST};
enum { SIZES = sizeof sizes / sizeof sizes[0] };

static unsigned char sent[LARGEST], got[LARGEST];

static void fill(uint64_t seed)
{
    struct random random = random_begin(seed);
    for (size_t i = 0; i < LARGEST; i++)
        sent[i] = (unsigned char)random_bits(&random);
}

static struct pen_blob_start start_of(size_t bytes)
{
    return (struct pen_blob_start){
        .total = bytes, .data = sent, .bytes = bytes < RANGE ? bytes : RANGE};
}

static void write_rest(enum pen_blob_kind kind, int64_t number, size_t bytes)
{
    for (size_t at = RANGE; at < bytes; at += RANGE) {
        size_t left = bytes - at;
        DRIVER_DO(bed.driver, blob_write, kind, number, at, sent + at, left < RANGE ? left : RANGE);
    }
}

/* Stores what was sent as a blob of a new job n; returns its number. */
static int64_t store_blob(enum pen_blob_kind kind, int n, size_t bytes)
{
    struct driver_job job = driver_submit_new(bed.driver, n, 1, 1, 0);
    struct pen_blob_start start = start_of(bytes);
    struct pen_artefact_key key = {job.number, 0, "beauty", "pfm"};
    unsigned char hash[32] = {200, (unsigned char)n};
    int64_t number = job.batch[0];
    bool added = true;
    DRIVER_RUN(bed.driver, begin_write);
    switch (kind) {
    case PEN_BLOB_SCENE:
        DRIVER_DO(bed.driver, scene_add, hash, &start, &number, &added);
        break;
    case PEN_BLOB_PIXELS:
        DRIVER_DO(bed.driver, pixels_add, number, &start);
        break;
    case PEN_BLOB_ARTEFACT:
        DRIVER_DO(bed.driver, artefact_put, &key, -9, &start, &number);
        break;
    }
    ck_assert(added);
    write_rest(kind, number, bytes);
    DRIVER_RUN(bed.driver, commit);
    return number;
}

static void read_range(enum pen_blob_kind kind, int64_t number, size_t at, size_t bytes)
{
    memset(got, 0, bytes);
    DRIVER_DO(bed.driver, blob_read, kind, number, at, got, bytes);
    ck_assert_mem_eq(got, sent + at, bytes);
}

static void refuse_range(enum pen_blob_kind kind, int64_t number, size_t at, size_t bytes,
                         enum pen_code code)
{
    struct pen_status st = {0};
    ck_assert(!bed.driver->ops->blob_read(bed.driver, kind, number, at, got, bytes, &st));
    ck_assert_msg(st.code == code, "%s", st.msg);
}

/* The whole in ranges, single bytes at the edges, and what lies beyond the end. */
static void check_blob(enum pen_blob_kind kind, int64_t number, size_t bytes)
{
    static const size_t edges[] = {0, 1, RANGE - 1, RANGE, RANGE + 1, 2 * RANGE - 1, 2 * RANGE};
    for (size_t at = 0; at < bytes; at += RANGE)
        read_range(kind, number, at, bytes - at < RANGE ? bytes - at : RANGE);
    for (size_t i = 0; i < sizeof edges / sizeof edges[0]; i++) {
        if (edges[i] < bytes)
            read_range(kind, number, edges[i], 1);
    }
    if (bytes > RANGE + 100)
        read_range(kind, number, RANGE - 100, 200); /* across an edge of the ranges written */
    if (bytes > 0)
        read_range(kind, number, bytes - 1, 1);
    refuse_range(kind, number, bytes, 1, PEN_STORAGE);
    refuse_range(kind, number, bytes ? bytes - 1 : 0, 2, PEN_STORAGE);
    refuse_range(kind, number, (size_t)LARGEST * 2, 1, PEN_STORAGE);
}

static void check_kind(int driver, enum pen_blob_kind kind)
{
    int64_t number[SIZES];
    driver_bed_open(&bed, driver);
    fill(11);
    for (int i = 0; i < SIZES; i++)
        number[i] = store_blob(kind, i, sizes[i]);
    for (int i = 0; i < SIZES; i++)
        check_blob(kind, number[i], sizes[i]);
    refuse_range(kind, 987654, 0, 1, PEN_NOT_FOUND);
    driver_bed_close(&bed);
}

START_TEST(test_driver_blobs__scenes_are_read_as_written)
{
    check_kind(_i, PEN_BLOB_SCENE);
}
END_TEST

START_TEST(test_driver_blobs__pixels_are_read_as_written)
{
    check_kind(_i, PEN_BLOB_PIXELS);
}
END_TEST

START_TEST(test_driver_blobs__artefacts_are_read_as_written)
{
    check_kind(_i, PEN_BLOB_ARTEFACT);
}
END_TEST

START_TEST(test_driver_blobs__range_that_is_written_again_is_replaced_alone)
{
    driver_bed_open(&bed, _i);
    fill(12);
    int64_t number = store_blob(PEN_BLOB_ARTEFACT, 1, 2 * RANGE);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, blob_write, PEN_BLOB_ARTEFACT, number, RANGE - 3, "abcdef", 6);
    DRIVER_RUN(bed.driver, commit);
    memcpy(sent + RANGE - 3, "abcdef", 6);
    check_blob(PEN_BLOB_ARTEFACT, number, 2 * RANGE);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__range_beyond_the_end_is_not_written)
{
    struct pen_status st;
    driver_bed_open(&bed, _i);
    fill(13);
    int64_t number = store_blob(PEN_BLOB_ARTEFACT, 1, 100);
    DRIVER_RUN(bed.driver, begin_write);
    ck_assert(
        !bed.driver->ops->blob_write(bed.driver, PEN_BLOB_ARTEFACT, number, 99, "ab", 2, &st));
    bed.driver->ops->rollback(bed.driver);
    check_blob(PEN_BLOB_ARTEFACT, number, 100);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__unfinished_blob_is_rolled_back)
{
    struct pen_artefact_key key = {.layer = "beauty", .format = "pfm"};
    struct pen_blob_start start = start_of(LARGEST);
    struct pen_artefact_row row;
    int64_t number;
    bool found;
    driver_bed_open(&bed, _i);
    key.job = driver_submit_new(bed.driver, 1, 1, 1, 0).number;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, artefact_put, &key, 1, &start, &number);
    DRIVER_DO(bed.driver, blob_write, PEN_BLOB_ARTEFACT, number, RANGE, sent, RANGE);
    bed.driver->ops->rollback(bed.driver);
    DRIVER_DO(bed.driver, artefact_find, &key, &row, &found);
    ck_assert(!found);
    refuse_range(PEN_BLOB_ARTEFACT, number, 0, 1, PEN_NOT_FOUND);
    driver_bed_close(&bed);
}
END_TEST

static int64_t put(const struct pen_artefact_key *key, int64_t checksum, size_t bytes)
{
    struct pen_blob_start start = start_of(bytes);
    int64_t number = 0;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, artefact_put, key, checksum, &start, &number);
    write_rest(PEN_BLOB_ARTEFACT, number, bytes);
    DRIVER_RUN(bed.driver, commit);
    return number;
}

static void expect_artefact(const struct pen_artefact_key *key, int64_t number, int64_t checksum,
                            size_t bytes)
{
    struct pen_artefact_row row;
    bool found = false;
    DRIVER_DO(bed.driver, artefact_find, key, &row, &found);
    ck_assert(found);
    ck_assert_int_eq(row.number, number);
    ck_assert(row.has_checksum);
    ck_assert_int_eq(row.checksum, checksum);
    ck_assert_uint_eq(row.bytes, bytes);
    check_blob(PEN_BLOB_ARTEFACT, number, bytes);
}

START_TEST(test_driver_blobs__artefact_is_replaced_by_another_of_its_key)
{
    driver_bed_open(&bed, _i);
    int64_t job = driver_submit_new(bed.driver, 1, 2, 1, 0).number;
    const struct pen_artefact_key key = {job, 0, "beauty", "pfm"};
    const struct pen_artefact_key others[] = {{job, 1, "beauty", "pfm"},
                                              {job, -1, "beauty", "pfm"},
                                              {job, 0, "depth", "pfm"},
                                              {job, 0, "beauty", "png"}};
    struct pen_artefact_row row;
    int64_t other[4];
    bool found = true;
    DRIVER_DO(bed.driver, artefact_find, &key, &row, &found);
    ck_assert(!found);
    fill(14);
    for (int i = 0; i < 4; i++)
        other[i] = put(&others[i], 40 + i, (size_t)10 + (size_t)i);
    put(&key, INT64_MIN, RANGE + 5);
    fill(15);
    int64_t number = put(&key, INT64_MAX, 20);
    expect_artefact(&key, number, INT64_MAX, 20);
    number = put(&key, -1, 2 * RANGE + 7);
    expect_artefact(&key, number, -1, 2 * RANGE + 7);
    fill(14);
    for (int i = 0; i < 4; i++)
        expect_artefact(&others[i], other[i], 40 + i, (size_t)10 + (size_t)i);
    driver_bed_close(&bed);
}
END_TEST

/* A large object of so many bytes of what was sent, in a transaction of its own. */
static int64_t store_object(size_t bytes)
{
    int64_t object;
    bool there;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, object_add, bytes, &object);
    for (size_t at = 0; at < bytes; at += RANGE) {
        const size_t left = bytes - at;
        DRIVER_DO(bed.driver, object_write, object, at, sent + at, left < RANGE ? left : RANGE,
                  1000, &there);
        ck_assert(there);
    }
    DRIVER_RUN(bed.driver, commit);
    return object;
}

static int64_t put_object(const struct pen_artefact_key *key, int64_t object, size_t bytes)
{
    const struct pen_blob_start start = {.total = bytes, .object = object};
    int64_t number = 0;
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, artefact_put, key, 5, &start, &number);
    DRIVER_RUN(bed.driver, commit);
    return number;
}

static bool is_unused_or_after(int64_t before_ms, int64_t after_ms, int64_t object)
{
    int64_t number = 0;
    bool found = false;
    DRIVER_DO(bed.driver, object_unused, before_ms, after_ms, &number, &found);
    ck_assert(!found || number == object);
    return found;
}

static bool is_unused(int64_t before_ms, int64_t object)
{
    return is_unused_or_after(before_ms, INT64_MAX, object);
}

static int64_t released_bytes(void)
{
    int64_t bytes = -1;
    DRIVER_DO(bed.driver, object_released_bytes, &bytes);
    return bytes;
}

/* Removes it; returns in how many slices of a range. */
static int shrink(int64_t object)
{
    int slices = 0;
    for (; is_unused(1, object); slices++) {
        const int64_t before = released_bytes();
        DRIVER_RUN(bed.driver, begin_write);
        DRIVER_DO(bed.driver, object_shrink, object, RANGE);
        DRIVER_RUN(bed.driver, commit);
        ck_assert(released_bytes() < before || before == 0);
    }
    return slices;
}

START_TEST(test_driver_blobs__large_object_is_the_value_of_its_row_and_goes_with_it)
{
    driver_bed_open(&bed, _i);
    fill(17);
    const int64_t job = driver_submit_new(bed.driver, 1, 2, 1, 0).number;
    const struct pen_artefact_key key = {job, 0, "beauty", "pfm"}, layer = key;
    const int64_t object = store_object(LARGEST);
    ck_assert(is_unused(1001, object) && !is_unused(1000, object));
    ck_assert(is_unused_or_after(1, 999, object) && !is_unused_or_after(1, 1000, object));
    const int64_t number = put_object(&key, object, LARGEST);
    expect_artefact(&key, number, 5, LARGEST);
    ck_assert(!is_unused(INT64_MAX, object));
    const int64_t other = store_object(2 * RANGE);
    ck_assert_int_eq(put_object(&key, other, 2 * RANGE), number);
    expect_artefact(&key, number, 5, 2 * RANGE);
    ck_assert_int_eq(released_bytes(), LARGEST);
    ck_assert_int_gt(shrink(object), LARGEST / RANGE);
    ck_assert_int_eq(released_bytes(), 0);
    expect_artefact(&key, number, 5, 2 * RANGE);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, artefacts_drop, &layer);
    DRIVER_RUN(bed.driver, commit);
    ck_assert_int_gt(shrink(other), 1);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__large_object_that_was_removed_takes_no_more)
{
    struct pen_blob_start removed = {.total = RANGE};
    struct pen_status st;
    int64_t number;
    bool there = true;
    driver_bed_open(&bed, _i);
    const struct driver_job job = driver_submit_new(bed.driver, 1, 1, 1, 0);
    const struct pen_artefact_key key = {job.number, 0, "beauty", "pfm"};
    removed.object = store_object(RANGE);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, object_release, removed.object);
    DRIVER_DO(bed.driver, object_write, removed.object, RANGE, sent, RANGE, 1000, &there);
    ck_assert(!there);
    ck_assert(!bed.driver->ops->artefact_put(bed.driver, &key, 5, &removed, &number, &st));
    ck_assert_int_eq(st.code, PEN_UNAVAILABLE);
    bed.driver->ops->rollback(bed.driver);
    DRIVER_RUN(bed.driver, begin_write);
    ck_assert(!bed.driver->ops->pixels_add(
        bed.driver, job.batch[0], &(struct pen_blob_start){.total = 1, .object = 99}, &st));
    bed.driver->ops->rollback(bed.driver);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__artefacts_of_a_layer_are_dropped_together)
{
    driver_bed_open(&bed, _i);
    const int64_t job = driver_submit_new(bed.driver, 1, 2, 1, 0).number;
    const struct pen_artefact_key layer = {.job = job, .view = 0, .layer = "depth"};
    const struct pen_artefact_key gone[] = {{job, 0, "depth", "pfm"}, {job, 0, "depth", "png"}};
    const struct pen_artefact_key left[] = {{job, 1, "depth", "pfm"}, {job, 0, "beauty", "pfm"}};
    struct pen_artefact_row row;
    int64_t number[2];
    bool found = true;
    fill(16);
    for (int i = 0; i < 2; i++) {
        put(&gone[i], i, RANGE + 3);
        number[i] = put(&left[i], i, 30);
    }
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, artefacts_drop, &layer);
    DRIVER_DO(bed.driver, artefacts_drop, &layer); /* nothing is there */
    DRIVER_RUN(bed.driver, commit);
    for (int i = 0; i < 2; i++) {
        DRIVER_DO(bed.driver, artefact_find, &gone[i], &row, &found);
        ck_assert(!found);
        expect_artefact(&left[i], number[i], i, 30);
    }
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, job_artefacts_drop, job, "depth");
    DRIVER_RUN(bed.driver, commit);
    DRIVER_DO(bed.driver, artefact_find, &left[0], &row, &found);
    ck_assert(!found);
    expect_artefact(&left[1], number[1], 1, 30);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__scene_of_a_job_is_found)
{
    struct store_job in;
    int64_t number;
    size_t bytes;
    bool found;
    driver_bed_open(&bed, _i);
    store_job_init(&in, 5, 1, 1);
    struct driver_job job = driver_submit(bed.driver, &in);
    DRIVER_DO(bed.driver, scene_of_job, in.id, &number, &bytes, &found);
    ck_assert(found);
    ck_assert_int_eq(number, job.scene);
    ck_assert_uint_eq(bytes, strlen(in.scene));
    DRIVER_DO(bed.driver, scene_of_job, "nobody", &number, &bytes, &found);
    ck_assert(!found);
    driver_bed_close(&bed);
}
END_TEST

/* Leases and commits batch i of a job with so many bytes of pixels. */
static void commit_batch(const struct driver_job *job, int i, size_t bytes)
{
    struct pen_blob_start start = start_of(bytes);
    char stats[32];
    bool changed = false;
    snprintf(stats, sizeof stats, "{\"batch\": %d}", i);
    driver_lease(bed.driver, job->batch[i], 1, "w", 1000);
    DRIVER_RUN(bed.driver, begin_write);
    DRIVER_DO(bed.driver, batch_done, job->batch[i], 1,
              &(struct pen_batch_end){stats, 70 + i, 7 + i}, &changed);
    DRIVER_DO(bed.driver, pixels_add, job->batch[i], &start);
    DRIVER_RUN(bed.driver, commit);
    ck_assert(changed);
}

START_TEST(test_driver_blobs__pixels_of_a_view_are_listed_in_order)
{
    struct pen_pixels_row rows[4];
    int count = -1;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 2, 4, 0);
    for (int i = 3; i >= 1; i--) /* of the first view: the last three, in the other order */
        commit_batch(&job, i, (size_t)10 * (size_t)i);
    commit_batch(&job, 5, 99);
    DRIVER_DO(bed.driver, pixels_page, job.number, 0, 0, rows, 4, &count);
    ck_assert_int_eq(count, 3);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(rows[i].batch, job.batch[i + 1]);
        ck_assert_int_eq(rows[i].first_tile, i + 1);
        ck_assert_int_eq(rows[i].tile_count, 1);
        ck_assert_int_eq(rows[i].pixels, 16);
        ck_assert_uint_eq(rows[i].bytes, (size_t)10 * (size_t)(i + 1));
    }
    DRIVER_DO(bed.driver, pixels_page, job.number, 0, job.batch[1], rows, 1, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(rows[0].batch, job.batch[2]);
    DRIVER_DO(bed.driver, pixels_page, job.number, 0, job.batch[3], rows, 4, &count);
    ck_assert_int_eq(count, 0);
    DRIVER_DO(bed.driver, pixels_page, job.number, 1, 0, rows, 4, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(rows[0].batch, job.batch[5]);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__statistics_are_listed_in_order)
{
    struct pen_stats_row rows[4];
    struct pen_arena *arena = pen_arena_new(0);
    int count = -1;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 1, 4, 0);
    commit_batch(&job, 2, 1);
    commit_batch(&job, 0, 1);
    DRIVER_DO(bed.driver, stats_page, job.number, 0, arena, rows, 4, &count);
    ck_assert_int_eq(count, 2);
    ck_assert_int_eq(rows[0].batch, job.batch[0]);
    ck_assert_str_eq(rows[0].stats.stats, "{\"batch\": 0}");
    ck_assert_int_eq(rows[0].stats.commit_us, 7);
    ck_assert_int_eq(rows[0].stats.view, 0);
    ck_assert_int_eq(rows[0].stats.kind, PEN_BATCH_RENDER);
    ck_assert_str_eq(rows[1].stats.stats, "{\"batch\": 2}");
    DRIVER_DO(bed.driver, stats_page, job.number, job.batch[0], arena, rows, 4, &count);
    ck_assert_int_eq(count, 1);
    DRIVER_DO(bed.driver, stats_page, job.number, 0, arena, rows, 1, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(rows[0].batch, job.batch[0]);
    pen_arena_free(arena);
    driver_bed_close(&bed);
}
END_TEST

START_TEST(test_driver_blobs__batches_are_listed_with_their_holders)
{
    struct pen_batch_record rows[8];
    struct pen_arena *arena = pen_arena_new(0);
    int count = -1;
    driver_bed_open(&bed, _i);
    struct driver_job job = driver_submit_new(bed.driver, 1, 2, 2, 0);
    driver_submit_new(bed.driver, 2, 1, 1, 0);
    commit_batch(&job, 0, 1);
    driver_lease(bed.driver, job.batch[2], 6, "w", 1000);
    DRIVER_DO(bed.driver, batch_page, job.number, 0, arena, rows, 8, &count);
    ck_assert_int_eq(count, 4);
    for (int i = 0; i < 4; i++) {
        ck_assert_int_eq(rows[i].batch, job.batch[i]);
        ck_assert_int_eq(rows[i].view, i / 2);
        ck_assert_int_eq(rows[i].first_tile, i % 2);
        ck_assert_int_eq(rows[i].tile_count, 1);
        ck_assert_int_eq(rows[i].pixels, 16);
        ck_assert_int_eq(rows[i].kind, PEN_BATCH_RENDER);
        ck_assert(!rows[i].quarantined);
        ck_assert_int_eq(rows[i].worker != NULL, i == 2);
    }
    ck_assert_str_eq(rows[2].worker, "w");
    ck_assert_int_eq(rows[2].attempt, 6);
    ck_assert_int_eq(rows[0].state, PEN_BATCH_DONE);
    ck_assert_int_eq(rows[1].state, PEN_BATCH_OPEN);
    ck_assert_int_eq(rows[2].state, PEN_BATCH_LEASED);
    DRIVER_DO(bed.driver, batch_page, job.number, job.batch[1], arena, rows, 1, &count);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(rows[0].batch, job.batch[2]);
    pen_arena_free(arena);
    driver_bed_close(&bed);
}
END_TEST

DRIVER_SUITE("driver: blobs", test_driver_blobs__scenes_are_read_as_written,
             test_driver_blobs__pixels_are_read_as_written,
             test_driver_blobs__artefacts_are_read_as_written,
             test_driver_blobs__range_that_is_written_again_is_replaced_alone,
             test_driver_blobs__range_beyond_the_end_is_not_written,
             test_driver_blobs__unfinished_blob_is_rolled_back,
             test_driver_blobs__artefact_is_replaced_by_another_of_its_key,
             test_driver_blobs__large_object_is_the_value_of_its_row_and_goes_with_it,
             test_driver_blobs__large_object_that_was_removed_takes_no_more,
             test_driver_blobs__artefacts_of_a_layer_are_dropped_together,
             test_driver_blobs__scene_of_a_job_is_found,
             test_driver_blobs__pixels_of_a_view_are_listed_in_order,
             test_driver_blobs__statistics_are_listed_in_order,
             test_driver_blobs__batches_are_listed_with_their_holders)
