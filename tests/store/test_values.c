/* SPDX-License-Identifier: MIT */
/* Stored objects have a checksum, which every read checks. A damaged object is refused, wherever
 * the damage is, and the store serves all others. */
#include <stdlib.h>
#include <string.h>

#include "support/store.h"
#include "support/store_rows.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job;
static struct pen_claim claim;

static void put(const void *data, size_t bytes)
{
    struct pen_status st;
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 1);
    store_job_submit(bed.store, &job);
    claim = store_claim(bed.store, "w");
    store_must(pen_store_artefact_put(bed.store, &claim, "depth", "pfm", data, bytes, &st), &st,
               "put");
}

static bool get(struct pen_buf *out, struct pen_status *st)
{
    *out = (struct pen_buf){0};
    return pen_store_artefact(bed.store, job.id, 0, "depth", "pfm", out, st);
}

static void check_got(const void *data, size_t bytes)
{
    struct pen_status st;
    struct pen_buf out;
    store_must(get(&out, &st), &st, "get");
    ck_assert_uint_eq(out.bytes, bytes);
    ck_assert(bytes == 0 || memcmp(out.data, data, bytes) == 0);
    pen_buf_release(&out);
}

/* A value that is damaged is no fault of the database. */
static void check_refused(void)
{
    struct pen_status st;
    struct pen_buf out;
    ck_assert(!get(&out, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_msg(strstr(st.msg, "damaged") && strstr(st.msg, "depth pfm"), "%s", st.msg);
    ck_assert_int_eq(pen_store_failure(bed.store, &st), PEN_FAILURE_REFUSED);
    ck_assert(!pen_store_is_broken(bed.store, NULL));
    ck_assert_uint_eq(out.bytes, 0);
    pen_buf_release(&out);
}

/* Changes the stored bytes of the artefact. */
static void change(const void *data, size_t bytes)
{
    store_change(bed.url,
                 "UPDATE part SET data = $1 WHERE object = "
                 "(SELECT number FROM object WHERE layer = 'depth' AND state = 1)",
                 data, bytes);
}

START_TEST(test_values__every_changed_bit_is_noticed)
{
    unsigned char data[43];
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (unsigned char)(i * i);
    put(data, sizeof data);
    check_got(data, sizeof data);
    for (size_t bit = 0; bit < 8 * sizeof data; bit++) {
        data[bit / 8] ^= (unsigned char)(1 << bit % 8);
        change(data, sizeof data);
        check_refused();
        data[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    change(data, sizeof data);
    check_got(data, sizeof data);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_values__missing_and_added_bytes_are_noticed)
{
    static const unsigned char zeros[40];
    struct pen_status st;
    put(zeros, 24);
    for (size_t bytes = 0; bytes <= sizeof zeros; bytes++) {
        change(zeros, bytes);
        if (bytes != 24)
            check_refused();
    }
    store_must(pen_store_artefact_put(bed.store, &claim, "depth", "pfm", "new", 3, &st), &st,
               "put");
    check_got("new", 3);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_values__a_missing_part_and_parts_in_another_order_are_noticed)
{
    enum { BYTES = 3 << 20 };
    unsigned char *data = malloc(BYTES);
    for (size_t i = 0; i < BYTES; i++)
        data[i] = (unsigned char)(i >> 20);
    put(data, BYTES);
    check_got(data, BYTES);
    store_change(bed.url, "UPDATE part SET n = -n WHERE n > 0", NULL, 0);
    check_refused();
    store_change(bed.url, "DELETE FROM part WHERE n = 2", NULL, 0);
    check_refused();
    free(data);
    store_bed_close(&bed);
}
END_TEST

static bool ignore(void *user, int first_tile, int tile_count, const float *rgb, int64_t pixels)
{
    (void)first_tile;
    (void)tile_count;
    ck_assert_ptr_nonnull(rgb);
    *(int64_t *)user += pixels;
    return true;
}

START_TEST(test_values__of_all_kinds_are_checked)
{
    struct pen_status st;
    struct pen_buf out = {0};
    int64_t pixels = 0;
    bool outranked;
    put("depth", 5);
    const struct pen_kept kept = {.done = -1, .data = "state", .bytes = 5};
    store_must(pen_store_keep(bed.store, &claim, &kept, &outranked, &st), &st, "keep");
    store_change(bed.url, "UPDATE object SET checksum = checksum + 1", NULL, 0);
    ck_assert(!pen_store_kept(bed.store, &claim, PEN_KEPT_STATE, &out, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert(!pen_store_scene(bed.store, job.id, &out, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    check_refused();
    ck_assert_int_eq(store_commit(bed.store, &claim), PEN_OK);
    store_change(bed.url, "UPDATE object SET checksum = checksum + 1 WHERE layer = ''", NULL, 0);
    ck_assert(!pen_store_pixels(bed.store, job.id, 0, ignore, &pixels, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_int_eq(pixels, 0);
    ck_assert_uint_eq(out.bytes, 0);
    pen_buf_release(&out);
    ck_assert_int_eq(store_job_state(bed.store, job.id), PEN_JOB_SUCCEEDED);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store values", test_values__every_changed_bit_is_noticed,
          test_values__missing_and_added_bytes_are_noticed,
          test_values__a_missing_part_and_parts_in_another_order_are_noticed,
          test_values__of_all_kinds_are_checked)
