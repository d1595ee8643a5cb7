/* SPDX-License-Identifier: MIT */
/* Housekeeping in slices. A delete only marks a job. Its objects, then its batches, and last its
 * row are removed here, in short transactions, so that no other writer waits long. Each transaction
 * locks a row of `meta`, so one process at a time does it. After a crash, the next slice
 * continues. */
#include "store/internal/objects.h"

enum {
    SLICE_PARTS = 2,                            /* of an object, */
    SLICE_BYTES = SLICE_PARTS * PEN_PART_BYTES, /* of all objects, or of free space, in a slice */
    SLICE_ROWS = 500,
    SELDOM_MS = 60000,
    DAY_MS = 86400000,
    STATS_PART = 8 /* statistics of removed jobs have at most an eighth of keep_bytes */
};

/* Removes parts of gone objects, and the rows of these objects. */
static bool remove_gone(struct pen_store *store, int64_t *removed, struct pen_status *st)
{
    int64_t left = SLICE_BYTES, changed;
    for (*removed = 0; left > 0 && *removed < SLICE_ROWS; (*removed)++) {
        int64_t number, bytes;
        if (!pen_row_numbers(pen_db_rows(store->db, st,
                                         "SELECT number, bytes FROM object WHERE state = 2 "
                                         "ORDER BY number LIMIT 1",
                                         ""),
                             &number, &bytes, NULL))
            return false;
        if (number == 0)
            return true;
        if (!pen_db_run(store->db, st, &changed,
                        "DELETE FROM part WHERE object = $1 AND n IN "
                        "(SELECT n FROM part WHERE object = $1 ORDER BY n LIMIT $2)",
                        "ii", number, (int64_t)SLICE_PARTS))
            return false;
        left -= bytes < PEN_PART_BYTES ? bytes : changed * PEN_PART_BYTES;
        if (changed < SLICE_PARTS &&
            !pen_db_run(store->db, st, NULL, "DELETE FROM object WHERE number = $1", "i", number))
            return false;
    }
    return true;
}

/* Drops a document that no job has. Its row is locked first, because submits lock it too. */
static bool drop_scene(struct pen_store *store, int64_t scene, struct pen_status *st)
{
    int64_t object;
    return pen_db_run(store->db, st, NULL, "UPDATE scene SET used_ms = used_ms WHERE number = $1",
                      "i", scene) &&
           pen_db_value(store->db, st, &object,
                        "DELETE FROM scene WHERE number = $1 AND NOT EXISTS "
                        "(SELECT 1 FROM job WHERE job.scene = $1) RETURNING object",
                        "i", scene) &&
           (object == 0 ||
            pen_db_run(store->db, st, NULL, "UPDATE object SET state = 2 WHERE number = $1", "i",
                       object));
}

/* Removes a part of a removed job: its objects, then its batches, and last its other rows. */
static bool shrink_job(struct pen_store *store, int64_t *changed, struct pen_status *st)
{
    int64_t job, scene;
    *changed = 0;
    if (!pen_db_value(store->db, st, &job,
                      "SELECT number FROM job WHERE removed_ms > 0 ORDER BY number LIMIT 1", ""))
        return false;
    if (job == 0)
        return true;
    if (!pen_db_run(store->db, st, changed,
                    "UPDATE object SET state = 2 WHERE number IN "
                    "(SELECT number FROM object WHERE job = $1 AND state = 1 LIMIT $2)",
                    "ii", job, (int64_t)SLICE_ROWS) ||
        (*changed == 0 && !pen_db_run(store->db, st, changed,
                                      "DELETE FROM batch WHERE number IN "
                                      "(SELECT number FROM batch WHERE job = $1 LIMIT $2)",
                                      "ii", job, (int64_t)SLICE_ROWS)))
        return false;
    if (*changed > 0)
        return true;
    *changed = 1;
    return pen_db_run(store->db, st, NULL, "DELETE FROM view WHERE job = $1", "i", job) &&
           pen_db_run(store->db, st, NULL, "DELETE FROM attribute WHERE job = $1", "i", job) &&
           pen_db_value(store->db, st, &scene, "DELETE FROM job WHERE number = $1 RETURNING scene",
                        "i", job) &&
           drop_scene(store, scene, st);
}

/* Collects loading objects whose claim no longer holds, whose job is removed, or that were not
 * touched for a day. */
static bool collect_loading(struct pen_store *store, int64_t *changed, struct pen_status *st)
{
    return pen_db_run(
        store->db, st, changed,
        "UPDATE object SET state = 2 WHERE state = 0 AND "
        "(touched_ms < (SELECT now_ms()) - $1 OR "
        "(batch > 0 AND NOT EXISTS (SELECT 1 FROM batch WHERE batch.number = object.batch AND "
        "batch.state = 1 AND batch.attempt = object.attempt)) OR "
        "(job > 0 AND NOT EXISTS (SELECT 1 FROM job WHERE job.number = object.job AND "
        "job.removed_ms = 0)))",
        "i", (int64_t)DAY_MS);
}

/* A job may have ended in the future, by a clock that was ahead. It is set to end now. Otherwise it
 * would stay for as long as the clock was ahead, and other jobs would be removed in its place. */
static bool end_futures(struct pen_store *store, struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL,
                      "UPDATE job SET finished_ms = (SELECT now_ms()) WHERE finished_ms > 0 AND "
                      "removed_ms = 0 AND finished_ms > (SELECT now_ms()) + $1",
                      "i", (int64_t)SELDOM_MS);
}

/* Keys and workers that died unnoticed stay for a day, statistics for five years. */
static bool remove_old(struct pen_store *store, struct pen_status *st)
{
    static const char *const old[] = {
        "DELETE FROM key WHERE created_ms < (SELECT now_ms()) - 86400000",
        "DELETE FROM removed WHERE removed_ms < (SELECT now_ms()) - 157852800000",
        "DELETE FROM removed WHERE removed_ms < (SELECT now_ms()) - 86400000 AND bytes = 0",
        ("DELETE FROM worker WHERE seen_ms < (SELECT now_ms()) - 86400000 AND NOT EXISTS "
         "(SELECT 1 FROM batch WHERE batch.worker = worker.id AND batch.state = 1)")};
    bool ok = true;
    for (size_t i = 0; ok && i < sizeof old / sizeof old[0]; i++)
        ok = pen_db_run(store->db, st, NULL, old[i], "");
    return ok;
}

/* Statistics of removed jobs have an eighth of keep_bytes. The oldest are dropped. */
static bool trim_stats(struct pen_store *store, struct pen_status *st)
{
    int64_t keep, bytes, until_ms = 0;
    if (!pen_meta_get(store, "keep_bytes", &keep, st) ||
        !pen_db_value(store->db, st, &bytes,
                      "SELECT CAST(coalesce(sum(bytes), 0) AS BIGINT) FROM removed", ""))
        return false;
    if (keep == 0 || bytes <= keep / STATS_PART)
        return true;
    struct pen_rows *rows =
        pen_db_rows(store->db, st, "SELECT removed_ms, bytes FROM removed ORDER BY removed_ms", "");
    while (bytes > keep / STATS_PART && pen_db_next(rows)) {
        until_ms = pen_db_int(rows, 0);
        bytes -= pen_db_int(rows, 1);
    }
    return pen_db_done(rows) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE removed SET stats = NULL, bytes = 0 WHERE removed_ms <= $1", "i",
                      until_ms);
}

/* Housekeeping of once a minute. It also notes a clock that has jumped ahead. */
static bool do_seldom(struct pen_store *store, int64_t *changed, struct pen_status *st)
{
    int64_t now_ms, last_ms, collected = 0;
    bool wait;
    if (!pen_db_now(store->db, &now_ms, st) || !pen_meta_get(store, "purged_ms", &last_ms, st))
        return false;
    if (last_ms <= now_ms && now_ms - last_ms < SELDOM_MS)
        return true;
    const bool ok = (last_ms == 0 || now_ms - last_ms <= DAY_MS ||
                     pen_meta_set(store, "ages_from_ms", now_ms + DAY_MS, st)) &&
                    pen_meta_set(store, "purged_ms", now_ms, st) && end_futures(store, st) &&
                    pen_ages_wait(store, now_ms, &wait, st) && (wait || remove_old(store, st)) &&
                    collect_loading(store, &collected, st) && trim_stats(store, st);
    *changed += collected;
    return ok;
}

static bool slice(struct pen_store *store, int64_t *changed, struct pen_status *st)
{
    return pen_meta_set(store, "purge", 0, st) && remove_gone(store, changed, st) &&
           (*changed > 0 || shrink_job(store, changed, st)) && do_seldom(store, changed, st);
}

/* An idle store is only read. */
static bool has_work(struct pen_store *store, int64_t *work, struct pen_status *st)
{
    return pen_db_value(store->db, st, work,
                        "SELECT 1 WHERE EXISTS (SELECT 1 FROM job WHERE removed_ms > 0) OR "
                        "EXISTS (SELECT 1 FROM object WHERE state = 2) OR NOT EXISTS "
                        "(SELECT 1 FROM meta WHERE name = 'purged_ms' AND CAST(value AS BIGINT) "
                        "BETWEEN (SELECT now_ms()) - $1 AND (SELECT now_ms()))",
                        "i", (int64_t)SELDOM_MS);
}

bool pen_store_purge(struct pen_store *store, bool *more, struct pen_status *st)
{
    int64_t changed = 0, work;
    *more = false;
    if (!has_work(store, &work, st))
        return false;
    if (work && (!pen_db_begin(store->db, PEN_DB_WRITE, st) ||
                 !pen_db_end(store->db, slice(store, &changed, st), st)))
        return false;
    *more = changed > 0;
    return *more || pen_db_maintain(store->db, SLICE_BYTES, more, st);
}
