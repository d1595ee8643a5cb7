/* SPDX-License-Identifier: MIT */
/* Jobs as they were when the store's NEWS counter had a certain value. As long as it has that
 * value the job is the same, and a poll is answered from here without a store thread.
 *
 * A hint may get lost, so an entry is not used for longer than a second. */
#ifndef PEN_HTTP_INTERNAL_SNAPSHOTS_H
#define PEN_HTTP_INTERNAL_SNAPSHOTS_H

#include <stdbool.h>
#include <stdint.h>

#include "http/internal/reply.h"
#include "http/internal/request.h"
#include "jobs/jobs.h"

struct snapshots;

struct snapshot {
    char id[PEN_ID_BYTES];
    enum pen_job_state state;
    int64_t revision;
    struct blob *json;
};

void pen_http_snapshot_release(struct snapshot *snapshot);

struct snapshots *pen_http_snapshots_new(void);
void pen_http_snapshots_free(struct snapshots *cache); /* NULL is allowed */

/* The job from memory, if that is still good. Owns: the caller releases *out. */
bool pen_http_snapshots_peek(struct snapshots *cache, uint32_t news, const char *id,
                             struct snapshot *out);

/* The job from memory or else from the store, remembered for others. `news` is the counter from
 * before the call. Owns: the caller releases *out. Fails: as pen_jobs_get; PEN_NO_MEMORY. */
bool pen_http_snapshots_read(struct snapshots *cache, uint32_t news, struct pen_jobs *jobs,
                             const char *id, struct snapshot *out, struct pen_status *st);

/* Whether a GET of this job has to wait no longer: it has ended, or the client knows another
 * revision. */
bool pen_http_snapshot_is_due(const struct snapshot *snapshot, const struct request *request);

/* Answers a GET of the job. */
void pen_http_snapshot_reply(const struct snapshot *snapshot, struct request *request);

#endif
