/* SPDX-License-Identifier: MIT */
/* Jobs as readers see them, and their end by request: get, list, scene, cancel, delete, tidy. */
#include <stdlib.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

/* Pages given back by one transaction (SQ_VACUUM: 2048, 8 MiB), and transactions by one tidy. */
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

static bool fill_record(const struct pen_sq_query *row, struct pen_job_record *job,
                        struct pen_status *st)
{
    bool ok = true;
    *job = (struct pen_job_record){
        .number = pen_sq_column_int(row, COL_NUMBER),
        .state = (enum pen_job_state)pen_sq_column_int(row, COL_STATE),
        .revision = pen_sq_column_int(row, COL_REVISION),
        .kind = pen_sq_column_dup(row, COL_KIND, &ok),
        .request = pen_sq_column_dup(row, COL_REQUEST, &ok),
        .error = pen_sq_column_dup(row, COL_ERROR, &ok),
        .priority = (int)pen_sq_column_int(row, COL_PRIORITY),
        .max_attempts = (int)pen_sq_column_int(row, COL_MAX_ATTEMPTS),
        .timeout_ms = pen_sq_column_int(row, COL_TIMEOUT),
        .created_ms = pen_sq_column_int(row, COL_CREATED),
        .started_ms = pen_sq_column_int(row, COL_STARTED),
        .finished_ms = pen_sq_column_int(row, COL_FINISHED),
        .updated_ms = pen_sq_column_int(row, COL_UPDATED),
        .done_pixels = pen_sq_column_int(row, COL_DONE),
        .total_pixels = pen_sq_column_int(row, COL_TOTAL),
    };
    job->attempts = attempts_of(job, pen_sq_column_int(row, COL_CHARGES));
    const char *id = pen_sq_column_text(row, COL_ID);
    for (int i = 0; id && id[i] && i < PEN_ID_BYTES - 1; i++)
        job->id[i] = id[i];
    if (ok)
        return true;
    pen_job_record_release(job);
    return pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
}

bool pen_sq_job(struct pen_store *base, const char *id, struct pen_job_record *job,
                struct pen_status *st)
{
    struct pen_sq_query query = pen_sq_query(pen_sq_of(base), SQ_JOB_GET);
    pen_sq_text(&query, id);
    bool row;
    if (!pen_sq_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    bool ok = fill_record(&query, job, st);
    pen_sq_end(&query);
    return ok;
}

bool pen_sq_jobs(struct pen_store *base, const struct pen_job_filter *filter,
                 struct pen_job_record **jobs, int *count, struct pen_status *st)
{
    int limit = filter->limit > 0 ? filter->limit : 1;
    struct pen_job_record *list = calloc((size_t)limit, sizeof *list);
    if (!list)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a list of jobs");
    struct pen_sq_query query =
        pen_sq_query(pen_sq_of(base), filter->state < 0 ? SQ_JOB_LIST : SQ_JOB_LIST_STATE);
    pen_sq_int(&query, filter->below ? filter->below : INT64_MAX);
    pen_sq_text(&query, filter->kind);
    pen_sq_int(&query, limit);
    if (filter->state >= 0)
        pen_sq_int(&query, filter->state);
    int n = 0;
    bool row = true, ok = true;
    while (ok && row) {
        ok = pen_sq_next(&query, &row, st);
        if (ok && row)
            ok = fill_record(&query, &list[n], st) && ++n;
    }
    pen_sq_end(&query);
    if (!ok) {
        pen_job_records_free(list, n);
        return false;
    }
    *jobs = list;
    *count = n;
    return true;
}

bool pen_sq_scene(struct pen_store *base, const char *id, struct pen_buf *scene,
                  struct pen_status *st)
{
    struct pen_sq_store *store = pen_sq_of(base);
    struct pen_sq_query query = pen_sq_query(store, SQ_SCENE_GET);
    pen_sq_text(&query, id);
    bool row;
    if (!pen_sq_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    struct pen_packed packed = pen_sq_column_blob(&query, 0), document;
    bool ok = pen_unpack(store->packer, packed.data, packed.bytes, &document, st);
    pen_sq_end(&query);
    if (!ok)
        return false;
    return pen_buf_add(scene, document.data, document.bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
}

bool pen_sq_end_job(struct pen_sq_store *store, int64_t number, enum pen_job_state state,
                    const char *error, struct pen_status *st)
{
    struct pen_sq_query job = pen_sq_query(store, SQ_JOB_END);
    pen_sq_int(&job, number);
    pen_sq_int(&job, state);
    pen_sq_text(&job, error);
    pen_sq_int(&job, pen_clock_wall_ms());
    if (!pen_sq_run(&job, st))
        return false;
    if (pen_sq_changes(store) == 0)
        return true;
    store->base.news = true;
    struct pen_sq_query batches = pen_sq_query(store, SQ_BATCHES_END);
    pen_sq_int(&batches, number);
    return pen_sq_run(&batches, st);
}

static bool write_cancel(struct pen_sq_store *store, void *arg, struct pen_status *st)
{
    int64_t number;
    return pen_sq_job_number(store, arg, &number, st) &&
           pen_sq_end_job(store, number, PEN_JOB_CANCELLED, NULL, st);
}

bool pen_sq_cancel(struct pen_store *base, const char *id, struct pen_status *st)
{
    return pen_sq_transaction(pen_sq_of(base), write_cancel, (void *)(uintptr_t)id, st);
}

static bool write_remove(struct pen_sq_store *store, void *arg, struct pen_status *st)
{
    const char *id = arg;
    struct pen_sq_query query = pen_sq_query(store, SQ_JOB_NUMBER);
    pen_sq_text(&query, id);
    bool row;
    if (!pen_sq_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    int64_t number = pen_sq_column_int(&query, 0), scene = pen_sq_column_int(&query, 2);
    enum pen_job_state state = (enum pen_job_state)pen_sq_column_int(&query, 1);
    pen_sq_end(&query);
    if (!pen_job_state_ended(state))
        return pen_fail(st, PEN_CONFLICT, "job %s is %s; cancel it before deleting it", id,
                        pen_job_state_name(state));
    struct pen_sq_query job = pen_sq_query(store, SQ_JOB_REMOVE);
    pen_sq_int(&job, number);
    struct pen_sq_query unused = pen_sq_query(store, SQ_SCENE_REMOVE_UNUSED);
    pen_sq_int(&unused, scene);
    store->base.news = true;
    return pen_sq_run(&job, st) && pen_sq_run(&unused, st);
}

bool pen_sq_remove(struct pen_store *base, const char *id, struct pen_status *st)
{
    return pen_sq_transaction(pen_sq_of(base), write_remove, (void *)(uintptr_t)id, st);
}

static bool write_tidy(struct pen_sq_store *store, void *arg, struct pen_status *st)
{
    int64_t before_ms = pen_clock_wall_ms() - *(const int64_t *)arg;
    struct pen_sq_query keys = pen_sq_query(store, SQ_TIDY_KEYS);
    pen_sq_int(&keys, before_ms);
    struct pen_sq_query workers = pen_sq_query(store, SQ_TIDY_WORKERS);
    pen_sq_int(&workers, before_ms);
    struct pen_sq_query scenes = pen_sq_query(store, SQ_TIDY_SCENES);
    return pen_sq_run(&keys, st) && pen_sq_run(&workers, st) && pen_sq_run(&scenes, st);
}

/* Moves the file's end into its gaps, a bounded number of pages at a time so that writers get in
 * between; the file itself shrinks when the log is wound back. */
static bool give_room_back(struct pen_sq_store *store, struct pen_status *st)
{
    for (int round = 0; round < VACUUM_ROUNDS; round++) {
        struct pen_sq_query free_pages = pen_sq_query(store, SQ_FREE_PAGES);
        bool row;
        if (!pen_sq_next(&free_pages, &row, st))
            return false;
        int64_t count = row ? pen_sq_column_int(&free_pages, 0) : 0;
        pen_sq_end(&free_pages);
        if (count == 0)
            return true;
        struct pen_sq_query vacuum = pen_sq_query(store, SQ_VACUUM);
        if (!pen_sq_run(&vacuum, st))
            return false;
        pen_sq_wind_back_log(store);
    }
    return true;
}

bool pen_sq_purge(struct pen_store *base, int64_t key_age_ms, struct pen_status *st)
{
    struct pen_sq_store *store = pen_sq_of(base);
    if (!pen_sq_transaction(store, write_tidy, &key_age_ms, st) || !give_room_back(store, st))
        return false;
    pen_sq_wind_back_log(store);
    return true;
}
