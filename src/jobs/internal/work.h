/* SPDX-License-Identifier: MIT */
/* How much of a job's expected work is done, for readers. It is known between commits too, and uses
 * the cost map of the job if there is one. Work is a share: the whole job is 1.
 *
 * For a batch of tiles, the trace has the pixel of each render thread. For rounds, the last report
 * counts. What was done since is extrapolated by the pace.
 *
 * Threads: the worker's own, unless the declaration names another. */
#ifndef PEN_JOBS_INTERNAL_WORK_H
#define PEN_JOBS_INTERNAL_WORK_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#include "math/rect.h"
#include "render/cost_map.h"
#include "store/store.h"

struct pen_batch_context;

/* What is known of a claim at some moment. */
struct pen_work {
    double done;  /* certainly done */
    double begun; /* what may be done beyond that before `done` is next known; INFINITY: the work is
                     a time */
    double per_ms; /* done in a ms of the worker's time; 0: not known */
};

/* Returns the work done `ms` later at the same pace. It approaches done + begun and never reaches
 * it. */
double pen_work_after(const struct pen_work *work, double ms);

/* Returns the pace of a worker that has done `work` in `ms`. It expected the whole work to take
 * expected_ms (0: no expectation), which counts like a twentieth of the work.
 * Units: 1/ms. */
double pen_work_pace(double work, double ms, double expected_ms);

/* Returns the worker's time for a whole job by the pace, of which it has spent some. At least 1 ms;
 * 0: not known. */
int64_t pen_work_estimate_ms(double spent_ms, double done, double per_ms);

/* What this worker has rendered of a job. */
struct pen_batch_pace {
    char job_id[PEN_ID_BYTES];
    double ms; /* of rendering only */
    double work;
};

/* The number of jobs that are remembered, since the batches of several jobs may alternate. */
enum { PEN_BATCH_PACES = 16 };

struct pen_batch_work {
    struct pen_cost_map map; /* of the context's job; without cells if it has no map */
    double expected_ms; /* estimated time of this job before its first pixel; 0: not estimated */
    struct pen_batch_pace pace[PEN_BATCH_PACES];
    int pace_next; /* the place that the next new job takes */
    double part;   /* share of the work of a batch that its pixels are, without their layers */
    /* Set before tile_done is set: */
    int tiles;       /* number of the claim's tiles that are being rendered */
    double begun_ms; /* time spent on the claim when its batch began */
    pthread_mutex_t lock;
    struct pen_work known;    /* guarded by lock; per_ms 0: nothing is known of the batch */
    double known_ms;          /* guarded by lock; time spent on the claim at `known` */
    unsigned char *tile_done; /* guarded by lock; by tile; NULL: no tiles are being rendered */
    double last_done;         /* guarded by lock; of tiles, when it last grew */
};

/* Begins a phase of the claim's first tiles: their layers; or their pixels, before or after the
 * layers. */
enum pen_work_phase { PEN_WORK_LAYERS, PEN_WORK_PIXELS_FIRST, PEN_WORK_PIXELS_LAST };
void pen_batch_work_begin(struct pen_batch_context *context, int tiles, enum pen_work_phase phase);

/* Reports what is known of the claim, if it does not follow from tiles. */
void pen_batch_work_tell(struct pen_batch_context *context, const struct pen_work *work);

/* Ends the batch. From now on nothing is known of it. */
void pen_batch_work_end(struct pen_batch_context *context);

/* Notes that a tile is done. It is tile_done of a render task, whose user is the context.
 * Threads: one render thread at a time. */
void pen_batch_tile_done(void *context, struct pen_rect rect);

/* Returns the work that the claim has done after spent_ms, and its pace; *per_ms 0: not known.
 * Threads: the heartbeat's. */
double pen_batch_work_now(void *context, double spent_ms, double *per_ms);

/* Returns the work of the claim's first tiles with their layers. */
double pen_batch_work_of(const struct pen_batch_context *context, int tiles);

/* Notes that a batch of the claim's job is rendered, and how long this worker took. */
void pen_batch_paced(struct pen_batch_context *context, double work, double ms);

/* Returns what is remembered of the claim's job; NULL: nothing. */
const struct pen_batch_pace *pen_batch_pace_of(const struct pen_batch_context *context);

/* Returns the expected time of all workers on the claim's job, once the claim has done `work`; 0:
 * not known. */
int64_t pen_batch_expected_ms(const struct pen_batch_context *context, double work);

#endif
