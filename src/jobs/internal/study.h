/* SPDX-License-Identifier: MIT */
/* The part that all studies of a worker share. They describe the job's scene and find its views
 * themselves, instead of taking a frozen scene from the cache. They store their progress in runs.
 *
 * A study is one batch. Between two runs, never during a run, its progress and its measurements are
 * stored (study/unfinished.h). So a worker that ends loses a run, not the study. When a batch of
 * higher priority waits, a kept study is given back, and continues later. An explanation, which is
 * short, is not kept. Runs may last milliseconds. So a study is kept at most four times a second,
 * and keeping takes at most a twentieth of the time. */
#ifndef PEN_JOBS_INTERNAL_STUDY_H
#define PEN_JOBS_INTERNAL_STUDY_H

#include "jobs/internal/batch.h"
#include "jobs/internal/keep.h"
#include "study/unfinished.h"

struct pen_study {
    struct pen_batch_context *context;
    struct pen_arena *arena; /* of desc */
    struct pen_scene_desc desc;
    int *views; /* views of the job, as indices into desc.views; context->request.view_count of
                 * them */
    double parse_ms;
    int64_t progress_ns; /* when progress was last stored */
    struct pen_keeper keeper;
    struct pen_kept_study kept;                    /* what an earlier worker kept */
    json_t *kept_state;                            /* kept.state */
    uint64_t picture_hash[PEN_STUDY_PICTURES_MAX]; /* hash of each picture that the store has, by
                                                      its index; 0: none */
};

/* Reads the scene and finds the views.
 * Owns: end *study after success and after failure.
 * Fails: as pen_store_scene and pen_scene_load; PEN_NO_MEMORY. */
bool pen_study_begin(struct pen_study *study, struct pen_batch_context *context,
                     struct pen_status *st);
void pen_study_end(struct pen_study *study);

/* Stores the number of finished runs; `user` is the study. A failure is ignored: the next call may
 * succeed, and the heartbeat notices a lost lease. */
void pen_study_progress(void *user, int done, int total);

/* Keeps the study if it is due. It is a pen_between_fn; `user` is the study. A failure is ignored,
 * as in pen_study_progress. */
bool pen_study_keep(void *user, const struct pen_unfinished *unfinished);

/* Returns what an earlier worker kept of the study. If nothing was kept, or it is damaged, its
 * `state` is NULL.
 * Owns: the study. */
const struct pen_kept_study *pen_study_kept(struct pen_study *study);

/* Writes a report with pictures in all formats, because the pictures exist only during the study.
 * JSON goes into the commit, the other formats into the store. A worker that repeats the study
 * after a failed commit replaces them. `write` appends one format.
 * Fails: as `write`, and pen_batch_store. */
typedef bool pen_study_write_fn(const void *user, const char *format, struct pen_buf *out,
                                struct pen_status *st);
bool pen_study_store_report(struct pen_study *study, pen_study_write_fn *write, const void *user,
                            struct pen_batch_output *output, struct pen_status *st);

/* Makes the statistics of a render those of the job.
 * Fails: PEN_NO_MEMORY. */
bool pen_study_write_stats(const struct pen_study *study, const struct pen_render_stats *render,
                           const struct pen_accel_stats *accel, double build_ms,
                           struct pen_batch_output *output, struct pen_status *st);

#endif
