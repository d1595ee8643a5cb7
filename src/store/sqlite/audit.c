/* SPDX-License-Identifier: MIT */
/* The audit: one query per rule, which selects the rows that break it. Numbers of states and kinds
 * are those of store.h (asserted in sql.c): jobs 0 queued, 1 running, 2 succeeded, 3 failed, 4
 * cancelled; batches 0 open, 1 leased, 2 done, 3 ended; kinds 0 render, 1 assemble, 2 study. */
#include "store/sqlite/sqlite.h"

struct rule {
    const char *finding; /* what a row means; the message ends with the row's first column */
    const char *sql;
};

static const struct rule rules[] = {
    {"a row whose owner is missing, in table", "SELECT \"table\" FROM pragma_foreign_key_check"},
    {"a queued job that has begun",
     "SELECT id FROM job WHERE state = 0 AND (started_ms <> 0 OR done_pixels <> 0 OR EXISTS"
     " (SELECT 1 FROM batch WHERE job = number AND (state <> 0 OR attempt <> 0)))"},
    {"a running or succeeded job that has never begun",
     "SELECT id FROM job WHERE state IN (1, 2) AND started_ms = 0"},
    {"a running job with nothing left to do",
     "SELECT id FROM job WHERE state = 1 AND NOT EXISTS"
     " (SELECT 1 FROM batch WHERE job = number AND state IN (0, 1))"},
    {"a job with a time of end that has not ended, or the other way round",
     "SELECT id FROM job WHERE (state >= 2) <> (finished_ms <> 0)"},
    {"a job with an error that has not failed, or the other way round",
     "SELECT id FROM job WHERE (state = 3) <> (error IS NOT NULL)"},
    {"a succeeded job with unfinished batches",
     "SELECT id FROM job WHERE state = 2 AND EXISTS"
     " (SELECT 1 FROM batch WHERE job = number AND state <> 2)"},
    {"a succeeded job without a view's picture, or without its report",
     "SELECT j.id FROM job j JOIN view v ON v.job = j.number WHERE j.state = 2 AND NOT EXISTS"
     " (SELECT 1 FROM artefact a WHERE a.job = v.job AND a.view = v.view"
     " AND a.format = CASE WHEN a.layer = 'report' THEN 'json' ELSE 'png' END"
     " AND a.layer = CASE WHEN EXISTS (SELECT 1 FROM batch WHERE job = j.number AND kind = 2)"
     " THEN 'report' ELSE 'beauty' END)"},
    {"a failed or cancelled job with open or leased batches",
     "SELECT id FROM job WHERE state IN (3, 4) AND EXISTS"
     " (SELECT 1 FROM batch WHERE job = number AND state IN (0, 1))"},
    {"an ended batch of a job that did not fail and was not cancelled",
     "SELECT b.id FROM batch b JOIN job j ON j.number = b.job"
     " WHERE b.state = 3 AND j.state NOT IN (3, 4)"},
    /* A batch that has a view for itself may have told a part of its pixels. */
    {"a job whose progress is not the sum of its batches",
     "SELECT id FROM job WHERE total_pixels <> (SELECT coalesce(sum(pixels), 0) FROM batch"
     " WHERE job = number AND kind <> 1) OR done_pixels NOT BETWEEN"
     " (SELECT coalesce(sum(pixels), 0) FROM batch WHERE job = number AND kind <> 1 AND state = 2)"
     " AND (SELECT coalesce(sum(b.pixels), 0) FROM batch b JOIN view v"
     " ON v.job = b.job AND v.view = b.view WHERE b.job = number AND b.kind <> 1"
     " AND (b.state = 2 OR v.batches = 1)) AND NOT EXISTS"
     " (SELECT 1 FROM batch WHERE job = number AND kind = 2 AND state <> 2)"},
    {"a job on which less time was spent than on its batches",
     "SELECT id FROM job WHERE spent_us <"
     " (SELECT coalesce(sum(spent_us), 0) FROM batch WHERE job = number)"},
    {"a job on which less time was spent than it was told",
     "SELECT id FROM job WHERE spent_us < told_us"},
    {"a job whose work is not that of its batches",
     "SELECT id FROM job WHERE work <>"
     " (SELECT coalesce(sum(work), 0) FROM batch WHERE job = number)"},
    {"a peer whose count of unfinished jobs is wrong",
     "SELECT id FROM peer WHERE jobs <>"
     " (SELECT count(*) FROM job j WHERE j.peer = peer.id AND j.state < 2)"},
    {"what the results of unfinished jobs are expected to take is counted wrong, as",
     "SELECT value FROM meta WHERE name = 'expected_bytes' AND value <>"
     " (SELECT coalesce(sum(" PEN_SQLITE_EXPECTED_BYTES "), 0) FROM job j WHERE j.state < 2)"},
    {"what the statistics of removed jobs take is counted wrong, as",
     "SELECT value FROM meta WHERE name = 'stats_bytes' AND value <>"
     " (SELECT coalesce(sum(" PEN_SQLITE_STATS_BYTES "), 0) FROM removed)"},
    {"an unfinished job without a peer, or of another priority or client than its peer",
     "SELECT j.id FROM job j WHERE j.state < 2 AND NOT EXISTS (SELECT 1 FROM peer p"
     " WHERE p.id = j.peer AND p.priority = j.priority AND p.client = j.client)"},
    {"a batch of another peer than its job",
     "SELECT b.id FROM batch b JOIN job j ON j.number = b.job WHERE b.peer <> j.peer"},
    {"a job whose views' pixels are not those of its batches",
     "SELECT id FROM job WHERE total_pixels <>"
     " (SELECT sum(width * height) FROM view WHERE job = number)"
     " AND NOT EXISTS (SELECT 1 FROM batch WHERE job = number AND kind = 2)"},
    {"a study that is not the only batch of its job",
     "SELECT id FROM batch s WHERE kind = 2 AND EXISTS"
     " (SELECT 1 FROM batch b WHERE b.job = s.job AND b.id <> s.id)"},
    {"a view whose count of open batches is wrong, of job",
     "SELECT v.job FROM view v WHERE v.batches <> (SELECT count(*) FROM batch b"
     " WHERE b.job = v.job AND b.view = v.view AND b.kind <> 1) OR v.open_batches <>"
     " (SELECT count(*) FROM batch b WHERE b.job = v.job AND b.view = v.view AND b.kind <> 1"
     " AND b.state <> 2)"},
    {"a view with too many or too few assemble batches, of job",
     "SELECT v.job FROM view v WHERE (v.batches > 1 AND v.open_batches = 0) <>"
     " (SELECT count(*) FROM batch b WHERE b.job = v.job AND b.view = v.view AND b.kind = 1)"},
    {"a job whose count of open views is wrong",
     "SELECT id FROM job WHERE open_views <> (SELECT count(*) FROM view v WHERE v.job = number"
     " AND (v.open_batches > 0 OR EXISTS (SELECT 1 FROM batch b WHERE b.job = v.job"
     " AND b.view = v.view AND b.kind = 1 AND b.state <> 2)))"},
    {"a finished render batch without pixels",
     "SELECT id FROM batch WHERE kind = 0 AND state = 2 AND id NOT IN (SELECT batch FROM pixels)"},
    {"pixels of a batch that is not a finished render batch",
     "SELECT p.batch FROM pixels p JOIN batch b ON b.id = p.batch"
     " WHERE b.kind <> 0 OR b.state <> 2"},
    {"statistics of an unfinished batch, or a finished batch without any",
     "SELECT id FROM batch WHERE (state = 2) <> (stats IS NOT NULL)"},
    {"a finished batch without the revision of its commit, or the other way round",
     "SELECT id FROM batch WHERE (state = 2) <> (revision IS NOT NULL)"},
    {"a job of which two batches were committed at one revision, or beyond its own",
     "SELECT j.id FROM job j JOIN batch b ON b.job = j.number WHERE b.revision IS NOT NULL"
     " GROUP BY j.number HAVING count(*) <> count(DISTINCT b.revision)"
     " OR max(b.revision) > j.revision"},
    {"a claimed batch that was never attempted",
     "SELECT id FROM batch WHERE state IN (1, 2) AND attempt = 0"},
    {"a batch whose priority is not its job's",
     "SELECT b.id FROM batch b JOIN job j ON j.number = b.job WHERE b.priority <> j.priority"},
    {"a job charged without a death, or more than it allows",
     "SELECT id FROM job WHERE charges NOT BETWEEN 0 AND min(deaths, max_attempts)"},
    {"a job that has used up its attempts and has not ended",
     "SELECT id FROM job WHERE charges >= max_attempts AND state IN (0, 1)"},
    {"a job that is paused though no worker was lost over it",
     "SELECT id FROM job WHERE deaths < 2 AND paused_until_ms <> 0"},
    {"a quarantined batch that was never attempted, or has ended",
     "SELECT id FROM batch WHERE quarantined = 1 AND (attempt = 0 OR state IN (2, 3))"},
    {"a worker that holds more than a quarantined batch, or than a study",
     "SELECT a.worker FROM batch a WHERE a.state = 1 AND (a.quarantined = 1 OR a.kind = 2)"
     " AND EXISTS (SELECT 1"
     " FROM batch b WHERE b.state = 1 AND b.worker = a.worker AND b.id <> a.id)"},
    {"a scene document that no job names",
     "SELECT id FROM scene WHERE id NOT IN (SELECT scene FROM main.job)"},
    {"a removed job that has not ended",
     "SELECT id FROM main.job WHERE removed_ms > 0 AND state NOT IN (2, 3, 4)"},
    {"a removed job of which it is not noted that it was removed, or the other way round",
     "SELECT id FROM main.job WHERE (removed_ms > 0) <> (id IN (SELECT id FROM removed))"},
    {"a form of a picture that is not stored with its length",
     "SELECT c.artefact FROM cached c JOIN artefact a ON a.id = c.artefact WHERE c.bytes <>"
     " coalesce((SELECT bytes FROM large_object WHERE id = a.object), length(a.data))"},
    {"a large object that no row has, and that is kept, or the other way round",
     "SELECT id FROM large_object WHERE (expires_ms IS NULL) <>"
     " (id IN (SELECT object FROM artefact UNION ALL SELECT object FROM pixels))"},
    {"a large object that is not as long as it should be",
     "SELECT id FROM large_object o WHERE expires_ms IS NULL AND bytes <>"
     " (SELECT coalesce(sum(length(data)), 0) FROM large_object_part WHERE object = o.id)"},
};

/* Jobs that were removed and their batches are not audited: their rows go one after the other. */
static const char living[] = "WITH job AS (SELECT * FROM main.job WHERE removed_ms = 0),"
                             " batch AS (SELECT * FROM main.batch WHERE job NOT IN"
                             " (SELECT number FROM main.job WHERE removed_ms > 0)),"
                             " view AS (SELECT * FROM main.view WHERE job NOT IN"
                             " (SELECT number FROM main.job WHERE removed_ms > 0)) ";

static bool apply_rule(struct pen_sqlite_store *store, const struct rule *rule,
                       struct pen_buf *findings, int *found, struct pen_status *st)
{
    sqlite3_stmt *stmt = NULL;
    struct pen_buf sql = {0};
    if (!pen_buf_puts(&sql, living) || !pen_buf_puts(&sql, rule->sql)) {
        pen_buf_release(&sql);
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the audit");
    }
    int rc = sqlite3_prepare_v2(store->db, (const char *)sql.data, -1, &stmt, NULL);
    pen_buf_release(&sql);
    while (rc == SQLITE_OK || rc == SQLITE_ROW) {
        rc = sqlite3_step(stmt);
        if (rc != SQLITE_ROW)
            break;
        const char *what = (const char *)sqlite3_column_text(stmt, 0);
        pen_buf_printf(findings, "%s: %.200s", rule->finding, what ? what : "?");
        pen_buf_add(findings, "", 1);
        ++*found;
    }
    sqlite3_finalize(stmt);
    return rc == SQLITE_DONE || pen_sqlite_error(store, rc, st);
}

bool pen_sqlite_audit(struct pen_driver *driver, struct pen_buf *findings, int *found,
                      struct pen_status *st)
{
    bool ok = pen_sqlite_begin_read(driver, st);
    *found = 0;
    for (size_t i = 0; ok && i < sizeof rules / sizeof rules[0]; i++)
        ok = apply_rule(pen_sqlite_of(driver), &rules[i], findings, found, st);
    pen_sqlite_rollback(driver);
    return ok;
}
