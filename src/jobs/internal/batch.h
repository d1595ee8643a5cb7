/* SPDX-License-Identifier: MIT */
/* One batch, from claim to result, in memory: worker.c commits the result. */
#ifndef PEN_JOBS_INTERNAL_BATCH_H
#define PEN_JOBS_INTERNAL_BATCH_H

#include "jobs/internal/batch_context.h"

/* Does the batch of a claim, whatever its kind. Owns: release *output after success. Fails:
 * PEN_CANCELLED when the heartbeat has stopped it; PEN_NOT_FOUND (the job is gone), PEN_STORAGE …:
 * the store; any other code is an error of the job. */
bool pen_batch_run(struct pen_batch_context *context, const struct pen_claim *claim,
                   struct pen_batch_output *output, struct pen_status *st);

/* The kinds of batches; *output is empty at first, and released by the caller also on failure. */
typedef bool pen_batch_do_fn(struct pen_batch_context *context, const struct pen_claim *claim,
                             struct pen_batch_output *output, struct pen_status *st);

/* batch_render.c: renders the claim's tiles; if they are the whole view its picture comes too. */
pen_batch_do_fn pen_batch_render;

/* batch_render.c: encodes the picture of a view from its committed pixels. */
pen_batch_do_fn pen_batch_assemble;

/* batch_benchmark.c: a whole benchmark; its artefact is the report as JSON. */
pen_batch_do_fn pen_batch_benchmark;

#endif
