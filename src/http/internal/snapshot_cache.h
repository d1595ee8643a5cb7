/* SPDX-License-Identifier: MIT */
/* A cache of jobs. A snapshot of a job is valid for one value of the store's change counter. While
 * the counter stays the same, no job has changed. So a poll is answered from the cache, without a
 * store thread. A change notification may get lost, so a snapshot is used for at most a second.
 *
 * Threads: any. */
#ifndef PEN_HTTP_INTERNAL_SNAPSHOT_CACHE_H
#define PEN_HTTP_INTERNAL_SNAPSHOT_CACHE_H

#include <stdbool.h>
#include <stdint.h>

#include "http/internal/reply.h"
#include "http/internal/request.h"
#include "jobs/jobs.h"

struct snapshot_cache;

/* A job at the time when it was read. */
struct snapshot {
    char id[PEN_ID_BYTES];
    enum pen_job_state state;
    int64_t revision;
    struct blob *json;
};

void pen_http_snapshot_release(struct snapshot *snapshot);

/* Fails: NULL when out of memory. */
struct snapshot_cache *pen_http_snapshot_cache_new(void);
void pen_http_snapshot_cache_free(struct snapshot_cache *cache); /* NULL is allowed */

/* Gets a job from the cache. Returns false if there is no valid snapshot.
 * Owns: the caller releases *out. */
bool pen_http_snapshot_cache_peek(struct snapshot_cache *cache, uint32_t changes, const char *id,
                                  struct snapshot *out);

/* Gets a job from the cache. If it is not there, reads it from the store and adds it to the cache.
 * `changes` is the change counter from before the call.
 * Owns: the caller releases *out.
 * Fails: as pen_jobs_get; PEN_NO_MEMORY. */
bool pen_http_snapshot_cache_read(struct snapshot_cache *cache, uint32_t changes,
                                  struct pen_jobs *jobs, const char *id, struct snapshot *out,
                                  struct pen_status *st);

/* As pen_http_snapshot_is_due. A job that is not in the cache is read from the store, without its
 * text.
 * Fails: as pen_jobs_state. */
bool pen_http_snapshot_cache_check(struct snapshot_cache *cache, uint32_t changes,
                                   struct pen_jobs *jobs, const struct request *request, bool *due,
                                   struct pen_status *st);

/* Whether a GET that waits for this job can be answered. It can if the job has ended or the client
 * has another revision. */
bool pen_http_snapshot_is_due(const struct snapshot *snapshot, const struct request *request);

/* Answers a GET of the job with the snapshot. */
void pen_http_snapshot_reply(const struct snapshot *snapshot, struct request *request);

#endif
