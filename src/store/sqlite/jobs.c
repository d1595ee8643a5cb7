/* SPDX-License-Identifier: MIT */
/* Rows of jobs, idempotency keys, scenes and views. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

#define COLUMN(name) JOB_##name,
enum { PEN_SQLITE_JOB_COLUMNS(COLUMN, COLUMN) };

bool pen_sqlite_key_add(struct pen_driver *driver, const struct pen_key_row *key, bool *added,
                        struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_KEY_ADD);
    pen_sqlite_text(&query, key->client);
    pen_sqlite_text(&query, key->key);
    pen_sqlite_blob(&query, key->body_sha256, 32);
    pen_sqlite_text(&query, key->answer);
    pen_sqlite_int(&query, key->created_ms);
    return pen_sqlite_run_changed(&query, added, st);
}

bool pen_sqlite_key_get(struct pen_driver *driver, const char *client, const char *key,
                        unsigned char body_sha256[32], struct pen_buf *answer, bool *found,
                        struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_KEY_GET);
    pen_sqlite_text(&query, client);
    pen_sqlite_text(&query, key);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (!*found)
        return true;
    struct pen_bytes body = pen_sqlite_column_blob(&query, 0);
    const char *text = pen_sqlite_column_text(&query, 1);
    memset(body_sha256, 0, 32);
    if (body.bytes == 32)
        memcpy(body_sha256, body.data, 32);
    bool ok = !answer || (text && pen_buf_puts(answer, text));
    pen_sqlite_end(&query);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for the answer");
}

bool pen_sqlite_keys_remove(struct pen_driver *driver, int64_t before_ms, int limit, bool *more,
                            struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_KEYS_REMOVE);
    pen_sqlite_int(&query, before_ms);
    return pen_sqlite_run_limited(&query, limit, more, st);
}

bool pen_sqlite_scene_find(struct pen_driver *driver, const unsigned char sha256[32],
                           int64_t *number, bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_SCENE_FIND);
    pen_sqlite_blob(&query, sha256, 32);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (*found) {
        *number = pen_sqlite_column_int(&query, 0);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_scene_remove_unused(struct pen_driver *driver, int64_t number,
                                    struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(
        pen_sqlite_of(driver), number ? SQL_SCENE_REMOVE_UNUSED : SQL_SCENES_REMOVE_UNUSED);
    if (number)
        pen_sqlite_int(&query, number);
    return pen_sqlite_run(&query, st);
}

/* Notes what lists may be filtered by. */
static bool add_attributes(struct pen_sqlite_store *store, int64_t job, const char *request,
                           struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_ATTRIBUTES);
    pen_sqlite_int(&query, job);
    pen_sqlite_text(&query, request);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_job_add(struct pen_driver *driver, const struct pen_job_new *job, int64_t scene,
                        int64_t total_pixels, int64_t *number, bool *added, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_ADD);
    pen_sqlite_text(&query, job->id);
    pen_sqlite_text(&query, job->kind);
    pen_sqlite_int(&query, scene);
    pen_sqlite_int(&query, job->priority);
    pen_sqlite_int(&query, job->max_attempts);
    pen_sqlite_int(&query, job->timeout_ms);
    pen_sqlite_int(&query, job->created_ms);
    pen_sqlite_int(&query, total_pixels);
    pen_sqlite_int(&query, job->view_count);
    pen_sqlite_text(&query, job->request);
    pen_sqlite_text(&query, pen_job_client(job));
    pen_sqlite_int(&query, job->created.boot);
    pen_sqlite_int(&query, job->created.us);
    if (!pen_sqlite_run_changed(&query, added, st))
        return false;
    *number = sqlite3_last_insert_rowid(store->db);
    return !*added || (add_attributes(store, *number, job->request, st) &&
                       pen_sqlite_share_enter(driver, job, *number, st));
}

bool pen_sqlite_view_add(struct pen_driver *driver, int64_t job, int view,
                         const struct pen_view_new *what, int batches, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_VIEW_ADD);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, view);
    pen_sqlite_text(&query, what->name);
    pen_sqlite_int(&query, what->width);
    pen_sqlite_int(&query, what->height);
    pen_sqlite_int(&query, batches);
    return pen_sqlite_run(&query, st);
}

static bool fill_row(const struct pen_sqlite_query *query, struct pen_job_row *row,
                     struct pen_status *st)
{
    bool ok = true;
    *row = (struct pen_job_row){
        .charges = pen_sqlite_column_int(query, JOB_charges),
        .scene = pen_sqlite_column_int(query, JOB_scene),
        .record = {
            .number = pen_sqlite_column_int(query, JOB_number),
            .state = (enum pen_job_state)pen_sqlite_column_int(query, JOB_state),
            .revision = pen_sqlite_column_int(query, JOB_revision),
            .kind = pen_sqlite_column_dup(query, JOB_kind, &ok),
            .request = pen_sqlite_column_dup(query, JOB_request, &ok),
            .error = pen_sqlite_column_dup(query, JOB_error, &ok),
            .priority = (int)pen_sqlite_column_int(query, JOB_priority),
            .max_attempts = (int)pen_sqlite_column_int(query, JOB_max_attempts),
            .timeout_ms = pen_sqlite_column_int(query, JOB_timeout_ms),
            .created_ms = pen_sqlite_column_int(query, JOB_created_ms),
            .started_ms = pen_sqlite_column_int(query, JOB_started_ms),
            .finished_ms = pen_sqlite_column_int(query, JOB_finished_ms),
            .updated_ms = pen_sqlite_column_int(query, JOB_updated_ms),
            .done_pixels = pen_sqlite_column_int(query, JOB_done_pixels),
            .total_pixels = pen_sqlite_column_int(query, JOB_total_pixels),
            .work = pen_sqlite_column_int(query, JOB_work),
            .estimate_ms = pen_sqlite_column_int(query, JOB_estimate_ms),
            .told_us = pen_sqlite_column_int(query, JOB_told_us),
            .told_elapsed_us = pen_sqlite_column_int(query, JOB_told_elapsed_us),
            .elapsed_us = pen_sqlite_column_int(query, JOB_elapsed_us),
            .queue_us = pen_sqlite_column_int(query, JOB_queue_us),
        }};
    const char *id = pen_sqlite_column_text(query, JOB_id);
    size_t length = id ? strlen(id) : 0;
    if (length < sizeof row->record.id)
        memcpy(row->record.id, id ? id : "", length + 1);
    if (ok && id)
        return true;
    pen_job_record_release(&row->record);
    return pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
}

bool pen_sqlite_job_get(struct pen_driver *driver, const char *id, struct pen_job_row *job,
                        bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_GET);
    pen_sqlite_text(&query, id);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (!*found)
        return true;
    bool ok = fill_row(&query, job, st);
    pen_sqlite_end(&query);
    return ok;
}

/* The statement for a list: by the condition that the fewest jobs are likely to meet. */
static enum pen_sqlite_sql list_for(const struct pen_job_filter *filter)
{
    return filter->label_key    ? SQL_JOB_LIST_LABEL
           : filter->name       ? SQL_JOB_LIST_NAME
           : filter->state >= 0 ? SQL_JOB_LIST_STATE
           : filter->kind       ? SQL_JOB_LIST_KIND
                                : SQL_JOB_LIST;
}

/* Whether the texts of so many jobs end the list. */
static bool is_full(const struct pen_job_filter *filter, int count, size_t bytes)
{
    return filter->text_bytes > 0 && count > 1 && bytes > filter->text_bytes;
}

bool pen_sqlite_job_page(struct pen_driver *driver, const struct pen_job_filter *filter,
                         struct pen_job_row *rows, int *count, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), list_for(filter));
    pen_sqlite_int(&query, filter->below ? filter->below : INT64_MAX);
    pen_sqlite_text(&query, filter->kind);
    pen_sqlite_int(&query, filter->limit);
    pen_sqlite_text(&query, filter->name);
    pen_sqlite_text(&query, filter->label_key);
    pen_sqlite_text(&query, filter->label_value);
    if (filter->state >= 0)
        pen_sqlite_int(&query, filter->state);
    bool row = true, ok = true;
    size_t bytes = 0;
    *count = 0;
    while (ok && row && *count < filter->limit && !is_full(filter, *count, bytes)) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row)
            ok = fill_row(&query, &rows[*count], st) && ++*count;
        if (ok && row)
            bytes += pen_job_record_text_bytes(&rows[*count - 1].record);
    }
    pen_sqlite_end(&query);
    while (!ok && *count > 0)
        pen_job_record_release(&rows[--*count].record);
    return ok;
}

bool pen_sqlite_next_job_key(struct pen_sqlite_query *query, struct pen_job_key *job, bool *found,
                             struct pen_status *st)
{
    if (!pen_sqlite_next(query, found, st))
        return false;
    if (!*found)
        return true;
    *job = (struct pen_job_key){.number = pen_sqlite_column_int(query, 0),
                                .state = (enum pen_job_state)pen_sqlite_column_int(query, 1),
                                .scene = pen_sqlite_column_int(query, 2)};
    pen_sqlite_end(query);
    return true;
}

bool pen_sqlite_job_find(struct pen_driver *driver, const char *id, struct pen_job_key *job,
                         bool *found, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_FIND);
    pen_sqlite_text(&query, id);
    return pen_sqlite_next_job_key(&query, job, found, st);
}

bool pen_sqlite_job_is_of(struct pen_driver *driver, const char *id, const char *client, bool *is,
                          struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_IS_OF);
    int64_t same = 0;
    pen_sqlite_text(&query, id);
    pen_sqlite_text(&query, client);
    const bool ok = pen_sqlite_value(&query, &same, st);
    *is = same != 0;
    return ok;
}

static bool count_batches(struct pen_sqlite_store *store, struct pen_counts *counts,
                          struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_COUNTS);
    bool row;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (row) {
        counts->open_batches = pen_sqlite_column_int(&query, 0);
        counts->leased_batches = pen_sqlite_column_int(&query, 1);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_job_counts(struct pen_driver *driver, struct pen_counts *counts,
                           struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_COUNTS);
    bool row = true;
    *counts = (struct pen_counts){0};
    while (row) {
        if (!pen_sqlite_next(&query, &row, st))
            return false;
        int64_t state = row ? pen_sqlite_column_int(&query, 0) : -1;
        if (state >= 0 && state < PEN_JOB_STATE_COUNT)
            counts->jobs[state] = pen_sqlite_column_int(&query, 1);
    }
    struct pen_sqlite_query oldest = pen_sqlite_query(store, SQL_OLDEST_QUEUED);
    if (!pen_sqlite_value(&oldest, &counts->oldest_queued_ms, st))
        return false;
    int64_t log;
    pen_sqlite_file_bytes(store, "", &counts->bytes);
    pen_sqlite_file_bytes(store, "-wal", &log);
    counts->bytes += log;
    return count_batches(store, counts, st);
}

static void bind_moment(struct pen_sqlite_query *query)
{
    const struct pen_moment moment = pen_clock_moment();
    pen_sqlite_int(query, moment.boot);
    pen_sqlite_int(query, moment.us);
}

bool pen_sqlite_job_start(struct pen_driver *driver, int64_t job, int64_t now_ms, bool *changed,
                          struct pen_status *st)
{
    const enum pen_sqlite_sql statements[] = {SQL_JOB_START, SQL_JOB_ELAPSE};
    bool ok = true, elapsed;
    *changed = false;
    for (int i = 0; i < 2 && ok && !*changed; i++) {
        struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), statements[i]);
        pen_sqlite_int(&query, job);
        pen_sqlite_int(&query, now_ms);
        bind_moment(&query);
        ok = pen_sqlite_run_changed(&query, i == 0 ? changed : &elapsed, st);
    }
    return ok;
}

bool pen_sqlite_job_progress(struct pen_driver *driver, const struct pen_progress *progress,
                             struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_PROGRESS);
    const struct pen_buf *map = progress->cost_map;
    pen_sqlite_int(&query, progress->job);
    pen_sqlite_int(&query, progress->pixels);
    pen_sqlite_int(&query, progress->add);
    pen_sqlite_int(&query, progress->now_ms);
    pen_sqlite_int(&query, progress->forgive);
    pen_sqlite_int(&query, progress->estimate_ms);
    pen_sqlite_int(&query, progress->raise);
    pen_sqlite_int(&query, progress->batch);
    pen_sqlite_int(&query, progress->work);
    pen_sqlite_blob(&query, map ? map->data : NULL, map ? map->bytes : 0);
    bind_moment(&query);
    if (!pen_sqlite_run(&query, st))
        return false;
    query = pen_sqlite_query(store, SQL_BATCH_WORK);
    pen_sqlite_int(&query, progress->batch);
    pen_sqlite_int(&query, progress->work);
    return progress->batch == 0 || pen_sqlite_run(&query, st);
}

bool pen_sqlite_job_cost_map(struct pen_driver *driver, const char *id, struct pen_buf *out,
                             struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_COST_MAP);
    bool found;
    pen_sqlite_text(&query, id);
    if (!pen_sqlite_next(&query, &found, st))
        return false;
    const struct pen_bytes map = found ? pen_sqlite_column_blob(&query, 0) : (struct pen_bytes){0};
    const bool ok = map.bytes == 0 || pen_buf_add(out, map.data, map.bytes);
    if (found)
        pen_sqlite_end(&query);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for the map of a job's work");
}

bool pen_sqlite_job_view_ended(struct pen_driver *driver, int64_t job, int64_t *open_views,
                               struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_VIEW_ENDED);
    bool row;
    pen_sqlite_int(&query, job);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return pen_fail(st, PEN_STORAGE, "a batch without a job");
    *open_views = pen_sqlite_column_int(&query, 0);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_job_succeed(struct pen_driver *driver, int64_t job, int64_t now_ms,
                            struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_SUCCEED);
    bool changed;
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run_changed(&query, &changed, st) &&
           (!changed || pen_sqlite_share_leave(driver, job, st));
}

bool pen_sqlite_job_end(struct pen_driver *driver, int64_t job, enum pen_job_state state,
                        const char *error, int64_t now_ms, bool *changed, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_END);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, state);
    pen_sqlite_text(&query, error);
    pen_sqlite_int(&query, now_ms);
    bind_moment(&query);
    return pen_sqlite_run_changed(&query, changed, st) &&
           (!*changed || pen_sqlite_share_leave(driver, job, st));
}

bool pen_sqlite_job_end_batches(struct pen_driver *driver, int64_t job, struct pen_status *st)
{
    return pen_sqlite_run_with(pen_sqlite_of(driver), SQL_JOB_END_BATCHES, job, st);
}

bool pen_sqlite_job_remove(struct pen_driver *driver, int64_t job, struct pen_status *st)
{
    return pen_sqlite_run_with(pen_sqlite_of(driver), SQL_JOB_REMOVE, job, st);
}

bool pen_sqlite_job_set_deaths(struct pen_driver *driver, int64_t job, int64_t deaths,
                               int64_t paused_until_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_SET_DEATHS);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, deaths);
    pen_sqlite_int(&query, paused_until_ms);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_job_set_charges(struct pen_driver *driver, int64_t job, int64_t charges,
                                int64_t now_ms, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_JOB_SET_CHARGES);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, charges);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}
