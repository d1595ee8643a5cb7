/* SPDX-License-Identifier: MIT */
/* Removing jobs in slices, and the statistics that stay of them. */
#include <stdio.h>

#include "store/sqlite/sqlite.h"

bool pen_sqlite_job_mark_removed(struct pen_driver *driver, int64_t job, int64_t now_ms,
                                 struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_MARK_REMOVED);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, now_ms > 0 ? now_ms : 1);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_removed_next(struct pen_driver *driver, struct pen_job_key *job, bool *found,
                             struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_REMOVED_NEXT);
    return pen_sqlite_next_job_key(&query, job, found, st);
}

/* The next rows of a job: `list` selects their numbers and lengths, `drop` removes one. */
struct shrink {
    enum pen_sqlite_sql list, drop;
};

enum { ROWS = 64, ROW_BYTES = 8192 /* that a row counts for, beside its value */ };

/* Removes rows until about *bytes are gone; *bytes is what is left to do, *emptied: no row is left.
 */
static bool shrink_by(struct pen_sqlite_store *store, const struct shrink *shrink, int64_t job,
                      int64_t *bytes, bool *emptied, struct pen_status *st)
{
    *emptied = false;
    while (*bytes > 0 && !*emptied) {
        int64_t number[ROWS], length[ROWS];
        int count = 0;
        bool ok;
        struct pen_sqlite_query query = pen_sqlite_query(store, shrink->list);
        pen_sqlite_int(&query, job);
        pen_sqlite_int(&query, ROWS);
        while (pen_sqlite_next_row(&query, &ok, st)) {
            number[count] = pen_sqlite_column_int(&query, 0);
            length[count++] = pen_sqlite_column_int(&query, 1);
        }
        *emptied = count == 0;
        for (int i = 0; ok && i<count && * bytes> 0; i++) {
            struct pen_sqlite_query drop = pen_sqlite_query(store, shrink->drop);
            pen_sqlite_int(&drop, number[i]);
            ok = pen_sqlite_run(&drop, st);
            *bytes -= length[i] + ROW_BYTES;
        }
        if (!ok)
            return false;
    }
    return true;
}

bool pen_sqlite_job_shrink(struct pen_driver *driver, int64_t job, int64_t bytes, bool *emptied,
                           struct pen_status *st)
{
    static const struct shrink artefacts = {SQL_ARTEFACTS_OF_JOB, SQL_ARTEFACT_REMOVE};
    static const struct shrink batches = {SQL_BATCHES_OF_JOB, SQL_BATCH_REMOVE};
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    return shrink_by(store, &artefacts, job, &bytes, emptied, st) &&
           (!*emptied || shrink_by(store, &batches, job, &bytes, emptied, st));
}

bool pen_sqlite_stats_count(struct pen_driver *driver, bool counted, struct pen_status *st)
{
    struct pen_sqlite_query query =
        pen_sqlite_query(pen_sqlite_of(driver), counted ? SQL_STATS_COUNT : SQL_STATS_DROP);
    return pen_sqlite_run(&query, st);
}

/* Adds the statistics of a job to the sum that is counted, or subtracts them. */
static bool change_stats(struct pen_driver *driver, enum pen_sqlite_sql sql, const char *id,
                         struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), sql);
    pen_sqlite_text(&query, id);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_removed_add(struct pen_driver *driver, const char *id, int64_t now_ms,
                            const char *stats, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_REMOVED_ADD);
    pen_sqlite_text(&query, id);
    pen_sqlite_int(&query, now_ms);
    pen_sqlite_text(&query, stats);
    return pen_sqlite_run(&query, st) && change_stats(driver, SQL_STATS_ENTER, id, st);
}

bool pen_sqlite_removed_get(struct pen_driver *driver, const char *id, struct pen_buf *stats,
                            bool *has_stats, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_REMOVED_GET);
    pen_sqlite_text(&query, id);
    *has_stats = false;
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (!*found)
        return true;
    const char *text = pen_sqlite_column_text(&query, 0);
    *has_stats = text != NULL;
    bool ok = !text || !stats || pen_buf_puts(stats, text);
    pen_sqlite_end(&query);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
}

bool pen_sqlite_removed_drop_stats(struct pen_driver *driver, const char *id, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_REMOVED_DROP_STATS);
    pen_sqlite_text(&query, id);
    return change_stats(driver, SQL_STATS_LEAVE, id, st) && pen_sqlite_run(&query, st);
}

bool pen_sqlite_removed_purge(struct pen_driver *driver, int64_t bare_before_ms, int64_t before_ms,
                              int limit, bool *more, struct pen_status *st)
{
    static const enum pen_sqlite_sql statements[] = {SQL_STATS_PURGE, SQL_REMOVED_PURGE};
    for (int i = 0; i < 2; i++) {
        struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), statements[i]);
        pen_sqlite_int(&query, bare_before_ms);
        pen_sqlite_int(&query, before_ms);
        if (!pen_sqlite_run_limited(&query, limit, more, st))
            return false;
    }
    return true;
}

/* Adds the lengths that a query gives, and so much for the row of each, until it is enough. */
static bool add_lengths(struct pen_sqlite_store *store, enum pen_sqlite_sql sql, int64_t row_bytes,
                        int64_t enough, int64_t *bytes, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    bool ok = true;
    while (*bytes < enough && pen_sqlite_next_row(&query, &ok, st))
        *bytes += pen_sqlite_column_int(&query, 0) + row_bytes;
    if (*bytes >= enough)
        pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_ended_bytes(struct pen_driver *driver, int64_t enough, int64_t *bytes,
                            struct pen_status *st)
{
    enum { STATS_ROW_BYTES = 512 };
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    *bytes = 0;
    return add_lengths(store, SQL_BYTES_OF_ENDED, 4 * ROW_BYTES, enough, bytes, st) &&
           add_lengths(store, SQL_BYTES_OF_STATS, STATS_ROW_BYTES, enough, bytes, st);
}

bool pen_sqlite_count_ended(struct pen_driver *driver, int64_t *count, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_COUNT_ENDED);
    return pen_sqlite_value(&query, count, st);
}

bool pen_sqlite_first_ended(struct pen_driver *driver, int64_t after_ms, char id[PEN_ID_BYTES],
                            int64_t *ended_ms, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_FIRST_ENDED);
    pen_sqlite_int(&query, after_ms);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (!*found)
        return true;
    const char *text = pen_sqlite_column_text(&query, 0);
    snprintf(id, PEN_ID_BYTES, "%s", text ? text : "");
    *ended_ms = pen_sqlite_column_int(&query, 1);
    pen_sqlite_end(&query);
    return text || pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
}
