/* SPDX-License-Identifier: MIT */
/* Chooses the function for a batch by its kind, and for a study by the kind of its job. */
#include "jobs/internal/batch.h"

#include "base/clock.h"
#include "base/memory.h"

static pen_batch_run_fn *const studies[PEN_KIND_COUNT] = {[PEN_KIND_BENCHMARK] =
                                                              pen_batch_benchmark,
                                                          [PEN_KIND_EFFECTS] = pen_batch_effects,
                                                          [PEN_KIND_EXPLAIN] = pen_batch_explain,
                                                          [PEN_KIND_ACCURACY] = pen_batch_accuracy};

bool pen_batch_run(struct pen_batch_context *context, struct pen_batch_output *output,
                   struct pen_status *st)
{
    const enum pen_batch_kind kind = context->claim->kind;
    *output = (struct pen_batch_output){0};
    pen_memory_peak_reset();
    context->begun_ns = pen_clock_ns();
    if (!pen_batch_context_load(context, st))
        return false;
    pen_batch_run_fn *run = kind == PEN_BATCH_RENDER     ? pen_batch_render
                            : kind == PEN_BATCH_ASSEMBLE ? pen_batch_assemble
                                                         : studies[context->request.kind];
    const bool ok =
        run ? run(context, output, st)
            : pen_fail(st, PEN_STORAGE, "job %s has a batch of an unknown kind", context->job_id);
    if (!ok)
        pen_batch_output_release(output);
    return ok;
}
