/* SPDX-License-Identifier: MIT */
/* Accepts and checks submissions. A repeated submit with the same Idempotency-Key gets the first
 * answer again, with the same bytes. The answer is the job in its first revision, which is made
 * from the stored job. So only the job's id is stored with the key, and may outlive the job.
 *
 * A submission is parsed once. The scene is stored as the text that was sent. The first answer is
 * made from the JSON of the request, not from its stored text. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/utf8.h"
#include "io/figures.h"
#include "io/json_build.h"
#include "io/settings_json.h"
#include "jobs/internal/batch_layout.h"
#include "jobs/internal/ids.h"
#include "jobs/internal/job_json.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/members.h"
#include "jobs/internal/request.h"
#include "jobs/internal/stored_request.h"
#include "render/layers.h"
#include "scene/scene.h"

enum { KEY_CHARACTERS_MAX = 255 };

static json_t *views_json(const struct pen_request *request)
{
    json_t *list = json_array();
    for (int i = 0; i < request->view_count; i++)
        json_array_append_new(list, json_string(request->desc.views[request->views[i]].name));
    return pen_json_all(list, (size_t)request->view_count);
}

/* Adds the members that only some jobs have; takes the reference. */
static json_t *with_more(const struct pen_request *request, json_t *json)
{
    const int tile = pen_batch_tile(request);
    if (request->cost_layer)
        json = pen_json_with(json, "cost", json_string(pen_cost_names[request->cost]));
    if (request->audit_pixels > 0)
        json = pen_json_with(json, "audit",
                             json_pack("{s:i, s:f}", "pixels", request->audit_pixels, "threshold",
                                       request->audit_threshold));
    if (request->budget_seconds > 0)
        json = pen_json_with(json, "budget_seconds", json_real(request->budget_seconds));
    if (tile > 0)
        json = pen_json_with(json, "tile_edge", json_integer(tile));
    if (request->kind == PEN_KIND_EFFECTS)
        json = pen_json_with(json, "repeats", json_integer(request->repeats));
    if (request->kind == PEN_KIND_EXPLAIN)
        json = pen_json_with(json, "analyze", json_boolean(request->analyze));
    if (request->kind == PEN_KIND_ACCURACY)
        json = pen_accuracy_spec_members(&request->accuracy, json);
    if (request->kind == PEN_KIND_BENCHMARK)
        json = pen_bench_spec_members(
            &request->spec, pen_json_with(json, "matrix", json_incref(request->spec.matrix)));
    return json;
}

/* Makes the job as accepted: the client's keys with all defaults filled in, without the scene. */
static json_t *request_json(const struct pen_request *request)
{
    json_t *labels =
        request->labels ? json_incref((json_t *)(uintptr_t)request->labels) : json_object();
    json_t *layers = request->layers ? json_incref((json_t *)(uintptr_t)request->layers)
                                     : json_pack("[s]", pen_layer_name(PEN_LAYER_BEAUTY));
    json_t *json =
        json_pack("{s:s, s:O?, s:o, s:i, s:i, s:f, s:o, s:o, s:o, s:f, s:o}", "kind",
                  pen_job_kinds[request->kind], "name", request->name, "labels", labels, "priority",
                  request->priority, "max_attempts", request->max_attempts, "timeout_seconds",
                  (double)request->timeout_ms / 1000, "views", views_json(request), "layers",
                  layers, "render", pen_settings_json(&request->settings), "bound_rays",
                  pen_batch_bound_rays(request), "effects",
                  pen_figure_effects(pen_desc_effects(&request->desc, &request->settings)));
    return with_more(request, json);
}

/* A job ready to be stored, and the memory behind its pointers. */
struct prepared {
    struct pen_job_new new;
    char id[PEN_ID_BYTES];
    char *request, *answer, *scene;
    unsigned char scene_sha256[32], body_sha256[32];
    struct pen_view_new *views;
    struct pen_batch_new *batches;
};

static void prepared_release(struct prepared *job)
{
    free(job->request);
    free(job->answer);
    free(job->scene);
    free(job->views);
    free(job->batches);
}

/* The scene is stored as it was sent, in JSON or XML. If its text was not found in the body, it is
 * written again from its JSON. */
static bool prepare_scene(struct prepared *job, const struct pen_request *request)
{
    if (!request->scene_text && !(job->scene = json_dumps(request->scene, PEN_JSON_STORED)))
        return false;
    job->new.scene = job->scene ? job->scene : request->scene_text;
    job->new.scene_bytes = job->scene ? strlen(job->scene) : request->scene_bytes;
    return true;
}

/* Makes the answer to the client: the job object in its first revision. */
static char *make_answer(const char *id, const char *kind, int64_t created_ms, int64_t pixels,
                         json_t *request, struct pen_status *st)
{
    struct pen_job_record first = {.state = PEN_JOB_QUEUED,
                                   .revision = 1,
                                   .kind = (char *)(uintptr_t)kind,
                                   .created_ms = created_ms,
                                   .total_pixels = pixels};
    memcpy(first.id, id, sizeof first.id);
    json_t *json = pen_job_json_with(&first, request, st);
    char *text = json ? json_dumps(json, PEN_JSON_STORED) : NULL;
    if (json && !text)
        pen_fail(st, PEN_NO_MEMORY, "no memory for an answer");
    json_decref(json);
    return text;
}

/* Adds a worker's rate, once for a worker that holds several batches. */
struct rates {
    char last[PEN_WORKER_ID_BYTES];
    int workers, told;
    double sum;
};

static bool add_rate(void *user, const struct pen_worker_record *worker)
{
    struct rates *rates = user;
    if (strcmp(rates->last, worker->id) == 0)
        return true;
    snprintf(rates->last, sizeof rates->last, "%s", worker->id);
    rates->workers++;
    rates->told += worker->rays_per_s > 0;
    rates->sum += (double)worker->rays_per_s;
    return true;
}

static bool read_workers(struct pen_jobs *jobs, const struct pen_request *request,
                         struct pen_batch_workers *workers, struct pen_status *st)
{
    struct rates rates = {.workers = 0};
    if (pen_batch_needs_rate(request) && !pen_store_workers(jobs->store, add_rate, &rates, st))
        return false;
    *workers = (struct pen_batch_workers){rates.workers, rates.told ? rates.sum / rates.told : 0};
    return true;
}

static bool prepare_views(struct pen_jobs *jobs, struct prepared *job,
                          const struct pen_request *request, struct pen_status *st)
{
    struct pen_batch_workers workers;
    job->views = calloc((size_t)request->view_count, sizeof *job->views);
    if (!job->views)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %d views", request->view_count);
    for (int i = 0; i < request->view_count; i++)
        job->views[i] = (struct pen_view_new){.name = request->desc.views[request->views[i]].name,
                                              .width = request->settings.width,
                                              .height = request->settings.height};
    job->new.views = job->views;
    job->new.view_count = pen_job_kind_has_report(request->kind) ? 1 : request->view_count;
    if (!read_workers(jobs, request, &workers, st) ||
        !pen_batch_layout(request, &workers, &job->batches, &job->new.batch_count, st))
        return false;
    job->new.batches = job->batches;
    return true;
}

/* Computes the hashes of body and scene. If the scene is the whole body, it is hashed only once. */
static void hash(struct prepared *job, const struct pen_submission *in)
{
    pen_sha256(in->body, in->bytes, job->body_sha256);
    if (job->new.scene == in->body && job->new.scene_bytes == in->bytes)
        memcpy(job->scene_sha256, job->body_sha256, sizeof job->scene_sha256);
    else
        pen_sha256(job->new.scene, job->new.scene_bytes, job->scene_sha256);
    job->new.body_sha256 = job->body_sha256;
    job->new.scene_sha256 = job->scene_sha256;
}

/* By default, one client cannot fill the queue. */
static int64_t client_queue_max(const struct pen_limits *limits, const struct pen_submission *in)
{
    if (limits->address_queue > 0 || in->client_is_shared)
        return limits->address_queue;
    return (limits->queue + 1) / 2;
}

static bool prepare(struct pen_jobs *jobs, struct prepared *job, const struct pen_submission *in,
                    const struct pen_request *request, struct pen_status *st)
{
    int64_t now_ms;
    if (!pen_store_now(jobs->store, &now_ms, st))
        return false;
    json_t *json = request_json(request);
    if (json && in->traceparent)
        json_object_set_new(json, "traceparent", json_string(in->traceparent));
    job->request = json ? json_dumps(json, PEN_JSON_STORED) : NULL;
    job->new = (struct pen_job_new){.id = job->id,
                                    .created_ms = now_ms,
                                    .created = pen_clock_moment(),
                                    .kind = pen_job_kinds[request->kind],
                                    .request = job->request,
                                    .priority = request->priority,
                                    .max_attempts = request->max_attempts,
                                    .timeout_ms = request->timeout_ms,
                                    .client = in->client,
                                    .queue_max = jobs->limits.queue,
                                    .client_queue_max = client_queue_max(&jobs->limits, in),
                                    .idempotency_key = in->idempotency_key};
    pen_id_make(job->new.created_ms, job->id);
    bool ok = (job->request && prepare_scene(job, request)) ||
              pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
    ok = ok && prepare_views(jobs, job, request, st);
    int64_t pixels = 0;
    for (int i = 0; ok && i < job->new.batch_count; i++)
        pixels += job->batches[i].pixels;
    job->answer = ok ? make_answer(job->id, job->new.kind, now_ms, pixels, json, st) : NULL;
    json_decref(json);
    if (!job->answer)
        return false;
    hash(job, in);
    job->new.answer = job->id; /* is stored with the key */
    return true;
}

/* A submit with an unknown outcome is repeated once: the store recognises the job by its id. */
static bool try_submit(struct pen_store *store, const struct pen_job_new *job,
                       enum pen_submit_result *result, struct pen_buf *first_answer,
                       struct pen_status *st)
{
    return pen_store_submit(store, job, result, first_answer, st) ||
           (pen_store_failure(store, st) == PEN_FAILURE_UNKNOWN &&
            pen_store_submit(store, job, result, first_answer, st));
}

/* Makes the first answer again. */
static bool make_again(const struct pen_job_record *job, struct pen_submitted *out,
                       struct pen_status *st)
{
    json_t *request = pen_stored_json(job->request, st);
    char *text =
        request ? make_answer(job->id, job->kind, job->created_ms, job->total_pixels, request, st)
                : NULL;
    json_decref(request);
    out->answer.bytes = 0;
    const bool ok = text && (pen_buf_puts(&out->answer, text) ||
                             pen_fail(st, PEN_NO_MEMORY, "no memory for an answer"));
    free(text);
    return ok;
}

/* The answer to an earlier submit is valid as long as its job exists. */
static bool repeat_answer(struct pen_jobs *jobs, struct pen_submitted *out, struct pen_status *st)
{
    struct pen_job_record job;
    if (out->answer.bytes != sizeof out->id - 1)
        return pen_fail(st, PEN_STORAGE, "what is stored with the key is damaged");
    memcpy(out->id, out->answer.data, sizeof out->id);
    if (pen_store_job(jobs->store, out->id, &job, st)) {
        const bool ok = make_again(&job, out, st);
        pen_job_record_release(&job);
        return ok;
    }
    if (st->code != PEN_GONE && st->code != PEN_NOT_FOUND)
        return false;
    return pen_fail(st, PEN_GONE,
                    "job %s, which this Idempotency-Key made, was removed; take a new key for a "
                    "new job",
                    out->id);
}

static bool store_job(struct pen_jobs *jobs, const struct prepared *job, struct pen_submitted *out,
                      struct pen_status *st)
{
    enum pen_submit_result result;
    if (!try_submit(jobs->store, &job->new, &result, &out->answer, st))
        return false;
    if (result == PEN_SUBMIT_REUSED)
        return pen_fail(st, PEN_INVALID,
                        "this Idempotency-Key was used with another body; take a new key");
    out->repeated = result == PEN_SUBMIT_REPEATED;
    if (out->repeated)
        return repeat_answer(jobs, out, st);
    memcpy(out->id, job->id, sizeof out->id);
    return pen_buf_puts(&out->answer, job->answer) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for an answer");
}

static bool check_key(const char *key, struct pen_errors *errors)
{
    if (!key || (key[0] && pen_utf8_count(key) <= KEY_CHARACTERS_MAX))
        return true;
    pen_request_fail(errors, PEN_USAGE, "", NULL, "Idempotency-Key must have 1 to %d characters",
                     (int)KEY_CHARACTERS_MAX);
    return false;
}

bool pen_jobs_submit(struct pen_jobs *jobs, const struct pen_submission *in,
                     struct pen_submitted *out, struct pen_errors *errors)
{
    struct pen_request request;
    struct prepared job = {0};
    struct pen_status st;
    *out = (struct pen_submitted){0};
    if (!check_key(in->idempotency_key, errors))
        return false;
    bool ok = pen_request_read(in, &jobs->limits, &request, errors);
    if (ok) {
        ok = prepare(jobs, &job, in, &request, &st) && store_job(jobs, &job, out, &st);
        if (!ok)
            pen_errors_add(errors, &st);
    }
    if (!ok)
        pen_buf_release(&out->answer);
    prepared_release(&job);
    pen_request_release(&request);
    return ok;
}

static json_t *warnings_json(const struct pen_errors *warnings)
{
    json_t *list = json_array();
    for (size_t i = 0; i < warnings->count; i++)
        json_array_append_new(list, pen_problem_place(&warnings->item[i]));
    return pen_json_all(list, warnings->count);
}

bool pen_jobs_validate(struct pen_jobs *jobs, const struct pen_submission *in, json_t **answer,
                       struct pen_errors *errors)
{
    struct pen_limits limits = jobs ? jobs->limits : pen_limits_default();
    struct pen_request request;
    struct pen_errors warnings = {0};
    limits.models = in->models;
    bool ok = pen_request_read(in, &limits, &request, errors);
    *answer = NULL;
    if (ok) {
        pen_scene_warnings(request.scene, request.scene_at, &request.desc, &warnings);
        for (size_t i = 0; i < warnings.count; i++)
            pen_document_locate(request.has, &warnings.item[i]);
        const struct pen_mesh_totals of = pen_desc_meshes(&request.desc);
        *answer = json_pack("{s:b, s:o}", "valid", 1, "warnings", warnings_json(&warnings));
        if (of.meshes > 0)
            *answer = pen_json_with(*answer, "meshes",
                                    json_pack("{s:I, s:I}", "count", (json_int_t)of.meshes,
                                              "triangles", (json_int_t)of.triangles));
        ok = *answer != NULL;
        if (!ok)
            pen_request_fail(errors, PEN_NO_MEMORY, "", NULL, "no memory for an answer");
    }
    pen_request_release(&request);
    return ok;
}
