/* SPDX-License-Identifier: MIT */
/* What the studies of a worker have in common: they describe the job's scene and find its views
 * themselves, instead of taking a frozen scene from the cache, and store their progress in runs.
 *
 * A study is one batch. Between two runs, never during one, its progress is stored, and what it has
 * measured is kept (study/study.h), so that a worker that ends loses a run and not the study.
 * When a batch of higher priority waits, a study that is kept is given back, to go on later. An
 * explanation, which is short, is not kept. Runs may last milliseconds: so nothing is kept more
 * than four times a second, nor for more than a twentieth of the time. */
#ifndef PEN_JOBS_INTERNAL_STUDY_H
#define PEN_JOBS_INTERNAL_STUDY_H

#include "jobs/internal/batch.h"
#include "jobs/internal/keep.h"
#include "study/study.h"

struct pen_study {
    struct pen_batch_context *context;
    struct pen_arena *arena; /* of desc */
    struct pen_scene_desc desc;
    int *views; /* of the job, numbers of views of desc: context->request.view_count */
    double parse_ms;
    int64_t progress_ns; /* when progress was last stored */
    struct pen_keeper keeper;
    struct pen_kept_study kept;                    /* by an earlier worker */
    json_t *kept_state;                            /* kept.state */
    uint64_t picture_hash[PEN_STUDY_PICTURES_MAX]; /* by place: of what the store has; 0: nothing */
};

/* Reads the scene and finds the views. Owns: end *study after success and failure alike. Fails: as
 * pen_store_scene and pen_scene_load; PEN_NO_MEMORY. */
bool pen_study_begin(struct pen_study *study, struct pen_batch_context *context,
                     struct pen_status *st);
void pen_study_end(struct pen_study *study);

/* Stores how many runs are done; `user` is the study. A failure is ignored: the next call may
 * succeed, and the heartbeat notices a lost lease. */
void pen_study_progress(void *user, int done, int total);

/* What the study is told: of its scene and context, how it is kept, and what an earlier worker has
 * kept of it. What is damaged counts as nothing. `user` is whose first member the study is. Owns:
 * the study. */
struct pen_study_frame pen_study_frame_of(struct pen_study *study, void *user);

/* Writes a report as JSON for the commit. One with figures (report/report.h), which are gone after
 * the study, is also stored as a page; a worker that makes the study again, because the commit
 * failed, replaces it. Fails: as pen_report_write, and pen_batch_store. */
bool pen_study_store_report(struct pen_study *study, const json_t *report,
                            const struct pen_buf *figures, struct pen_batch_output *output,
                            struct pen_status *st);

/* The statistics of a render as those of the job. Fails: PEN_NO_MEMORY. */
bool pen_study_write_stats(const struct pen_study *study, const struct pen_render_stats *render,
                           const struct pen_accel_stats *accel, double build_ms,
                           struct pen_batch_output *output, struct pen_status *st);

#endif
