/* SPDX-License-Identifier: MIT */
#include "support/store_rows.h"

#include <stdio.h>
#include <stdlib.h>

#include "store/db.h"

/* Ends the process: the crash test has no suite that could take a failure. */
static _Noreturn void fail(const char *what, const char *of, const struct pen_status *st)
{
    fprintf(stderr, "%s: %s: %s\n", what, of, st->msg);
    abort();
}

static struct pen_db *open_db(const char *url)
{
    struct pen_status st;
    struct pen_db *db = pen_db_open(url, false, &st);
    if (!db || !pen_db_begin(db, PEN_DB_READ, &st))
        fail("rows of a store", url, &st);
    return db;
}

static void close_db(struct pen_db *db)
{
    struct pen_status ignored;
    pen_db_end(db, true, &ignored);
    pen_db_close(db);
}

int store_batches(const char *url, const char *id, struct store_batch *batch, int most)
{
    struct pen_db *db = open_db(url);
    struct pen_status st;
    int count = 0;
    struct pen_rows *rows = pen_db_rows(
        db, &st,
        "SELECT b.number, b.pixels, b.kind, b.state, b.view, b.first_tile, b.tile_count, b.alone"
        " FROM batch b, job j WHERE b.job = j.number AND j.id = $1"
        " ORDER BY b.view, b.first_tile, b.number",
        "t", id);
    for (; count < most && pen_db_next(rows); count++)
        batch[count] = (struct store_batch){.number = pen_db_int(rows, 0),
                                            .pixels = pen_db_int(rows, 1),
                                            .kind = (enum pen_batch_kind)pen_db_int(rows, 2),
                                            .state = (enum pen_batch_state)pen_db_int(rows, 3),
                                            .view = (int)pen_db_int(rows, 4),
                                            .first_tile = (int)pen_db_int(rows, 5),
                                            .tile_count = (int)pen_db_int(rows, 6),
                                            .alone = pen_db_int(rows, 7) != 0};
    if (!pen_db_done(rows))
        fail("batches", url, &st);
    close_db(db);
    return count;
}

int64_t store_value(const char *url, const char *sql)
{
    struct pen_db *db = open_db(url);
    struct pen_status st;
    int64_t value;
    if (!pen_db_value(db, &st, &value, sql, ""))
        fail("a value", sql, &st);
    close_db(db);
    return value;
}

void store_change(const char *url, const char *sql, const void *blob, size_t bytes)
{
    struct pen_status st;
    struct pen_db *db = pen_db_open(url, false, &st);
    const bool ok =
        db && pen_db_begin(db, PEN_DB_WRITE, &st) &&
        pen_db_end(db, pen_db_run(db, &st, NULL, sql, blob ? "b" : "", blob, bytes), &st);
    if (!ok)
        fail("a statement", sql, &st);
    pen_db_close(db);
}

/* Each statement names the rows for which its sentence holds. */
static const struct {
    const char *sentence, *sql;
} contradictions[] = {
    {"a batch without its view", "SELECT b.number FROM batch b WHERE NOT EXISTS"
                                 " (SELECT 1 FROM view v WHERE v.job = b.job AND v.view = b.view)"},
    {"a view without its job",
     "SELECT v.job FROM view v WHERE NOT EXISTS (SELECT 1 FROM job j WHERE j.number = v.job)"},
    {"a job whose scene is missing",
     "SELECT j.number FROM job j WHERE j.removed_ms = 0 AND NOT EXISTS"
     " (SELECT 1 FROM scene s, object o WHERE s.number = j.scene AND o.number = s.object"
     " AND o.state = 1)"},
    {"an open or leased batch of a job that has ended",
     "SELECT b.number FROM batch b, job j WHERE j.number = b.job AND j.state >= 2 AND b.state < 2"},
    {"a leased or done batch of a queued job",
     "SELECT b.number FROM batch b, job j WHERE j.number = b.job AND j.state = 0 AND b.state = 2"},
    {"a batch that is leased without a worker, or has one and is not leased",
     "SELECT b.number FROM batch b WHERE (b.state = 1) <> (b.worker IS NOT NULL)"},
    {"an unfinished view without a batch to be done, or a finished one with one",
     "SELECT v.job FROM view v, job j WHERE j.number = v.job AND j.state < 2 AND"
     " (v.open_batches > 0) <> EXISTS (SELECT 1 FROM batch b WHERE b.job = v.job"
     " AND b.view = v.view AND b.state < 2)"},
    {"a job whose number of open views is wrong",
     "SELECT j.number FROM job j WHERE j.state < 2 AND j.open_views <>"
     " (SELECT count(*) FROM view v WHERE v.job = j.number AND v.open_batches > 0)"},
    {"a job that has succeeded with pixels left",
     "SELECT j.number FROM job j WHERE j.state = 2 AND"
     " (j.done_pixels <> j.total_pixels OR j.open_views <> 0)"},
    {"a job with more done than there is",
     "SELECT j.number FROM job j WHERE j.done_pixels > j.total_pixels"},
    {"a job whose work is not that of its batches",
     "SELECT j.number FROM job j WHERE j.removed_ms = 0 AND j.work <>"
     " (SELECT CAST(CASE WHEN sum(b.work) > 1000000000 THEN 1000000000"
     " ELSE coalesce(sum(b.work), 0) END AS BIGINT) FROM batch b WHERE b.job = j.number)"},
    {"a job whose times do not fit its state",
     "SELECT j.number FROM job j WHERE (j.state >= 2) <> (j.finished_ms > 0)"
     " OR (j.state = 1 AND j.started_ms = 0)"},
    {"a view of a job that has succeeded without a result",
     "SELECT v.job FROM view v, job j WHERE j.number = v.job AND j.state = 2 AND j.removed_ms = 0"
     " AND NOT EXISTS (SELECT 1 FROM object o WHERE o.job = v.job AND o.view = v.view"
     " AND o.state = 1 AND o.layer <> '')"},
    {"an object of a job that is not there",
     "SELECT o.number FROM object o WHERE o.job > 0 AND o.state < 2 AND NOT EXISTS"
     " (SELECT 1 FROM job j WHERE j.number = o.job)"},
    {"two values in one place",
     "SELECT a.number FROM object a, object b WHERE a.state = 1 AND b.state = 1 AND a.job > 0"
     " AND a.number < b.number AND a.job = b.job AND a.view = b.view AND a.batch = b.batch"
     " AND a.layer = b.layer AND a.format = b.format"},
    {"a value with parts missing",
     "SELECT o.number FROM object o WHERE o.state = 1 AND (o.bytes + 1048575) / 1048576 >"
     " (SELECT count(*) FROM part p WHERE p.object = o.number)"},
};

int store_contradictions(const char *url)
{
    struct pen_db *db = open_db(url);
    struct pen_status st;
    int found = 0;
    for (size_t i = 0; i < sizeof contradictions / sizeof contradictions[0]; i++) {
        struct pen_rows *rows = pen_db_rows(db, &st, contradictions[i].sql, "");
        for (; pen_db_next(rows); found++)
            fprintf(stderr, "%s: %lld\n", contradictions[i].sentence,
                    (long long)pen_db_int(rows, 0));
        if (!pen_db_done(rows))
            fail("contradictions", contradictions[i].sentence, &st);
    }
    close_db(db);
    return found;
}
