/* SPDX-License-Identifier: MIT */
/* Jobs as readers see them, and their end by request: get, list, scene, cancel, delete, tidy. */
#include <stdlib.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

/* Pages given back by one transaction (SQL_VACUUM: 2048, 8 MiB), and transactions by one tidy. */
enum { VACUUM_ROUNDS = 128 };

/* The columns of JOB_COLUMNS (sqlite_sql.c), in order. */
enum {
    COL_NUMBER,
    COL_ID,
    COL_STATE,
    COL_REVISION,
    COL_KIND,
    COL_REQUEST,
    COL_ERROR,
    COL_PRIORITY,
    COL_MAX_ATTEMPTS,
    COL_CHARGES,
    COL_TIMEOUT,
    COL_CREATED,
    COL_STARTED,
    COL_FINISHED,
    COL_UPDATED,
    COL_DONE,
    COL_TOTAL
};

/* The attempt a job is on; charges are deaths, the last of which may have ended it. */
static int attempts_of(const struct pen_job_record *job, int64_t charges)
{
    int64_t attempts = job->started_ms ? charges + 1 : 0;
    return (int)(attempts < job->max_attempts ? attempts : job->max_attempts);
}

static bool fill_record(const struct pen_sqlite_query *row, struct pen_job_record *job,
                        struct pen_status *st)
{
    bool ok = true;
    *job = (struct pen_job_record){
        .number = pen_sqlite_column_int(row, COL_NUMBER),
        .state = (enum pen_job_state)pen_sqlite_column_int(row, COL_STATE),
        .revision = pen_sqlite_column_int(row, COL_REVISION),
        .kind = pen_sqlite_column_dup(row, COL_KIND, &ok),
        .request = pen_sqlite_column_dup(row, COL_REQUEST, &ok),
        .error = pen_sqlite_column_dup(row, COL_ERROR, &ok),
        .priority = (int)pen_sqlite_column_int(row, COL_PRIORITY),
        .max_attempts = (int)pen_sqlite_column_int(row, COL_MAX_ATTEMPTS),
        .timeout_ms = pen_sqlite_column_int(row, COL_TIMEOUT),
        .created_ms = pen_sqlite_column_int(row, COL_CREATED),
        .started_ms = pen_sqlite_column_int(row, COL_STARTED),
        .finished_ms = pen_sqlite_column_int(row, COL_FINISHED),
        .updated_ms = pen_sqlite_column_int(row, COL_UPDATED),
        .done_pixels = pen_sqlite_column_int(row, COL_DONE),
        .total_pixels = pen_sqlite_column_int(row, COL_TOTAL),
    };
    job->attempts = attempts_of(job, pen_sqlite_column_int(row, COL_CHARGES));
    const char *id = pen_sqlite_column_text(row, COL_ID);
    for (int i = 0; id && id[i] && i < PEN_ID_BYTES - 1; i++)
        job->id[i] = id[i];
    if (ok)
        return true;
    pen_job_record_release(job);
    return pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
}

bool pen_sqlite_job(struct pen_store *base, const char *id, struct pen_job_record *job,
                    struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(base), SQL_JOB_GET);
    pen_sqlite_text(&query, id);
    bool row;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    bool ok = fill_record(&query, job, st);
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_jobs(struct pen_store *base, const struct pen_job_filter *filter,
                     struct pen_job_record **jobs, int *count, struct pen_status *st)
{
    int limit = filter->limit > 0 ? filter->limit : 1;
    struct pen_job_record *list = calloc((size_t)limit, sizeof *list);
    if (!list)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a list of jobs");
    struct pen_sqlite_query query = pen_sqlite_query(
        pen_sqlite_of(base), filter->state < 0 ? SQL_JOB_LIST : SQL_JOB_LIST_STATE);
    pen_sqlite_int(&query, filter->below ? filter->below : INT64_MAX);
    pen_sqlite_text(&query, filter->kind);
    pen_sqlite_int(&query, limit);
    if (filter->state >= 0)
        pen_sqlite_int(&query, filter->state);
    int n = 0;
    bool row = true, ok = true;
    while (ok && row) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row)
            ok = fill_record(&query, &list[n], st) && ++n;
    }
    pen_sqlite_end(&query);
    if (!ok) {
        pen_job_records_free(list, n);
        return false;
    }
    *jobs = list;
    *count = n;
    return true;
}

bool pen_sqlite_scene(struct pen_store *base, const char *id, struct pen_buf *scene,
                      struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_SCENE_GET);
    pen_sqlite_text(&query, id);
    bool row;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    struct pen_bytes packed = pen_sqlite_column_blob(&query, 0), document;
    bool ok = pen_decompress(store->packer, packed.data, packed.bytes, &document, st);
    pen_sqlite_end(&query);
    if (!ok)
        return false;
    return pen_buf_add(scene, document.data, document.bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
}

bool pen_sqlite_end_job(struct pen_sqlite_store *store, int64_t number, enum pen_job_state state,
                        const char *error, struct pen_status *st)
{
    struct pen_sqlite_query job = pen_sqlite_query(store, SQL_JOB_END);
    pen_sqlite_int(&job, number);
    pen_sqlite_int(&job, state);
    pen_sqlite_text(&job, error);
    pen_sqlite_int(&job, pen_clock_wall_ms());
    if (!pen_sqlite_run(&job, st))
        return false;
    if (pen_sqlite_changes(store) == 0)
        return true;
    store->base.changed = true;
    struct pen_sqlite_query batches = pen_sqlite_query(store, SQL_BATCHES_END);
    pen_sqlite_int(&batches, number);
    return pen_sqlite_run(&batches, st);
}

static bool write_cancel(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    int64_t number;
    return pen_sqlite_job_number(store, arg, &number, st) &&
           pen_sqlite_end_job(store, number, PEN_JOB_CANCELLED, NULL, st);
}

bool pen_sqlite_cancel(struct pen_store *base, const char *id, struct pen_status *st)
{
    return pen_sqlite_transaction(pen_sqlite_of(base), write_cancel, (void *)(uintptr_t)id, st);
}

static bool write_remove(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const char *id = arg;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_NUMBER);
    pen_sqlite_text(&query, id);
    bool row;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    int64_t number = pen_sqlite_column_int(&query, 0), scene = pen_sqlite_column_int(&query, 2);
    enum pen_job_state state = (enum pen_job_state)pen_sqlite_column_int(&query, 1);
    pen_sqlite_end(&query);
    if (!pen_job_state_ended(state))
        return pen_fail(st, PEN_CONFLICT, "job %s is %s; cancel it before deleting it", id,
                        pen_job_state_name(state));
    struct pen_sqlite_query job = pen_sqlite_query(store, SQL_JOB_REMOVE);
    pen_sqlite_int(&job, number);
    struct pen_sqlite_query unused = pen_sqlite_query(store, SQL_SCENE_REMOVE_UNUSED);
    pen_sqlite_int(&unused, scene);
    store->base.changed = true;
    return pen_sqlite_run(&job, st) && pen_sqlite_run(&unused, st);
}

bool pen_sqlite_remove(struct pen_store *base, const char *id, struct pen_status *st)
{
    return pen_sqlite_transaction(pen_sqlite_of(base), write_remove, (void *)(uintptr_t)id, st);
}

static bool write_tidy(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    int64_t before_ms = pen_clock_wall_ms() - *(const int64_t *)arg;
    struct pen_sqlite_query keys = pen_sqlite_query(store, SQL_TIDY_KEYS);
    pen_sqlite_int(&keys, before_ms);
    struct pen_sqlite_query workers = pen_sqlite_query(store, SQL_TIDY_WORKERS);
    pen_sqlite_int(&workers, before_ms);
    struct pen_sqlite_query scenes = pen_sqlite_query(store, SQL_TIDY_SCENES);
    return pen_sqlite_run(&keys, st) && pen_sqlite_run(&workers, st) && pen_sqlite_run(&scenes, st);
}

/* Moves the file's end into its gaps, a bounded number of pages at a time so that writers get in
 * between; the file itself shrinks when the log is wound back. */
static bool give_room_back(struct pen_sqlite_store *store, struct pen_status *st)
{
    for (int round = 0; round < VACUUM_ROUNDS; round++) {
        struct pen_sqlite_query free_pages = pen_sqlite_query(store, SQL_FREE_PAGES);
        bool row;
        if (!pen_sqlite_next(&free_pages, &row, st))
            return false;
        int64_t count = row ? pen_sqlite_column_int(&free_pages, 0) : 0;
        pen_sqlite_end(&free_pages);
        if (count == 0)
            return true;
        struct pen_sqlite_query vacuum = pen_sqlite_query(store, SQL_VACUUM);
        if (!pen_sqlite_run(&vacuum, st))
            return false;
        pen_sqlite_wind_back_log(store);
    }
    return true;
}

bool pen_sqlite_purge(struct pen_store *base, int64_t key_age_ms, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    if (!pen_sqlite_transaction(store, write_tidy, &key_age_ms, st) || !give_room_back(store, st))
        return false;
    pen_sqlite_wind_back_log(store);
    return true;
}
