/* SPDX-License-Identifier: MIT */
/* Jobs for readers, and their end on request: get, list, scene, cancel. */
#include <stdlib.h>

#include "store/internal/policy.h"

bool pen_find_job(struct pen_store *store, const char *id, struct pen_job_key *job,
                  struct pen_status *st)
{
    bool found;
    return store->driver->ops->job_find(store->driver, id, job, &found, st) &&
           (found || pen_fail_missing(store, id, st));
}

bool pen_policy_check_client(struct pen_store *store, const char *id, const char *client,
                             struct pen_status *st)
{
    bool same = true;
    if (client && !store->driver->ops->job_is_of(store->driver, id, client, &same, st))
        return false;
    return same || pen_fail(st, PEN_FORBIDDEN,
                            "the job belongs to another client; a token of scope admin may cancel "
                            "or delete it");
}

/* Sets the attempt that the job is on: one more than its charges, unless the last one ended it. */
static void set_attempts(struct pen_job_row *row)
{
    struct pen_job_record *job = &row->record;
    int64_t attempts = job->started_ms ? row->charges + 1 : 0;
    job->attempts = (int)(attempts < job->max_attempts ? attempts : job->max_attempts);
}

bool pen_policy_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                    struct pen_status *st)
{
    struct pen_job_row row;
    bool found;
    if (!store->driver->ops->job_get(store->driver, id, &row, &found, st))
        return false;
    if (!found)
        return pen_fail_missing(store, id, st);
    set_attempts(&row);
    *job = row.record;
    return true;
}

bool pen_policy_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                     struct pen_job_record **jobs, int *count, struct pen_status *st)
{
    struct pen_job_filter bounded = *filter;
    bounded.limit = filter->limit > 0 ? filter->limit : 1;
    size_t capacity = (size_t)bounded.limit;
    struct pen_job_row *rows = malloc(capacity * sizeof *rows);
    struct pen_job_record *list = malloc(capacity * sizeof *list);
    bool ok = rows && list;
    if (!ok)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a list of jobs");
    ok = ok && store->driver->ops->job_page(store->driver, &bounded, rows, count, st);
    for (int i = 0; ok && i < *count; i++) {
        set_attempts(&rows[i]);
        list[i] = rows[i].record;
    }
    free(rows);
    *jobs = ok ? list : NULL;
    if (!ok)
        free(list);
    return ok;
}

/* Reads the compressed document of the job whose id is *arg. */
static bool read_scene(struct pen_store *store, void *arg, struct pen_status *st)
{
    const char *id = *(const char **)arg;
    int64_t number;
    size_t bytes;
    bool found;
    if (!store->driver->ops->scene_of_job(store->driver, id, &number, &bytes, &found, st))
        return false;
    if (!found)
        return pen_fail_missing(store, id, st);
    return pen_blob_load(store, PEN_BLOB_SCENE, number, bytes, st);
}

bool pen_policy_scene(struct pen_store *store, const char *id, struct pen_buf *scene,
                      struct pen_status *st)
{
    struct pen_bytes document;
    if (!pen_store_read(store, read_scene, &id, st) ||
        !pen_decompress(store->compressor, store->blob.data, store->blob.bytes, &document, st))
        return false;
    return pen_buf_add(scene, document.data, document.bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
}

bool pen_end_job(struct pen_store *store, int64_t job, enum pen_job_state state, const char *error,
                 struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    int64_t now_ms;
    bool changed;
    if (!driver->ops->now(driver, &now_ms, st) ||
        !driver->ops->job_end(driver, job, state, error, now_ms, &changed, st))
        return false;
    if (!changed)
        return true;
    store->changed = true;
    return driver->ops->job_end_batches(driver, job, st) &&
           driver->ops->job_artefacts_drop(driver, job, PEN_KEPT_LAYER, st);
}

struct cancel {
    const char *id, *client;
};

/* The time that workers have spent and not told yet is charged too: else who cancels soon enough
 * would be served for nothing. */
static bool write_cancel(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct cancel *in = arg;
    struct pen_driver *driver = store->driver;
    struct pen_job_key job;
    int64_t now_ms;
    return pen_find_job(store, in->id, &job, st) &&
           pen_policy_check_client(store, in->id, in->client, st) &&
           driver->ops->now(driver, &now_ms, st) &&
           driver->ops->job_charge_leases(driver, job.number, now_ms, st) &&
           pen_end_job(store, job.number, PEN_JOB_CANCELLED, NULL, st);
}

bool pen_policy_cancel(struct pen_store *store, const char *id, const char *client,
                       struct pen_status *st)
{
    struct cancel in = {id, client};
    return pen_store_write(store, write_cancel, &in, st);
}
