/* SPDX-License-Identifier: MIT */
/* Running one batch: from its claim to its result in memory, which worker.c commits. */
#ifndef PEN_JOBS_INTERNAL_BATCH_H
#define PEN_JOBS_INTERNAL_BATCH_H

#include "jobs/internal/batch_context.h"
#include "jobs/internal/keep.h"
#include "render/audit.h"
#include "render/forecast.h"

/* Runs the batch of a claim, of any kind.
 * Owns: release *output after success.
 * Fails: PEN_CANCELLED (the heartbeat has stopped it), PEN_NOT_FOUND (the job was deleted),
 * PEN_STALE (the claim is lost); PEN_STORAGE, PEN_STORAGE_FULL, PEN_UNAVAILABLE (the store failed).
 * Any other code is an error of the job. */
bool pen_batch_run(struct pen_batch_context *context, struct pen_batch_output *output,
                   struct pen_status *st);

/* Runs a batch of one kind. *output is empty at the call.
 * Owns: the caller releases *output, after success and after failure. */
typedef bool pen_batch_run_fn(struct pen_batch_context *context, struct pen_batch_output *output,
                              struct pen_status *st);

/* batch_render.c: renders the claim's tiles. If they are the whole view, it also encodes the
 * picture. */
pen_batch_run_fn pen_batch_render;

/* batch_render.c: encodes the picture of a view from its committed pixels. */
pen_batch_run_fn pen_batch_assemble;

/* batch_layers.c: makes the layers that the job asks for. All fail as pen_batch_run.
 *   - make: makes the layers of the claim's first *tiles tiles. If `bounded`, it stops when the
 *     time is up; *tiles becomes the number of tiles that it made, and the batch must not render
 *     others. *ms is its time. With a target error it does nothing.
 *   - store: stores the layers that `make` made, of the first `tiles` tiles.
 *   - end: frees them, after success and after failure.
 *   - after_rounds: with a target error, makes and stores the layers of the claim's view. The
 *     rounds of the view have ended with these statistics. Fails also as pen_batch_rounds.
 *   - assemble: stores the layers of a view of several batches. `begins` is as for
 *     pen_view_pixels_load. */
bool pen_batch_layers_make(struct pen_batch_context *context, bool bounded, int *tiles, double *ms,
                           struct pen_status *st);
bool pen_batch_layers_store(struct pen_batch_context *context, int tiles, struct pen_status *st);
void pen_batch_layers_end(struct pen_batch_context *context);
bool pen_batch_layers_after_rounds(struct pen_batch_context *context,
                                   const struct pen_render_stats *stats, struct pen_status *st);
bool pen_batch_layers_assemble(struct pen_batch_context *context, const unsigned char *begins,
                               struct pen_status *st);

/* batch_layers.c: returns the time of the job's layers, as a multiple of the time of its pixels. */
double pen_batch_layer_work(const struct pen_batch_context *context);

/* batch_rounds.c: renders a view with a target error, as pen_render_rounds does. It leaves the
 * state of the rounds in the context. It continues from the tile that an earlier worker has kept.
 * Fails: also PEN_UNAVAILABLE (a batch that comes first waits), PEN_TOO_LARGE (the job takes longer
 * than the operator allows). */
bool pen_batch_rounds(struct pen_batch_context *context, const struct pen_render_task *task,
                      struct pen_render_stats *stats, struct pen_status *st);

/* batch_rounds.c: keeps a part of the work that follows the pixels of a view; `done` is as in
 * pen_kept. The state of the rounds is kept with it, unless there is none or the store has it. A
 * part without bytes stands for a part for which there was no memory. `stats` are of the rounds.
 * Returns true if the work may go on. */
bool pen_batch_keep_after_rounds(struct pen_keeper *keeper, const struct pen_render_stats *stats,
                                 int64_t done, const struct pen_kept_part *part, int64_t begun_ns);

/* batch_rounds.c: returns true if the work must pause, because the keeper is due or the job is
 * overdue. It is `pause` of a task, whose user is the keeper. The keeper has the times below. */
enum { PEN_KEEP_MS = 10000, PEN_ASK_MS = 500 };
bool pen_batch_keeper_pauses(void *keeper);

/* batch_audit.c: audits the picture of the claim's view, which is in the film, if the job asks for
 * it; then *done is true. `stats` are of the view's rounds, or of its render.
 * Fails: as pen_batch_rounds. */
bool pen_batch_audit(struct pen_batch_context *context, const struct pen_film *film,
                     const struct pen_render_stats *stats, struct pen_audit *audit, bool *done,
                     struct pen_status *st);

/* batch_estimate.c: before the first batch of a job that may take long, estimates its time and
 * where its work lies, and stores both. Before other batches, reads where the work lies. A small
 * job gets no estimate.
 * Fails: as pen_forecast_make; PEN_TOO_LARGE if the estimate is longer than the operator allows. */
bool pen_batch_estimate(struct pen_batch_context *context, const struct pen_scene *scene, int view,
                        struct pen_status *st);

/* batch_estimate.c: checks that the operator allows `times` an estimated time. The lower end of the
 * interval counts.
 * Fails: PEN_TOO_LARGE. */
bool pen_batch_allowed(const struct pen_batch_context *context, const struct pen_estimate *time_ms,
                       double times, struct pen_status *st);

/* batch_estimate.c: checks that the whole job is not expected to take longer than the operator
 * allows. It uses the time that the job has taken, and the pace of this worker.
 * Fails: PEN_TOO_LARGE. */
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
