/* SPDX-License-Identifier: MIT */
/* Accepting a job: the key, the scene document, the job, its views and its batches, in one
 * transaction. The document is packed before the transaction begins, unless it is there already:
 * the write lock is held for the writing alone. */
#include <string.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

struct submission {
    const struct pen_job_new *job;
    struct pen_bytes document;
    bool packed;
    enum pen_submit_result result;
    struct pen_buf *first_answer;
};

/* Looks for the key. When it is there, sets the result and copies the answer given then. */
static bool find_key(struct pen_sqlite_store *store, struct submission *in, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_KEY_FIND);
    pen_sqlite_text(&query, in->job->idempotency_key);
    bool row;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (!row)
        return true;
    struct pen_bytes body = pen_sqlite_column_blob(&query, 0);
    bool same = body.bytes == 32 && memcmp(body.data, in->job->body_sha256, 32) == 0;
    in->result = same ? PEN_SUBMIT_REPEATED : PEN_SUBMIT_REUSED;
    const char *answer = pen_sqlite_column_text(&query, 1);
    bool ok = !same || (answer && pen_buf_puts(in->first_answer, answer));
    pen_sqlite_end(&query);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for the answer");
}

static bool add_key(struct pen_sqlite_store *store, const struct pen_job_new *job,
                    struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_KEY_ADD);
    pen_sqlite_text(&query, job->idempotency_key);
    pen_sqlite_blob(&query, job->body_sha256, 32);
    pen_sqlite_text(&query, job->answer);
    pen_sqlite_int(&query, pen_clock_wall_ms());
    return pen_sqlite_run(&query, st);
}

static bool find_scene(struct pen_sqlite_store *store, const struct pen_job_new *job, int64_t *id,
                       struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_SCENE_FIND);
    pen_sqlite_blob(&query, job->scene_sha256, 32);
    bool row;
    *id = 0;
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (row) {
        *id = pen_sqlite_column_int(&query, 0);
        pen_sqlite_end(&query);
    }
    return true;
}

static bool add_scene(struct pen_sqlite_store *store, struct submission *in, int64_t *id,
                      struct pen_status *st)
{
    if (!find_scene(store, in->job, id, st))
        return false;
    if (*id)
        return true;
    if (!in->packed &&
        !pen_compress(store->packer, in->job->scene, in->job->scene_bytes, &in->document, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_SCENE_ADD);
    pen_sqlite_blob(&query, in->job->scene_sha256, 32);
    pen_sqlite_blob(&query, in->document.data, in->document.bytes);
    if (!pen_sqlite_run(&query, st))
        return false;
    *id = sqlite3_last_insert_rowid(store->db);
    return true;
}

static bool add_job(struct pen_sqlite_store *store, const struct pen_job_new *job, int64_t scene,
                    int64_t *number, struct pen_status *st)
{
    int64_t pixels = 0;
    for (int i = 0; i < job->batch_count; i++)
        pixels += job->batches[i].pixels;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_ADD);
    pen_sqlite_text(&query, job->id);
    pen_sqlite_text(&query, job->kind);
    pen_sqlite_int(&query, scene);
    pen_sqlite_int(&query, job->priority);
    pen_sqlite_int(&query, job->max_attempts);
    pen_sqlite_int(&query, job->timeout_ms);
    pen_sqlite_int(&query, job->created_ms);
    pen_sqlite_int(&query, job->created_ms);
    pen_sqlite_int(&query, pixels);
    pen_sqlite_int(&query, job->view_count);
    pen_sqlite_text(&query, job->request);
    if (!pen_sqlite_run(&query, st))
        return false;
    *number = sqlite3_last_insert_rowid(store->db);
    return true;
}

static bool add_view(struct pen_sqlite_store *store, const struct pen_job_new *job, int64_t number,
                     int view, struct pen_status *st)
{
    int batches = 0;
    for (int i = 0; i < job->batch_count; i++)
        batches += job->batches[i].view == view;
    if (batches == 0)
        return pen_fail(st, PEN_INTERNAL, "view %d of a new job has no batch", view);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_VIEW_ADD);
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, view);
    pen_sqlite_text(&query, job->views[view].name);
    pen_sqlite_int(&query, job->views[view].width);
    pen_sqlite_int(&query, job->views[view].height);
    pen_sqlite_int(&query, batches);
    return pen_sqlite_run(&query, st);
}

static bool add_batch(struct pen_sqlite_store *store, int64_t number,
                      const struct pen_batch_new *batch, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_BATCH_ADD);
    pen_sqlite_int(&query, number);
    pen_sqlite_int(&query, batch->view);
    pen_sqlite_int(&query, batch->kind);
    pen_sqlite_int(&query, batch->first_tile);
    pen_sqlite_int(&query, batch->tile_count);
    pen_sqlite_int(&query, batch->pixels);
    return pen_sqlite_run(&query, st);
}

static bool write_submission(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    struct submission *in = arg;
    const struct pen_job_new *job = in->job;
    in->result = PEN_SUBMIT_CREATED;
    if (job->idempotency_key && !find_key(store, in, st))
        return false;
    if (in->result != PEN_SUBMIT_CREATED)
        return true;
    int64_t scene, number;
    if (!add_scene(store, in, &scene, st) || !add_job(store, job, scene, &number, st))
        return false;
    for (int i = 0; i < job->view_count; i++) {
        if (!add_view(store, job, number, i, st))
            return false;
    }
    for (int i = 0; i < job->batch_count; i++) {
        if (!add_batch(store, number, &job->batches[i], st))
            return false;
    }
    store->base.work = store->base.changed = true;
    return !job->idempotency_key || add_key(store, job, st);
}

bool pen_sqlite_submit(struct pen_store *base, const struct pen_job_new *job,
                       enum pen_submit_result *result, struct pen_buf *first_answer,
                       struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    struct submission in = {.job = job, .first_answer = first_answer};
    int64_t scene;
    if (!find_scene(store, job, &scene, st))
        return false;
    if (!scene) {
        in.packed = pen_compress(store->packer, job->scene, job->scene_bytes, &in.document, st);
        if (!in.packed)
            return false;
    }
    if (!pen_sqlite_transaction(store, write_submission, &in, st))
        return false;
    *result = in.result;
    return true;
}
