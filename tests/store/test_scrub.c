/* SPDX-License-Identifier: MIT */
/* The background check: it reads every stored document, picture and batch of pixels once a pass,
 * and finds each one whose bytes have changed. */
#include <string.h>

#include "support/store.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct store_bed bed;

/* Two jobs that have ended: two scenes, four batches of pixels, two pictures. */
enum { BLOBS = 2 + 4 + 2 };

static void fill(void)
{
    struct store_job job;
    store_bed_open(&bed);
    for (int i = 0; i < 2; i++) {
        store_job_init(&job, i, 1, 2);
        store_job_submit(bed.store, &job);
    }
    ck_assert_int_ge(store_work_off(bed.store, "w"), 4);
    for (int i = 0; i < 2; i++) {
        store_job_init(&job, i, 1, 2);
        store_put(bed.store, &(struct store_artefact){job.id, 0, "depth", "pfm", "depth", 5});
    }
}

/* Makes a pass; returns the number of blobs that it read. */
static int pass(int64_t *damaged)
{
    struct pen_scrub scrub = {0};
    struct pen_status st;
    bool more = true;
    int count = 0;
    for (; count < 1000; count++) {
        store_must(pen_store_scrub(bed.store, &scrub, &more, &st), &st, "scrub");
        if (!more)
            break;
    }
    ck_assert_int_eq(scrub.kind + scrub.after + scrub.damaged, 0);
    *damaged = (int64_t)pen_store_tally(bed.store, PEN_TALLY_DAMAGED);
    return count;
}

static int blobs(void)
{
    int64_t damaged;
    int count = pass(&damaged);
    ck_assert_int_eq(damaged, 0);
    return count;
}

START_TEST(test_scrub__reads_everything_once)
{
    int64_t damaged;
    store_bed_open(&bed);
    ck_assert_int_eq(pass(&damaged), 0);
    ck_assert_int_eq(damaged, 0);
    store_bed_close(&bed);
    fill();
    const int count = blobs();
    ck_assert_int_ge(count, BLOBS);
    ck_assert_uint_eq(pen_store_tally(bed.store, PEN_TALLY_SCRUBBED), (uint64_t)count);
    ck_assert_int_eq(blobs(), count);
    store_bed_close(&bed);
}
END_TEST

/* A changed byte, a blob that was cut off, an empty one, and one that is longer. */
START_TEST(test_scrub__finds_what_has_changed)
{
    static const char *const changes[] = {
        "UPDATE scene SET document ="
        " CAST(substr(document, 1, length(document) - 1) || x'55' AS BLOB) WHERE id = 1",
        "UPDATE pixels SET data = substr(data, 1, length(data) - 1)"
        " WHERE batch = (SELECT max(batch) FROM pixels)",
        "UPDATE artefact SET data = x'' WHERE id = (SELECT min(id) FROM artefact)",
        "UPDATE artefact SET data = x'646570746800' WHERE id = (SELECT max(id) FROM artefact)"};
    static const char back[] =
        "UPDATE artefact SET data = x'6465707468' WHERE id = (SELECT max(id) FROM artefact)";
    fill();
    const int count = blobs();
    int64_t damaged;
    for (int i = 0; i < 4; i++) {
        store_run_sql(&bed, changes[i], NULL, 0);
        ck_assert_int_eq(pass(&damaged), count);
        ck_assert_int_eq(damaged, i + 1);
    }
    store_run_sql(&bed, back, NULL, 0);
    ck_assert_int_eq(pass(&damaged), count);
    ck_assert_int_eq(damaged, 3);
    store_bed_close(&bed);
}
END_TEST

/* A removed job's rows go in slices, between those of a pass. */
START_TEST(test_scrub__goes_on_while_jobs_are_removed)
{
    struct pen_scrub scrub = {0};
    struct pen_status st;
    struct store_job job;
    bool more = true;
    fill();
    store_must(pen_store_scrub(bed.store, &scrub, &more, &st), &st, "scrub");
    store_job_init(&job, 0, 1, 2);
    store_must(pen_store_delete(bed.store, job.id, NULL, NULL, &st), &st, "delete");
    store_must(pen_store_scrub(bed.store, &scrub, &more, &st), &st, "scrub");
    store_purge_slices(bed.store);
    for (int i = 0; i < 1000 && more; i++)
        store_must(pen_store_scrub(bed.store, &scrub, &more, &st), &st, "scrub");
    ck_assert(!more);
    ck_assert_uint_eq(pen_store_tally(bed.store, PEN_TALLY_DAMAGED), 0);
    store_bed_close(&bed);
}
END_TEST

/* A large picture without some of its parts, then without any. */
START_TEST(test_scrub__tells_what_cannot_be_read_and_goes_on)
{
    enum { LARGE = 3 << 20 };
    static const char *const changes[] = {"DELETE FROM large_object_part WHERE part = 1",
                                          "DELETE FROM large_object_part"};
    static char picture[LARGE];
    struct store_job job;
    struct pen_status st;
    struct pen_buf out = {0};
    int64_t damaged;
    fill();
    store_job_init(&job, 0, 1, 2);
    store_put(bed.store,
              &(struct store_artefact){job.id, 0, "beauty", "pfm", picture, sizeof picture});
    store_put(bed.store, &(struct store_artefact){job.id, 0, "normal", "pfm", "after", 5});
    const int count = blobs();
    for (int i = 0; i < 2; i++) {
        store_run_sql(&bed, changes[i], NULL, 0);
        ck_assert_int_eq(pass(&damaged), count);
        ck_assert_int_eq(damaged, 1);
        ck_assert(!pen_store_artefact(bed.store, job.id, 0, "beauty", "pfm", &out, &st));
        ck_assert_int_eq(st.code, PEN_STORAGE);
        ck_assert_ptr_nonnull(strstr(st.msg, "damaged"));
    }
    store_run_sql(&bed, "UPDATE artefact SET data = x'00' WHERE layer = 'normal'", NULL, 0);
    ck_assert_int_eq(pass(&damaged), count);
    ck_assert_int_eq(damaged, 2);
    store_must(pen_store_delete(bed.store, job.id, NULL, NULL, &st), &st, "delete");
    store_purge_slices(bed.store);
    pen_buf_release(&out);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store's background check", test_scrub__reads_everything_once,
          test_scrub__finds_what_has_changed, test_scrub__goes_on_while_jobs_are_removed,
          test_scrub__tells_what_cannot_be_read_and_goes_on)
