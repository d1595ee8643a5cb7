/* SPDX-License-Identifier: MIT */
/* Removing jobs, and what is old.
 *
 * A delete only marks the job, in a short transaction, and keeps its statistics in a row of their
 * own: from then on every other call about the job fails with PEN_GONE. Its rows, which may be
 * gigabytes, go later in slices (pen_store_purge_slice), a transaction for each, so that no other
 * writer waits long. The job's own row goes last: after a crash the next slice goes on.
 *
 * What is freed goes back to the file system before more is removed, since the time that takes
 * grows with the space that is free. If so much is free that it takes very long, removing comes
 * first: no delete of this version leaves that much. What was stored last goes first, so that
 * nothing is moved from the end of the file into a gap only to be removed there. */
#include "store/internal/policy.h"

enum {
    SLICE_BYTES = 4 << 20,       /* of stored values, which one slice removes */
    EARLY_BYTES = 8 << 20,       /* of free space: more is returned before more is removed */
    EARLY_MAX_BYTES = 512 << 20, /* of free space: with more, removing comes first */
    PURGE_ROWS = 500             /* keys, or statistics, which one transaction removes */
};

bool pen_fail_missing(struct pen_store *store, const char *id, struct pen_status *st)
{
    bool has_stats, found;
    if (!store->driver->ops->removed_get(store->driver, id, NULL, &has_stats, &found, st))
        return false;
    if (!found)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    return pen_fail(st, PEN_GONE, "job %s was removed%s", id,
                    has_stats ? "; only its statistics are left" : "");
}

struct removal {
    const char *id, *client, *stats;
};

/* Drops the statistics of a job that was removed before. */
static bool drop_stats(struct pen_store *store, const char *id, const char *client,
                       struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    bool has_stats, found;
    if (!driver->ops->removed_get(driver, id, NULL, &has_stats, &found, st))
        return false;
    if (!found || !has_stats)
        return pen_fail_missing(store, id, st);
    return pen_policy_check_client(store, id, client, st) &&
           driver->ops->removed_drop_stats(driver, id, st);
}

static bool write_delete(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct removal *in = arg;
    struct pen_driver *driver = store->driver;
    struct pen_job_key job;
    int64_t now_ms;
    bool found;
    if (!driver->ops->job_find(driver, in->id, &job, &found, st))
        return false;
    if (!found)
        return in->stats ? pen_fail_missing(store, in->id, st)
                         : drop_stats(store, in->id, in->client, st);
    if (!pen_policy_check_client(store, in->id, in->client, st))
        return false;
    if (!pen_job_state_ended(job.state))
        return pen_fail(st, PEN_CONFLICT, "job %s is %s; cancel it before deleting it", in->id,
                        pen_job_state_name(job.state));
    store->changed = true;
    return driver->ops->now(driver, &now_ms, st) &&
           driver->ops->job_mark_removed(driver, job.number, now_ms, st) &&
           driver->ops->removed_add(driver, in->id, now_ms, in->stats, st);
}

bool pen_policy_delete(struct pen_store *store, const char *id, const char *client,
                       const char *stats, struct pen_status *st)
{
    struct removal in = {id, client, stats};
    return pen_store_write(store, write_delete, &in, st);
}

bool pen_policy_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                              struct pen_status *st)
{
    bool has_stats, found;
    if (!store->driver->ops->removed_get(store->driver, id, stats, &has_stats, &found, st))
        return false;
    if (found && has_stats)
        return true;
    return found ? pen_fail(st, PEN_GONE, "job %s was removed with its statistics", id)
                 : pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
}

/* One slice of one job, unless another handle has removed the last one meanwhile. */
static bool write_slice(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_job_key job;
    bool found, emptied;
    (void)arg;
    if (!driver->ops->removed_next(driver, &job, &found, st))
        return false;
    if (!found)
        return true;
    if (!driver->ops->job_shrink(driver, job.number, SLICE_BYTES, &emptied, st))
        return false;
    return !emptied || (driver->ops->job_remove(driver, job.number, st) &&
                        driver->ops->scene_remove_unused(driver, job.scene, st));
}

/* Where it fails, there is nothing to remove that the reserve should be used for. */
static bool reclaim(struct pen_driver *driver, bool *more, struct pen_status *st)
{
    const bool ok = driver->ops->reclaim(driver, more, st);
    *more = *more && ok;
    return ok;
}

/* Returns whether there was something to return. Where it fails, for which a full disk is enough,
 * removing must go on. */
static bool reclaim_early(struct pen_driver *driver)
{
    struct pen_status ignored;
    struct pen_room room;
    bool more = false;
    return driver->ops->room(driver, &room, &ignored) && room.free_bytes > EARLY_BYTES &&
           room.free_bytes <= EARLY_MAX_BYTES && reclaim(driver, &more, &ignored) && more;
}

bool pen_policy_purge_slice(struct pen_store *store, bool *more, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_job_key job;
    *more = reclaim_early(driver);
    if (!*more && !pen_values_shrink(store, more, st))
        return false;
    if (*more)
        return driver->ops->keep_log_short(driver, st);
    if (!driver->ops->removed_next(driver, &job, more, st))
        return false;
    if (*more && !pen_store_write(store, write_slice, NULL, st))
        return false;
    return (*more || reclaim(driver, more, st)) && driver->ops->keep_log_short(driver, st);
}

struct purge {
    int64_t key_age_ms, stats_age_ms;
    bool more;
};

static bool write_purge(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct purge *purge = arg;
    struct pen_driver *driver = store->driver;
    int64_t now_ms;
    bool keys, rows;
    if (!driver->ops->now(driver, &now_ms, st))
        return false;
    int64_t before_ms = now_ms - purge->key_age_ms;
    bool ok = driver->ops->keys_remove(driver, before_ms, PURGE_ROWS, &keys, st) &&
              driver->ops->removed_purge(driver, before_ms, now_ms - purge->stats_age_ms,
                                         PURGE_ROWS, &rows, st) &&
              driver->ops->workers_remove(driver, before_ms, st) &&
              driver->ops->peers_remove(driver, before_ms, st);
    purge->more = ok && (keys || rows);
    return ok && (purge->more || driver->ops->scene_remove_unused(driver, 0, st));
}

bool pen_policy_purge(struct pen_store *store, int64_t key_age_ms, int64_t stats_age_ms,
                      struct pen_status *st)
{
    struct purge purge = {key_age_ms, stats_age_ms, true};
    int64_t now_ms;
    bool wait;
    if (!store->driver->ops->now(store->driver, &now_ms, st) ||
        !pen_ages_wait(store, now_ms, &wait, st))
        return false;
    purge.more = !wait;
    while (purge.more) {
        if (!pen_store_write(store, write_purge, &purge, st))
            return false;
    }
    return true;
}
