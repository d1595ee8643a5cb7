/* SPDX-License-Identifier: MIT */
/* The part that all studies of a worker share. They describe the job's scene and find its views
 * themselves, instead of taking a frozen scene from the cache. They store their progress in runs.
 *
 * A study is one batch. Between two runs, never during a run, its progress and its measurements are
 * stored (study/study.h). So a worker that ends loses a run, not the study. When a batch of
 * higher priority waits, a kept study is given back, and continues later. An explanation, which is
 * short, is not kept. Runs may last milliseconds. So a study is kept at most four times a second,
 * and keeping takes at most a twentieth of the time. */
#ifndef PEN_JOBS_INTERNAL_STUDY_H
#define PEN_JOBS_INTERNAL_STUDY_H

#include "jobs/internal/batch.h"
#include "jobs/internal/keep.h"
#include "study/study.h"

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

/* Returns the frame of the study: its scene and context, how its state is kept, and what an earlier
 * worker kept. Damaged state counts as none. `user` is the struct whose first member is the study.
 * Owns: the study. */
struct pen_study_frame pen_study_frame_of(struct pen_study *study, void *user);

/* Writes a report as JSON for the commit. A report with figures (report/report.h) is also stored as
 * a page, because the figures exist only during the study. A worker that repeats the study after a
 * failed commit replaces the page.
 * Fails: as pen_report_write, and pen_batch_store. */
bool pen_study_store_report(struct pen_study *study, const json_t *report,
                            const struct pen_buf *figures, struct pen_batch_output *output,
                            struct pen_status *st);

/* Makes the statistics of a render those of the job.
 * Fails: PEN_NO_MEMORY. */
bool pen_study_write_stats(const struct pen_study *study, const struct pen_render_stats *render,
                           const struct pen_accel_stats *accel, double build_ms,
                           struct pen_batch_output *output, struct pen_status *st);

#endif
