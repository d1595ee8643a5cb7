/* SPDX-License-Identifier: MIT */
/* A table with one slot for each hash value. A collision costs a read of the store and nothing
 * else. */
#include "http/internal/snapshot_cache.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "http/internal/queue.h"

enum { SLOTS = 1024 };
static const int64_t max_age_ns = INT64_C(1000000000);

struct slot {
    struct snapshot snapshot; /* json is NULL while the slot is empty */
    uint32_t changes;
    int64_t read_ns;
};

struct snapshot_cache {
    struct queue *queue;
    pthread_mutex_t lock;
    struct slot slot[SLOTS]; /* guarded by lock */
};

struct snapshot_cache *pen_http_snapshot_cache_new(void)
{
    struct snapshot_cache *cache = calloc(1, sizeof *cache);
    if (cache && !(cache->queue = pen_http_queue_new())) {
        free(cache);
        return NULL;
    }
    if (cache)
        pthread_mutex_init(&cache->lock, NULL);
    return cache;
}

void pen_http_snapshot_cache_free(struct snapshot_cache *cache)
{
    for (int i = 0; cache && i < SLOTS; i++)
        pen_http_snapshot_release(&cache->slot[i].snapshot);
    if (cache) {
        pthread_mutex_destroy(&cache->lock);
        pen_http_queue_free(cache->queue);
    }
    free(cache);
}

void pen_http_snapshot_release(struct snapshot *snapshot)
{
    pen_http_blob_unref(snapshot->json);
    snapshot->json = NULL;
}

/* FNV-1a over the whole id, because ids of jobs that were submitted together begin alike. */
static struct slot *slot_of(struct snapshot_cache *cache, const char *id)
{
    uint32_t hash = 2166136261u;
    for (const char *c = id; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 16777619u;
    return &cache->slot[hash % SLOTS];
}

bool pen_http_snapshot_cache_peek(struct snapshot_cache *cache, uint32_t changes, const char *id,
                                  struct snapshot *out)
{
    struct slot *slot = slot_of(cache, id);
    int64_t now = pen_clock_ns();
    pthread_mutex_lock(&cache->lock);
    bool good = slot->snapshot.json && slot->changes == changes &&
                now - slot->read_ns < max_age_ns && strcmp(slot->snapshot.id, id) == 0;
    if (good) {
        *out = slot->snapshot;
        pen_http_blob_ref(out->json);
    }
    pthread_mutex_unlock(&cache->lock);
    return good;
}

static void remember(struct snapshot_cache *cache, uint32_t changes, int64_t read_ns,
                     const struct snapshot *snapshot)
{
    struct slot *slot = slot_of(cache, snapshot->id);
    pen_http_blob_ref(snapshot->json);
    pthread_mutex_lock(&cache->lock);
    struct blob *old = slot->snapshot.json;
    *slot = (struct slot){.snapshot = *snapshot, .changes = changes, .read_ns = read_ns};
    pthread_mutex_unlock(&cache->lock);
    pen_http_blob_unref(old);
}

/* Adds the place in the queue and the expected time; null where they are unknown. */
static bool add_place(struct snapshot_cache *cache, struct pen_jobs *jobs, const char *id,
                      json_t *job)
{
    const struct queue_place place = pen_http_queue_place(cache->queue, jobs, id);
    json_t *number = place.number > 0 ? json_integer(place.number) : json_null();
    json_t *eta = place.eta_seconds > 0 ? json_real(place.eta_seconds) : json_null();
    return json_object_set_new(job, "queue_position", number) == 0 &&
           json_object_set_new(json_object_get(job, "progress"), "eta_seconds", eta) == 0;
}

bool pen_http_snapshot_cache_read(struct snapshot_cache *cache, uint32_t changes,
                                  struct pen_jobs *jobs, const char *id, struct snapshot *out,
                                  struct pen_status *st)
{
    if (pen_http_snapshot_cache_peek(cache, changes, id, out))
        return true;
    int64_t now = pen_clock_ns();
    struct pen_job_snapshot job;
    if (!pen_jobs_get(jobs, id, &job, st))
        return false;
    *out = (struct snapshot){.state = job.state, .revision = job.revision};
    snprintf(out->id, sizeof out->id, "%s", id);
    if (job.state != PEN_JOB_QUEUED || add_place(cache, jobs, id, job.json))
        out->json = pen_http_blob_json(job.json);
    json_decref(job.json);
    if (!out->json)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the job");
    remember(cache, changes, now, out);
    return true;
}

/* Writes the entity tag. A queued job's tag is weak, since its place in the queue changes without a
 * new revision. */
static void tag_of(const struct snapshot *snapshot, char etag[ETAG_BYTES])
{
    const char *weak = snapshot->state == PEN_JOB_QUEUED ? "W/" : "";
    snprintf(etag, ETAG_BYTES, "%s\"%" PRId64 "\"", weak, snapshot->revision);
}

bool pen_http_snapshot_is_due(const struct snapshot *snapshot, const struct request *request)
{
    const char *known = request->fields.if_none_match;
    char etag[ETAG_BYTES];
    tag_of(snapshot, etag);
    return pen_job_state_ended(snapshot->state) || (known && !pen_etag_known(known, etag));
}

bool pen_http_snapshot_cache_check(struct snapshot_cache *cache, uint32_t changes,
                                   struct pen_jobs *jobs, const struct request *request, bool *due,
                                   struct pen_status *st)
{
    struct snapshot snapshot = {0};
    if (!pen_http_snapshot_cache_peek(cache, changes, request->job_id, &snapshot) &&
        !pen_jobs_state(jobs, request->job_id, &snapshot.state, &snapshot.revision, st))
        return false;
    *due = pen_http_snapshot_is_due(&snapshot, request);
    pen_http_snapshot_release(&snapshot);
    return true;
}

void pen_http_snapshot_reply(const struct snapshot *snapshot, struct request *request)
{
    char etag[ETAG_BYTES];
    tag_of(snapshot, etag);
    bool ended = pen_job_state_ended(snapshot->state);
    const struct content content = {.blob = pen_http_blob_ref(snapshot->json),
                                    .type = "application/json",
                                    .etag = etag,
                                    .cache_control = ended ? "private, max-age=5" : "no-cache"};
    pen_http_request_content(request, &content);
    if (!ended)
        pen_http_reply_field(&request->reply, "Retry-After", "1");
}
