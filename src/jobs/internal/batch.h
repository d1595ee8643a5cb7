/* SPDX-License-Identifier: MIT */
/* Running one batch: from its claim to its result in memory, which worker.c commits. */
#ifndef PEN_JOBS_INTERNAL_BATCH_H
#define PEN_JOBS_INTERNAL_BATCH_H

#include "jobs/internal/batch_context.h"
#include "jobs/internal/keep.h"
#include "render/audit.h"
#include "render/forecast.h"

/* Runs the batch of a claim, of any kind. Owns: release *output after success. Fails:
 * PEN_CANCELLED: the heartbeat has stopped it. PEN_NOT_FOUND: the job was deleted. PEN_STALE: the
 * claim is lost. PEN_STORAGE, PEN_STORAGE_FULL, PEN_UNAVAILABLE: the store failed. Any other code
 * is an error of the job. */
bool pen_batch_run(struct pen_batch_context *context, struct pen_batch_output *output,
                   struct pen_status *st);

/* The function for one kind of batch. *output is empty at the call; the caller releases it, after
 * success and failure alike. */
typedef bool pen_batch_run_fn(struct pen_batch_context *context, struct pen_batch_output *output,
                              struct pen_status *st);

/* batch_render.c: renders the claim's tiles, and encodes the picture if they are the whole view. */
pen_batch_run_fn pen_batch_render;

/* batch_render.c: encodes the picture of a view from its committed pixels. */
pen_batch_run_fn pen_batch_assemble;

/* batch_layers.c: the layers that the job asks for. All fail as pen_batch_run.
 *  - make: without a target error, makes those of the claim's first *tiles tiles, of all or, if
 *    `bounded`, as far as there is time: then *tiles becomes how many, and the batch is to render
 * no others. *ms is the time it took. With a target error it does nothing.
 *  - store: stores what `make` has made, of so many tiles.
 *  - end: frees it, after success and failure alike.
 *  - after_rounds: with a target error, makes and stores them of the claim's view, whose rounds
 *    have ended with these statistics. Fails: also as pen_batch_rounds.
 *  - assemble: stores those of a view of several batches; `begins` as of pen_view_pixels_load. */
bool pen_batch_layers_make(struct pen_batch_context *context, bool bounded, int *tiles, double *ms,
                           struct pen_status *st);
bool pen_batch_layers_store(struct pen_batch_context *context, int tiles, struct pen_status *st);
void pen_batch_layers_end(struct pen_batch_context *context);
bool pen_batch_layers_after_rounds(struct pen_batch_context *context,
                                   const struct pen_render_stats *stats, struct pen_status *st);
bool pen_batch_layers_assemble(struct pen_batch_context *context, const unsigned char *begins,
                               struct pen_status *st);

/* batch_layers.c: how many times as long as the pixels of the context's job its layers take. */
double pen_batch_layer_work(const struct pen_batch_context *context);

/* batch_rounds.c: renders a view with a target error, as pen_render_rounds does, and leaves its
 * state in the context; goes on from the tile that an earlier worker has kept. Fails: also
 * PEN_UNAVAILABLE, when a batch of higher priority waits; PEN_TOO_LARGE, when the job takes longer
 * than the operator allows. */
bool pen_batch_rounds(struct pen_batch_context *context, const struct pen_render_task *task,
                      struct pen_render_stats *stats, struct pen_status *st);

/* batch_rounds.c: keeps a part of what follows the pixels of a view, which is `done` (pen_kept),
 * and with it the state that rounds have left, unless there were none or the store has it. A part
 * with no bytes is one that memory ran out for. `stats` are those of the rounds. Returns whether to
 * go on. */
bool pen_batch_keep_after_rounds(struct pen_keeper *keeper, const struct pen_render_stats *stats,
                                 int64_t done, const struct pen_kept_part *part, int64_t begun_ns);

/* batch_rounds.c: whether to stop there, since the keeper is due or the job is overdue: `pause` of
 * a task, whose user is the keeper, which has these times. */
enum { PEN_KEEP_MS = 10000, PEN_ASK_MS = 500 };
bool pen_batch_keeper_pauses(void *keeper);

/* batch_audit.c: audits the picture of the claim's view, which the film has, if the job asks for
 * that; then *done is true. `stats` are those of the view's rounds, or of other renders. Fails: as
 * pen_batch_rounds. */
bool pen_batch_audit(struct pen_batch_context *context, const struct pen_film *film,
                     const struct pen_render_stats *stats, struct pen_audit *audit, bool *done,
                     struct pen_status *st);

/* batch_estimate.c: before the first batch of a job that may take long, estimates what it will
 * take and where its work lies, and stores that; before others, reads where it lies. A small job is
 * left as it is. Fails: as pen_forecast_make; PEN_TOO_LARGE if that is longer than the operator
 * allows. */
bool pen_batch_estimate(struct pen_batch_context *context, const struct pen_scene *scene, int view,
                        struct pen_status *st);

/* batch_estimate.c: whether the operator allows so many times an estimated time, as far as the
 * lower end of its interval tells. Fails: PEN_TOO_LARGE, if not. */
bool pen_batch_allowed(const struct pen_batch_context *context, const struct pen_estimate *time_ms,
                       double times, struct pen_status *st);

/* batch_estimate.c: tells from the time that the job has taken, and the pace at which this worker
 * renders it, whether all of it is expected to take longer than the operator allows. Fails:
 * PEN_TOO_LARGE, if so. */
bool pen_batch_expected(struct pen_batch_context *context, struct pen_status *st);

/* batch_benchmark.c: runs a whole benchmark; the artefact is the report as JSON. */
pen_batch_run_fn pen_batch_benchmark;

/* batch_effects.c: makes the bill of a scene's effects; the artefact is the report as JSON. */
pen_batch_run_fn pen_batch_effects;

/* batch_accuracy.c: makes an accuracy study; the artefact is the report as JSON. */
pen_batch_run_fn pen_batch_accuracy;

/* batch_explain.c: explains a scene; the artefact is the explanation. */
pen_batch_run_fn pen_batch_explain;

#endif
