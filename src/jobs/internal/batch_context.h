/* SPDX-License-Identifier: MIT */
/* What a worker keeps from batch to batch, and the functions that all kinds of batches use.
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
    const struct pen_claim *claim; /* that is worked on */
    struct pen_thread_pool *pool;
    struct pen_heartbeat *heart;
    struct pen_scene_cache *scenes;
    bool faulty;               /* the test's fault is called before each pixel */
    atomic_bool exhausted;     /* atomic: relaxed; the fault has failed a pixel */
    char job_id[PEN_ID_BYTES]; /* the job of `request`, "" if there is none */
    struct pen_stored_request request;
    bool fresh; /* no pixel of the job was done when `request` was read, and its
                   time not estimated */
    struct pen_batch_work work;
    float *image;                   /* pixels of the view being rendered, by rows */
    size_t image_pixels;            /* capacity of image, in pixels */
    struct pen_png_writer *picture; /* of the view being rendered, from `image`; else NULL */
    int64_t budget_ns;              /* for that view's rounds; 0: none */
    int64_t begun_ns;               /* when this worker has begun with it, by pen_clock_ns */
    struct pen_adaptive *adaptive;  /* of that view, with a target error; else NULL */
    bool rounds_kept;               /* the store has what the last of that view's rounds has left */
    struct pen_film *layer[PEN_LAYER_COUNT]; /* without a target error: of the rows of tiles that
                                                the batch is in; else NULL */
    int64_t split_ns;  /* when its tiles end, by pen_clock_ns, if not in rounds */
    double rays_per_s; /* by the last batch that was rendered; 0: there was none */
    double store_ms;   /* time spent waiting for the store; not in the job's statistics yet */
};

/* A finished batch. Owns: release it. */
struct pen_batch_output {
    struct pen_result result;
    float *rgb;              /* owns the pixels of result.rgb */
    struct pen_buf artefact; /* owns the bytes of result.artefact */
    char *stats;             /* owns the text of result.stats */
};
void pen_batch_output_release(struct pen_batch_output *output);

/* Makes output->artefact the result's: it is stored with the commit. */
void pen_batch_set_artefact(struct pen_batch_output *output, const char *layer, const char *format);

/* Reads the request of the claim's job into context->request, unless it is there already: batches
 * of one job mostly follow each other. Fails: as pen_store_job and pen_stored_request_read. */
bool pen_batch_context_load(struct pen_batch_context *context, struct pen_status *st);

/* Frees what is kept only to save time: the scenes and the image. */
void pen_batch_context_drop_caches(struct pen_batch_context *context);

void pen_batch_context_release(struct pen_batch_context *context);

/* By when a forecast that begins now is to end, by pen_clock_ns: soon, since it is not interrupted
 * for others, and within what the operator allows a job to take. */
int64_t pen_batch_forecast_end(const struct pen_batch_context *context);

/* The index of a view of the job in its scene. Fails: PEN_INTERNAL, with -1. */
int pen_batch_view(const struct pen_batch_context *context, int view, const struct pen_scene *scene,
                   struct pen_status *st);

/* The frozen scene of the claim, and the claim's view in it. Owns: the context, until the next
 * call. Fails: as pen_scene_cache_get, and PEN_INTERNAL. */
const struct pen_scene *pen_batch_scene(struct pen_batch_context *context, int *view,
                                        struct pen_scene_times *times, struct pen_status *st);

/* Bounds the tiles of a batch by time: so long after the call, or after this share of that,
 * pen_batch_is_long tells that those which are not begun are left. The latter is `pause` of a task,
 * whose user is the context. */
void pen_batch_bound(struct pen_batch_context *context, double share);
bool pen_batch_is_long(void *context);

/* Whether the claim's job has taken longer than the operator allows, and the failure that says so,
 * PEN_TOO_LARGE. A job with a budget is bounded already, also what follows its rounds, when it is
 * submitted. */
bool pen_batch_is_overdue(const struct pen_batch_context *context);
bool pen_batch_fail_overdue(const struct pen_batch_context *context, struct pen_status *st);

/* Stores an artefact of the claim's view, and waits for the store meanwhile. Fails: as
 * pen_store_artefact_put. */
bool pen_batch_store(struct pen_batch_context *context, const char *layer, const char *format,
                     const struct pen_buf *data, struct pen_status *st);

/* batch_stats.c: puts statistics into the output as they are stored, with store_before_ms
 * (stats.h); and those of a render, with tile_ms. The former takes the reference; NULL is an
 * allocation that failed. Fail: PEN_NO_MEMORY. */
bool pen_batch_write_stats(struct pen_batch_context *context, json_t *stats,
                           struct pen_batch_output *output, struct pen_status *st);

bool pen_batch_write_render_stats(struct pen_batch_context *context,
                                  const struct pen_stats_input *in, struct pen_batch_output *output,
                                  struct pen_status *st);

/* The function to call before each pixel (pixel_begins of a render task, with the context as its
 * user): it notes the pixel in the trace, and calls the test's fault. NULL: none is needed. */
typedef void pen_batch_pixel_fn(void *user, int thread, int x, int y);
pen_batch_pixel_fn *pen_batch_pixel_hook(struct pen_batch_context *context);

/* Call it after rendering, with what the render function returned; returns the same. If the test's
 * fault has stopped the render, *st becomes PEN_NO_MEMORY. */
bool pen_batch_hook_done(struct pen_batch_context *context, bool ok, struct pen_status *st);

#endif
