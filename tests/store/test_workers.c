/* SPDX-License-Identifier: MIT */
/* The list of workers, with the batches that they hold. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "support/store.h"
#include "support/suite.h"

struct row {
    char name[40], job_id[PEN_ID_BYTES], view[40];
    struct pen_worker_record worker; /* without its texts, which are no longer valid */
};

struct rows {
    struct row row[8];
    int count;
};

static bool note_row(void *user, const struct pen_worker_record *worker)
{
    struct rows *rows = user;
    struct row *row = &rows->row[rows->count++];
    *row = (struct row){.worker = *worker};
    snprintf(row->name, sizeof row->name, "%s", worker->id);
    snprintf(row->job_id, sizeof row->job_id, "%s", worker->job_id ? worker->job_id : "");
    snprintf(row->view, sizeof row->view, "%s", worker->job_id ? worker->view : "");
    return rows->count < 8;
}

static struct rows list(struct pen_store *store)
{
    struct rows rows = {0};
    struct pen_status st;
    store_must(pen_store_workers(store, note_row, &rows, &st), &st, "workers");
    return rows;
}

static void see(struct pen_store *store, const char *name, int threads, int64_t lease_ms)
{
    struct pen_status st;
    struct pen_worker_new worker = {
        .id = name, .host = "host", .pid = 77, .threads = threads, .lease_ms = lease_ms};
    store_must(pen_store_worker_seen(store, &worker, &st), &st, "seen");
}

START_TEST(test_workers__are_listed_with_what_they_hold)
{
    struct store_bed bed = {0};
    struct store_job in;
    store_bed_open(&bed);
    ck_assert_int_eq(list(bed.store).count, 0);
    int64_t before_ms = pen_clock_wall_ms();
    see(bed.store, "a", 4, 60000);
    see(bed.store, "b", 2, 60000);
    store_job_init(&in, 1, 2, 3);
    store_job_submit(bed.store, &in);
    struct pen_claim first = store_claim(bed.store, "b"), second = store_claim(bed.store, "b");
    struct rows rows = list(bed.store);
    ck_assert_int_eq(rows.count, 3);
    ck_assert_str_eq(rows.row[0].name, "a");
    ck_assert_int_eq(rows.row[0].worker.threads, 4);
    ck_assert_ptr_null(rows.row[0].worker.job_id);
    ck_assert_int_ge(rows.row[0].worker.seen_ms, before_ms);
    ck_assert_int_eq(rows.row[0].worker.seen_ms, rows.row[0].worker.started_ms);
    const struct pen_claim *claims[] = {&first, &second};
    for (int i = 1; i < 3; i++) {
        ck_assert_str_eq(rows.row[i].name, "b");
        ck_assert_str_eq(rows.row[i].job_id, in.id);
        ck_assert_str_eq(rows.row[i].view, in.view[0].name);
        ck_assert_int_eq(rows.row[i].worker.batch, claims[i - 1]->batch);
        ck_assert_int_eq(rows.row[i].worker.attempt, 1);
        ck_assert_int_eq(rows.row[i].worker.pixels, 16);
        ck_assert_int_eq(rows.row[i].worker.kind, PEN_BATCH_RENDER);
    }
    ck_assert_int_eq(store_commit(bed.store, &first), PEN_OK);
    ck_assert_int_eq(store_commit(bed.store, &second), PEN_OK);
    rows = list(bed.store);
    ck_assert_int_eq(rows.count, 2);
    ck_assert_ptr_null(rows.row[1].worker.job_id);
    store_bed_close(&bed);
}
END_TEST

/* A worker that works on a long batch reports itself only by extending its lease. */
START_TEST(test_workers__are_seen_by_their_leases)
{
    struct store_bed bed = {0};
    struct store_job in;
    store_bed_open(&bed);
    see(bed.store, "w", 1, 10000); /* and claims for longer: as if seen in the future */
    store_job_init(&in, 1, 1, 1);
    store_job_submit(bed.store, &in);
    store_claim(bed.store, "w");
    struct rows rows = list(bed.store);
    ck_assert_int_eq(rows.count, 1);
    ck_assert_int_ge(rows.row[0].worker.seen_ms, rows.row[0].worker.started_ms + 50000);
    store_bed_close(&bed);
}
END_TEST

START_TEST(test_workers__are_removed_by_id_or_by_age)
{
    struct store_bed bed = {0};
    struct pen_status st;
    store_bed_open(&bed);
    see(bed.store, "a", 1, 1000);
    see(bed.store, "b", 1, 1000);
    int64_t started_ms = list(bed.store).row[1].worker.started_ms;
    while (pen_clock_wall_ms() == started_ms)
        ;
    see(bed.store, "b", 3, 1000);
    struct rows rows = list(bed.store);
    ck_assert_int_eq(rows.count, 2);
    ck_assert_int_eq(rows.row[1].worker.started_ms, started_ms);
    ck_assert_int_gt(rows.row[1].worker.seen_ms, started_ms);
    ck_assert_int_eq(rows.row[1].worker.threads, 3);
    store_must(pen_store_worker_gone(bed.store, "a", &st), &st, "gone");
    store_must(pen_store_worker_gone(bed.store, "nobody", &st), &st, "gone");
    ck_assert_int_eq(list(bed.store).count, 1);
    store_must(pen_store_purge(bed.store, 3600000, 3600000, &st), &st, "purge");
    ck_assert_int_eq(list(bed.store).count, 1);
    store_must(pen_store_purge(bed.store, -1000, -1000, &st), &st, "purge");
    ck_assert_int_eq(list(bed.store).count, 0);
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store workers", test_workers__are_listed_with_what_they_hold,
          test_workers__are_seen_by_their_leases, test_workers__are_removed_by_id_or_by_age)
