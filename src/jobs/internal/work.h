/* SPDX-License-Identifier: MIT */
/* How much of a job's expected work is done, for readers: between commits too, and by the cost map
 * of the job, if it has one. Work is a share: all of a job is 1.
 *
 * Of a batch of tiles the trace tells how far each render thread is in its tile; of rounds, what
 * they have told last. What is done since follows from the pace.
 *
 * Threads: the worker's own, except where the call says another. */
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
    double done;   /* surely */
    double begun;  /* what may be done beyond that before `done` is known anew; INFINITY: the work
                      is a time */
    double per_ms; /* done in a ms of the worker's time; 0: not known */
};

/* What is done so many ms later, if the pace stays. It comes near done + begun and never there. */
double pen_work_after(const struct pen_work *work, double ms);

/* The pace of a worker that has done some work in some time, and expected all of it to take
 * expected_ms (0: nothing was expected), which counts like a twentieth of the work. Units: 1/ms. */
double pen_work_pace(double work, double ms, double expected_ms);

/* The worker's time for a job of which it has spent some, by the pace. At least 1 ms; 0: not known.
 */
int64_t pen_work_estimate_ms(double spent_ms, double done, double per_ms);

/* What this worker has rendered of a job. */
struct pen_batch_pace {
    char job_id[PEN_ID_BYTES];
    double ms; /* of rendering alone */
    double work;
};

/* Of so many jobs whose batches come in turn. */
enum { PEN_BATCH_PACES = 16 };

struct pen_batch_work {
    struct pen_cost_map map; /* of the context's job; without cells, if it has none */
    double expected_ms;      /* how long that job was expected to take before its pixels told; 0:
                                it was not estimated */
    struct pen_batch_pace pace[PEN_BATCH_PACES];
    int pace_next; /* the one that the next new job takes */
    double part;   /* of the work of a batch, that of its tiles without their layers */
    /* Set before there is a tile_done: */
    int tiles;       /* of the claim, that are being rendered */
    double begun_ms; /* what was spent on the claim when its batch began */
    pthread_mutex_t lock;
    struct pen_work known;    /* guarded by lock; per_ms 0: nothing is known of the batch */
    double known_ms;          /* guarded by lock; what was spent on the claim then */
    unsigned char *tile_done; /* guarded by lock; by tile; NULL: no tiles are being rendered */
    double last_done;         /* guarded by lock; of tiles, when more was found last */
};

/* Tells what is about to be made of the claim's first tiles: their layers; or their pixels, before
 * the layers, or after them. */
enum pen_work_phase { PEN_WORK_LAYERS, PEN_WORK_PIXELS_FIRST, PEN_WORK_PIXELS_LAST };
void pen_batch_work_begin(struct pen_batch_context *context, int tiles, enum pen_work_phase phase);

/* Tells what is known of the claim, which does not follow from tiles. */
void pen_batch_work_tell(struct pen_batch_context *context, const struct pen_work *work);

/* Ends the batch: from now on nothing is known of it. */
void pen_batch_work_end(struct pen_batch_context *context);

/* Notes that a tile is done: tile_done of a render task, whose user is the context. Threads: one
 * render thread at a time. */
void pen_batch_tile_done(void *context, struct pen_rect rect);

/* What is done of the claim's work when so much was spent on it, and the pace; 0: not known.
 * Threads: the heartbeat's. */
double pen_batch_work_now(void *context, double spent_ms, double *per_ms);

/* The work of the claim's first tiles with their layers. */
double pen_batch_work_of(const struct pen_batch_context *context, int tiles);

/* Notes that a batch of the claim's job is rendered, and took this worker so long. */
void pen_batch_paced(struct pen_batch_context *context, double work, double ms);

/* NULL: nothing that is remembered. */
const struct pen_batch_pace *pen_batch_pace_of(const struct pen_batch_context *context);

/* How long workers are expected to work on the claim's job in all, once the claim has done so much;
 * 0: not known. */
int64_t pen_batch_expected_ms(const struct pen_batch_context *context, double work);

#endif
