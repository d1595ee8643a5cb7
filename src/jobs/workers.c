/* SPDX-License-Identifier: MIT */
/* The render workers, as the API lists them. A worker that was not seen for a minute is left out:
 * it has died unnoticed, or its host is gone. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "jobs/internal/job_json.h"
#include "jobs/internal/jobs.h"

enum { SHOWN_MS = 60000 };

struct listing {
    json_t *list;
    int64_t now_ms;
    char last[256]; /* id of the last worker in the list */
    bool ok;
};

static json_t *worker_json(const struct pen_worker_record *worker)
{
    return json_pack("{s:s, s:s, s:I, s:i, s:o, s:o, s:[]}", "name", worker->id, "host",
                     worker->host, "pid", (json_int_t)worker->pid, "threads", worker->threads,
                     "started_at", pen_time_json(worker->started_ms), "last_seen_at",
                     pen_time_json(worker->seen_ms), "batches");
}

/* Returns what a worker does with a batch; for a study, the kind of its job. */
static const char *kind_name(const struct pen_worker_record *worker)
{
    switch (worker->kind) {
    case PEN_BATCH_RENDER:
        return "render";
    case PEN_BATCH_ASSEMBLE:
        return "assemble";
    case PEN_BATCH_STUDY:
        return worker->job_kind;
    }
    return "render"; /* only a damaged store has such a value */
}

static json_t *batch_json(const struct pen_worker_record *worker)
{
    return json_pack("{s:s, s:s, s:I, s:I, s:s, s:I}", "job", worker->job_id, "view", worker->view,
                     "batch", (json_int_t)worker->batch, "attempt", (json_int_t)worker->attempt,
                     "kind", kind_name(worker), "pixels", (json_int_t)worker->pixels);
}

/* Called by the store for each batch that a worker holds. The rows of one worker follow each
 * other. */
static bool add_row(void *user, const struct pen_worker_record *worker)
{
    struct listing *listing = user;
    if (listing->now_ms - worker->seen_ms > SHOWN_MS)
        return true;
    if (strcmp(listing->last, worker->id) != 0) {
        snprintf(listing->last, sizeof listing->last, "%s", worker->id);
        listing->ok = json_array_append_new(listing->list, worker_json(worker)) == 0;
    }
    json_t *last = json_array_get(listing->list, json_array_size(listing->list) - 1);
    if (listing->ok && worker->job_id)
        listing->ok =
            json_array_append_new(json_object_get(last, "batches"), batch_json(worker)) == 0;
    return listing->ok;
}

json_t *pen_jobs_workers(struct pen_jobs *jobs, struct pen_status *st)
{
    struct listing listing = {.list = json_array(), .ok = true};
    bool read = pen_store_now(jobs->store, &listing.now_ms, st) &&
                pen_store_workers(jobs->store, add_row, &listing, st);
    json_t *answer = read && listing.ok ? json_pack("{s:O}", "workers", listing.list) : NULL;
    json_decref(listing.list);
    if (read && !answer)
        pen_fail(st, PEN_NO_MEMORY, "no memory for the workers");
    return answer;
}
