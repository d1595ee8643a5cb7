/* SPDX-License-Identifier: MIT */
/* Choosing the function for a batch by its kind, and for a study by that of its job. */
#include "jobs/internal/batch.h"

#include "base/clock.h"
#include "base/memory.h"

static pen_batch_run_fn *study_of(enum pen_job_kind kind)
{
    switch (kind) {
    case PEN_KIND_BENCHMARK:
        return pen_batch_benchmark;
    case PEN_KIND_EFFECTS:
        return pen_batch_effects;
    case PEN_KIND_EXPLAIN:
        return pen_batch_explain;
    case PEN_KIND_ACCURACY:
        return pen_batch_accuracy;
    case PEN_KIND_RENDER:
    case PEN_KIND_COUNT:
        break;
    }
    return NULL;
}

static pen_batch_run_fn *function_of(enum pen_batch_kind kind, enum pen_job_kind job)
{
    switch (kind) {
    case PEN_BATCH_RENDER:
        return pen_batch_render;
    case PEN_BATCH_ASSEMBLE:
        return pen_batch_assemble;
    case PEN_BATCH_STUDY:
        return study_of(job);
    }
    return NULL;
}

bool pen_batch_run(struct pen_batch_context *context, const struct pen_claim *claim,
                   struct pen_batch_output *output, struct pen_status *st)
{
    *output = (struct pen_batch_output){0};
    pen_memory_peak_reset();
    context->begun_ns = pen_clock_ns();
    bool ok = pen_batch_context_load(context, claim, st);
    pen_batch_run_fn *run = ok ? function_of(claim->kind, context->request.kind) : NULL;
    if (ok && !run)
        ok = pen_fail(st, PEN_STORAGE, "job %s has a batch of an unknown kind", claim->job_id);
    ok = ok && run(context, claim, output, st);
    if (!ok)
        pen_batch_output_release(output);
    return ok;
}
