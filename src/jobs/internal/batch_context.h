/* SPDX-License-Identifier: MIT */
/* The state that a worker keeps from batch to batch, and the functions that all kinds of batches
 * use.
 *
 * Threads: the worker's own thread, except for the pixel hook (any render thread). */
#ifndef PEN_JOBS_INTERNAL_BATCH_CONTEXT_H
#define PEN_JOBS_INTERNAL_BATCH_CONTEXT_H

#include "film/encode.h"
#include "io/stats_json.h"
#include "jobs/internal/heartbeat.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/scene_cache.h"
#include "jobs/internal/stored_request.h"
#include "jobs/internal/work.h"
#include "jobs/worker.h"
#include "render/layers.h"
#include "render/render.h"

struct pen_batch_context {
    const struct pen_worker_options *options;
    struct pen_store *store;
    const struct pen_claim *claim; /* the current claim */
    struct pen_thread_pool *pool;
    struct pen_heartbeat *heart;
    struct pen_scene_cache *scenes;
    bool faulty;               /* the test's fault is to be called before each pixel */
    atomic_bool exhausted;     /* atomic: relaxed; the fault has failed a pixel */
    char job_id[PEN_ID_BYTES]; /* the job of `request`, "" if none */
    struct pen_stored_request request;
    bool fresh; /* when `request` was read, no pixel of the job was done, and its time was not
                   estimated */
    struct pen_batch_work work;
    float *image;                   /* pixels of the view being rendered, by rows */
    size_t image_pixels;            /* capacity of image, in pixels */
    struct pen_png_writer *picture; /* of the view being rendered, from `image`; else NULL */
    int64_t budget_ns;              /* for that view's rounds; 0: none */
    int64_t begun_ns;               /* when this worker began with the claim, by pen_clock_ns */
    struct pen_adaptive *adaptive;  /* of that view, with a target error; else NULL */
    bool rounds_kept;               /* the store has the state after the last round of that view */
    struct pen_film *layer[PEN_LAYER_COUNT]; /* without a target error: the rows of tiles of this
                                                batch; else NULL */
    int64_t split_ns;  /* when its tiles end, by pen_clock_ns; not in rounds */
    double rays_per_s; /* by the last rendered batch; 0: none */
    double store_ms;   /* waiting time for the store, not yet in the job's statistics */
};

/* A finished batch.
 * Owns: release it. */
struct pen_batch_output {
    struct pen_result result;
    float *rgb;              /* owns the pixels of result.rgb */
    struct pen_buf artefact; /* owns the bytes of result.artefact */
    char *stats;             /* owns the text of result.stats */
};
void pen_batch_output_release(struct pen_batch_output *output);

/* Makes output->artefact the artefact of the result, which the commit stores. */
void pen_batch_set_artefact(struct pen_batch_output *output, const char *layer, const char *format);

/* Reads the request of the claim's job into context->request, unless it is already there.
 * (Successive batches are mostly of one job.)
 * Fails: as pen_store_job and pen_stored_request_read. */
bool pen_batch_context_load(struct pen_batch_context *context, struct pen_status *st);

/* Frees what only saves time: the scenes and the image. */
void pen_batch_context_drop_caches(struct pen_batch_context *context);

void pen_batch_context_release(struct pen_batch_context *context);

/* Returns when a forecast that begins now must end, by pen_clock_ns. This is soon, because other
 * batches do not interrupt a forecast, and within the time that the operator allows a job. */
int64_t pen_batch_forecast_end(const struct pen_batch_context *context);

/* Returns the index of a view of the job in its scene.
 * Fails: -1, PEN_INTERNAL. */
int pen_batch_view(const struct pen_batch_context *context, int view, const struct pen_scene *scene,
                   struct pen_status *st);

/* Returns the frozen scene of the claim, and sets *view to the claim's view in it.
 * Owns: the context, until the next call.
 * Fails: as pen_scene_cache_get, and PEN_INTERNAL. */
const struct pen_scene *pen_batch_scene(struct pen_batch_context *context, int *view,
                                        struct pen_scene_times *times, struct pen_status *st);

/* Bounds the tiles of a batch by time: `share` times three seconds from now. After that,
 * pen_batch_is_long returns true, and no more tiles are begun. It is `pause` of a task, whose user
 * is the context. */
void pen_batch_bound(struct pen_batch_context *context, double share);
bool pen_batch_is_long(void *context);

/* Tell whether the claim's job has taken longer than the operator allows, and make the failure for
 * it, PEN_TOO_LARGE. A job with a budget is not checked here. Its submit has already bounded the
 * budget and the work after the rounds. */
bool pen_batch_is_overdue(const struct pen_batch_context *context);
bool pen_batch_fail_overdue(const struct pen_batch_context *context, struct pen_status *st);

/* Stores an artefact of the claim's view. The claim's clock stops meanwhile.
 * Fails: as pen_store_artefact_put. */
bool pen_batch_store(struct pen_batch_context *context, const char *layer, const char *format,
                     const struct pen_buf *data, struct pen_status *st);

/* batch_stats.c: write statistics into the output in their stored form. The first adds
 * store_before_ms (stats.h) to any statistics and takes their reference; NULL stands for a failed
 * allocation. The second makes the statistics of a render, with tile_ms.
 * Fails: PEN_NO_MEMORY. */
bool pen_batch_write_stats(struct pen_batch_context *context, json_t *stats,
                           struct pen_batch_output *output, struct pen_status *st);

bool pen_batch_write_render_stats(struct pen_batch_context *context,
                                  const struct pen_stats_input *in, struct pen_batch_output *output,
                                  struct pen_status *st);

/* Returns the function to call before each pixel: pixel_begins of a render task, whose user is the
 * context. It notes the pixel in the trace, and calls the test's fault. NULL: no function is
 * needed. */
typedef void pen_batch_pixel_fn(void *user, int thread, int x, int y);
pen_batch_pixel_fn *pen_batch_pixel_hook(struct pen_batch_context *context);

/* Call it after rendering, with the result of the render function, which it returns. If the test's
 * fault has stopped the render, *st becomes PEN_NO_MEMORY. */
bool pen_batch_hook_done(struct pen_batch_context *context, bool ok, struct pen_status *st);

#endif
