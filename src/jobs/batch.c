/* SPDX-License-Identifier: MIT */
/* Choosing the function for a batch by its kind. */
#include "jobs/internal/batch.h"

#include "base/memory.h"

static pen_batch_run_fn *function_of(enum pen_batch_kind kind)
{
    switch (kind) {
    case PEN_BATCH_RENDER:
        return pen_batch_render;
    case PEN_BATCH_ASSEMBLE:
        return pen_batch_assemble;
    case PEN_BATCH_STUDY:
        return pen_batch_benchmark;
    }
    return NULL;
}

bool pen_batch_run(struct pen_batch_context *context, const struct pen_claim *claim,
                   struct pen_batch_output *output, struct pen_status *st)
{
    pen_batch_run_fn *run = function_of(claim->kind);
    *output = (struct pen_batch_output){0};
    pen_memory_peak_reset();
    bool ok = pen_batch_context_load(context, claim, st);
    if (ok && !run)
        ok = pen_fail(st, PEN_STORAGE, "job %s has a batch of an unknown kind", claim->job_id);
    ok = ok && run(context, claim, output, st);
    if (!ok)
        pen_batch_output_release(output);
    return ok;
}
