/* SPDX-License-Identifier: MIT */
/* Submit: the key, the scene document, the job, its views and batches, in one transaction. The
 * document is compressed before this transaction, and a large document is also written before
 * it. */
#include <jansson.h>
#include <string.h>

#include "store/internal/objects.h"

struct submission {
    const struct pen_job_new *job;
    const char *client;
    enum pen_submit_result *result;
    struct pen_buf *first_answer;
    json_t *request;            /* NULL: the text is not valid JSON */
    struct pen_object document; /* compressed; without data: the scene is already stored */
    int64_t number;
    bool missing; /* out: the scene is not stored, and there is no document */
};

/* Looks for an earlier use of the key. With the same body, its answer is returned; with another
 * body, the submit is refused. */
static bool find_key(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    size_t bytes;
    bool ok = true;
    if (!in->job->idempotency_key)
        return true;
    struct pen_rows *rows = pen_db_rows(
        store->db, st, "SELECT body_sha256, answer FROM key WHERE client = $1 AND key = $2", "tt",
        in->client, in->job->idempotency_key);
    if (pen_db_next(rows)) {
        const void *body = pen_db_bytes(rows, 0, &bytes);
        const bool same = bytes == 32 && memcmp(body, in->job->body_sha256, 32) == 0;
        *in->result = same ? PEN_SUBMIT_REPEATED : PEN_SUBMIT_REUSED;
        ok = !same || pen_buf_puts(in->first_answer, pen_db_text(rows, 1)) ||
             pen_fail(st, PEN_NO_MEMORY, "no memory for the answer of a key");
    }
    return pen_db_done(rows) && ok;
}

/* Looks for a stored job of this id: the same job, or another one. */
static bool find_job(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    const struct pen_job_new *job = in->job;
    int64_t found; /* 1: the same, 2: another one */
    if (!pen_db_value(store->db, st, &found,
                      "SELECT CASE WHEN job.client = $2 AND job.kind = $3 AND job.request = $4 "
                      "AND scene.sha256 = $5 THEN 1 ELSE 2 END FROM job "
                      "LEFT JOIN scene ON scene.number = job.scene WHERE job.id = $1",
                      "ttttb", job->id, in->client, job->kind, job->request,
                      (const void *)job->scene_sha256, (size_t)32))
        return false;
    if (found == 1)
        *in->result = PEN_SUBMIT_KNOWN;
    return found < 2 || pen_fail(st, PEN_CONFLICT, "another job has the id %s", job->id);
}

static bool check_queue(struct pen_store *store, const struct submission *in, struct pen_status *st)
{
    const int64_t all_max = in->job->queue_max, own_max = in->job->client_queue_max;
    int64_t all, own;
    if (all_max == 0 && own_max == 0)
        return true;
    if (!pen_row_numbers(pen_db_rows(store->db, st,
                                     "SELECT (SELECT count(*) FROM job WHERE state < 2), (SELECT "
                                     "count(*) FROM job WHERE client = $1 AND state < 2)",
                                     "t", in->client),
                         &all, &own, NULL))
        return false;
    const bool of_all = all_max > 0 && all >= all_max;
    const int64_t jobs = of_all ? all : own, most = of_all ? all_max : own_max;
    return most == 0 || jobs < most ||
           pen_fail(st, PEN_QUOTA, "%lld job%s%s%s %s, at most %lld %s allowed; try again later",
                    (long long)jobs, jobs == 1 ? "" : "s", of_all ? "" : " of client ",
                    of_all ? "" : in->client, jobs == 1 ? "waits or runs" : "wait or run",
                    (long long)most, most == 1 ? "is" : "are");
}

static bool add_key(struct pen_store *store, const struct submission *in, struct pen_status *st)
{
    return !in->job->idempotency_key ||
           pen_db_run(store->db, st, NULL,
                      "INSERT INTO key (client, key, body_sha256, answer, created_ms) "
                      "VALUES ($1, $2, $3, $4, (SELECT now_ms()))",
                      "ttbt", in->client, in->job->idempotency_key,
                      (const void *)in->job->body_sha256, (size_t)32, in->job->answer);
}

static bool add_attribute(struct pen_store *store, int64_t job, const char *prefix, const char *key,
                          const json_t *value, struct pen_status *st)
{
    char name[512];
    if (!json_is_string(value))
        return true;
    snprintf(name, sizeof name, "%s%s", prefix, key);
    return pen_db_run(store->db, st, NULL,
                      "INSERT INTO attribute (key, value, job) VALUES ($1, $2, $3) "
                      "ON CONFLICT DO NOTHING",
                      "tti", name, json_string_value(value), job);
}

/* Stores the attributes that lists are filtered by: the request's name and labels, if it is a JSON
 * object. */
static bool add_attributes(struct pen_store *store, const struct submission *in,
                           struct pen_status *st)
{
    const char *key;
    json_t *value;
    bool ok =
        add_attribute(store, in->number, "", "name", json_object_get(in->request, "name"), st);
    json_object_foreach(json_object_get(in->request, "labels"), key, value) ok =
        ok && add_attribute(store, in->number, "label:", key, value, st);
    return ok;
}

static bool add_scene(struct pen_store *store, struct submission *in, int64_t *scene,
                      struct pen_status *st)
{
    if (!pen_scene_find(store, in->job->scene_sha256, scene, st))
        return false;
    in->missing = *scene == 0 && !in->document.data;
    return *scene > 0 || in->missing ||
           pen_scene_add(store, in->job->scene_sha256, &in->document, scene, st);
}

static bool add_job(struct pen_store *store, struct submission *in, int64_t scene, int64_t bytes,
                    struct pen_status *st)
{
    const struct pen_job_new *job = in->job;
    int64_t pixels = 0;
    for (int i = 0; i < job->batch_count; i++)
        pixels += job->batches[i].pixels;
    return pen_db_value(
        store->db, st, &in->number,
        "INSERT INTO job (id, client, kind, priority, scene, request, max_attempts, "
        "timeout_ms, open_views, total_pixels, moment_boot, moment_us, moment_ms, "
        "created_ms, updated_ms, results_bytes, revision, state, charges, losses, "
        "done_pixels, work, spent_us, told_us, told_elapsed_us, estimate_ms, elapsed_us, "
        "queue_us, started_ms, finished_ms, removed_ms) VALUES ($1, $2, $3, $4, $5, $6, $7, "
        "$8, $9, $10, $11, $12, $13, $13, $13, $14, 1, "
        "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0) RETURNING number",
        "tttiitiiiiiiii", job->id, in->client, job->kind, (int64_t)job->priority, scene,
        job->request, (int64_t)job->max_attempts, job->timeout_ms, (int64_t)job->view_count, pixels,
        job->created.boot, job->created.us, job->created_ms, bytes);
}

static bool add_views(struct pen_store *store, const struct submission *in, struct pen_status *st)
{
    const struct pen_job_new *job = in->job;
    bool ok = true;
    for (int view = 0; ok && view < job->view_count; view++) {
        int64_t batches = 0;
        for (int i = 0; i < job->batch_count; i++)
            batches += job->batches[i].view == view;
        if (batches == 0)
            return pen_fail(st, PEN_INTERNAL, "view %d of a new job has no batch", view);
        ok = pen_db_run(store->db, st, NULL,
                        "INSERT INTO view (job, view, name, width, height, batches, open_batches) "
                        "VALUES ($1, $2, $3, $4, $5, $6, $6)",
                        "iitiii", in->number, (int64_t)view, job->views[view].name,
                        (int64_t)job->views[view].width, (int64_t)job->views[view].height, batches);
    }
    return ok;
}

static bool add_batches(struct pen_store *store, const struct submission *in, struct pen_status *st)
{
    const struct pen_job_new *job = in->job;
    int64_t turn;
    bool ok = pen_turn_next(store, in->number, &turn, st);
    for (int i = 0; ok && i < job->batch_count; i++) {
        const struct pen_batch_new *batch = &job->batches[i];
        ok = pen_db_run(store->db, st, NULL,
                        "INSERT INTO batch (job, view, kind, first_tile, tile_count, pixels, "
                        "told_pixels, work, state, priority, client, turn, not_before_ms, alone, "
                        "attempt, serial, claimed_ms, lease_ms, spent_us, revision, commit_us) "
                        "VALUES ($1, $2, $3, $4, $5, $6, 0, 0, 0, $7, $8, $9, 0, 0, 0, 0, 0, 0, 0, "
                        "0, 0)",
                        "iiiiiiiti", in->number, (int64_t)batch->view, (int64_t)batch->kind,
                        (int64_t)batch->first_tile, (int64_t)batch->tile_count, batch->pixels,
                        (int64_t)job->priority, in->client, turn + i);
    }
    return ok;
}

/* The expected size of the results: 10 bytes a pixel (2 to 8 bytes for its batch, the rest for its
 * picture), and 12 for each layer beside the picture, which `layers` has too. */
static int64_t results_bytes(const struct submission *in)
{
    const size_t layers = json_array_size(json_object_get(in->request, "layers"));
    int64_t pixels = 0;
    for (int i = 0; i < in->job->view_count; i++)
        pixels += (int64_t)in->job->views[i].width * in->job->views[i].height;
    return pixels * (10 + 12 * (layers > 1 ? (int64_t)layers - 1 : 0));
}

static bool write_submission(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    const int64_t bytes = results_bytes(in);
    int64_t scene;
    in->missing = false;
    *in->result = PEN_SUBMIT_CREATED;
    if (!find_key(store, in, st))
        return false;
    if (*in->result == PEN_SUBMIT_CREATED && !find_job(store, in, st))
        return false;
    if (*in->result != PEN_SUBMIT_CREATED)
        return true;
    if (!check_queue(store, in, st) || !pen_intake(store, bytes, st) ||
        !add_scene(store, in, &scene, st))
        return false;
    return in->missing || (add_key(store, in, st) && add_job(store, in, scene, bytes, st) &&
                           add_attributes(store, in, st) && add_views(store, in, st) &&
                           add_batches(store, in, st));
}

/* Prepares the document for storing, unless it is already stored. */
static bool prepare(struct pen_store *store, struct submission *in, struct pen_status *st)
{
    struct pen_bytes document;
    int64_t stored = 0;
    if (!in->missing &&
        !pen_db_value(store->db, st, &stored, "SELECT 1 FROM scene WHERE sha256 = $1", "b",
                      (const void *)in->job->scene_sha256, (size_t)32))
        return false;
    if (stored)
        return true;
    if (!pen_compress(store->documents, in->job->scene, in->job->scene_bytes, &document, st))
        return false;
    in->document = (struct pen_object){
        .layer = "", .format = "scene", .data = document.data, .bytes = document.bytes};
    return pen_object_load(store, &in->document, NULL, st);
}

bool pen_store_submit(struct pen_store *store, const struct pen_job_new *job,
                      enum pen_submit_result *result, struct pen_buf *first_answer,
                      struct pen_status *st)
{
    struct submission in = {.job = job,
                            .client = job->client ? job->client : "",
                            .result = result,
                            .first_answer = first_answer,
                            .request = json_loads(job->request, JSON_DECODE_ANY, NULL)};
    bool ok;
    do /* twice, if the scene is removed between the look and the submit */
        ok = prepare(store, &in, st) && pen_db_begin(store->db, PEN_DB_WRITE, st) &&
             pen_db_end(store->db, write_submission(store, &in, st), st);
    while (ok && in.missing);
    json_decref(in.request);
    if (ok && *result == PEN_SUBMIT_CREATED)
        pen_db_wake(store->db);
    return ok;
}
