/* SPDX-License-Identifier: MIT */
/* Stored pictures and reports: a damaged one is refused, wherever the damage is. */
#include <string.h>

#include "base/log.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job;

static void put(const void *data, size_t bytes)
{
    store_bed_open(&bed);
    store_job_init(&job, 1, 1, 1);
    store_job_submit(bed.store, &job);
    store_put(bed.store, &(struct store_artefact){job.id, 0, "beauty", "pfm", data, bytes});
}

static bool get(struct pen_buf *out, struct pen_status *st)
{
    *out = (struct pen_buf){0};
    return pen_store_artefact(bed.store, job.id, 0, "beauty", "pfm", out, st);
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

static void check_refused(const void *damaged, size_t bytes)
{
    struct pen_status st;
    struct pen_buf out;
    store_run_sql(&bed, "UPDATE artefact SET data = ?", damaged, bytes);
    ck_assert(!get(&out, &st));
    ck_assert_int_eq(st.code, PEN_STORAGE);
    ck_assert_msg(strstr(st.msg, "damaged") && strstr(st.msg, job.id) && strstr(st.msg, "pfm"),
                  "%s", st.msg);
    ck_assert_uint_eq(out.bytes, 0);
    pen_buf_release(&out);
}

START_TEST(test_artefacts__every_changed_bit_is_noticed)
{
    unsigned char data[43];
    pen_log_set_level(PEN_LOG_ERROR + 1);
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (unsigned char)(i * i);
    put(data, sizeof data);
    check_got(data, sizeof data);
    for (size_t bit = 0; bit < 8 * sizeof data; bit++) {
        data[bit / 8] ^= (unsigned char)(1 << bit % 8);
        check_refused(data, sizeof data);
        data[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    store_run_sql(&bed, "UPDATE artefact SET data = ?", data, sizeof data);
    check_got(data, sizeof data);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_artefacts__missing_and_added_bytes_are_noticed)
{
    static const unsigned char zeros[40];
    pen_log_set_level(PEN_LOG_ERROR + 1);
    put(zeros, 24);
    for (size_t bytes = 0; bytes <= sizeof zeros; bytes++) {
        if (bytes != 24)
            check_refused(zeros, bytes);
    }
    store_put(bed.store, &(struct store_artefact){job.id, 0, "beauty", "pfm", "new", 3});
    check_got("new", 3);
    store_bed_close(&bed);
}
END_TEST

/* Artefacts of schemas before 7 have no checksum; they are returned as they are. */
START_TEST(test_artefacts__of_schemas_without_checksums_are_returned)
{
    put("old", 3);
    pen_store_close(bed.store);
    store_downgrade(bed.url, 6);
    bed.store = store_bed_handle(&bed);
    check_got("old", 3);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store artefacts", test_artefacts__every_changed_bit_is_noticed,
          test_artefacts__missing_and_added_bytes_are_noticed,
          test_artefacts__of_schemas_without_checksums_are_returned)
