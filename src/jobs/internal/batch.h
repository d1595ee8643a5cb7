/* SPDX-License-Identifier: MIT */
/* One batch, from claim to result, in memory: no commits here. */
#ifndef PEN_JOBS_INTERNAL_BATCH_H
#define PEN_JOBS_INTERNAL_BATCH_H

#include "jobs/internal/heartbeat.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/packing.h"
#include "jobs/internal/scene_cache.h"
#include "jobs/worker.h"
#include "render/render.h"

/* What a worker keeps from batch to batch. */
struct pen_batch_room {
    struct pen_store *store;
    struct pen_thread_pool *pool;
    struct pen_heartbeat *heart;
    struct pen_scene_cache *scenes;
    struct pen_packing *packing;
    struct pen_trace *trace;              /* may be NULL */
    const struct pen_worker_fault *fault; /* NULL: none */
    atomic_bool exhausted;                /* atomic: relaxed; the fault ran out of memory */
    char plan_id[PEN_ID_BYTES];           /* the job that plan is of, "" if there is none */
    struct pen_job_plan plan;
    float *image;
    size_t image_pixels; /* what it has room for */
    double store_ms;     /* what the store took of the plan's job since its last statistics */
};

/* A finished batch; the pixels stay in the room. Owns: release it. */
struct pen_batch_work {
    struct pen_result result;
    struct pen_buf artefact; /* what result.artefact points into */
    char *stats;
};
void pen_batch_work_release(struct pen_batch_work *work);

/* Renders or assembles. Fails: PEN_CANCELLED when the heartbeat said stop; PEN_NOT_FOUND (the job
 * is gone), PEN_STORAGE …: the store; any other code is an error of the job. */
bool pen_batch_do(struct pen_batch_room *room, const struct pen_claim *claim,
                  struct pen_batch_work *work, struct pen_status *st);

/* study_batch.c: the whole of a benchmark; its artefact is the report as JSON. */
bool pen_batch_study(struct pen_batch_room *room, const struct pen_claim *claim,
                     struct pen_batch_work *work, struct pen_status *st);

/* Writes statistics as they are stored: with the wall clock at which the batch goes to the store,
 * and what the store has taken before. Takes the reference; NULL is an allocation that failed. */
bool pen_batch_write_stats(struct pen_batch_room *room, json_t *stats, struct pen_batch_work *work,
                           struct pen_status *st);

/* What looks on when the claim's job is rendered: for pixel_begins, with the room as user; it notes
 * the pixel in the room's trace. May be NULL. pen_batch_looked comes after the render, passes its
 * outcome on, and knows a fault that was to be tested. */
typedef void pen_batch_pixel_fn(void *user, int thread, int x, int y);
pen_batch_pixel_fn *pen_batch_look_on(struct pen_batch_room *room);
bool pen_batch_looked(struct pen_batch_room *room, bool ok, struct pen_status *st);

/* Lets go of the memory that is kept for later: scenes and pixels. */
void pen_batch_room_empty(struct pen_batch_room *room);

void pen_batch_room_release(struct pen_batch_room *room);

#endif
