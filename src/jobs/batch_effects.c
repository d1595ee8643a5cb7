/* SPDX-License-Identifier: MIT */
/* The bill of a scene's effects in the worker. */
#include "jobs/internal/study.h"
#include "study/bill.h"

struct effects {
    struct pen_study study; /* the first member: progress and keep take the address for the study */
    struct pen_bill bill;
};

static bool write_report(struct effects *e, struct pen_batch_output *output, struct pen_status *st)
{
    const char *scene = e->study.desc.name;
    struct pen_buf figures = {0};
    json_t *report = pen_bill_json(&e->bill, scene ? scene : "");
    pen_bill_figures(&e->bill, &figures);
    const bool ok = report ? pen_study_store_report(&e->study, report, &figures, output, st)
                           : pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    pen_buf_release(&figures);
    json_decref(report);
    return ok;
}

static bool make_bill(struct effects *e, struct pen_batch_output *output, struct pen_status *st)
{
    struct pen_batch_context *context = e->study.context;
    struct pen_bill *bill = &e->bill;
    const struct pen_bill_task task = {.frame = pen_study_frame_of(&e->study, e),
                                       .settings = &context->request.settings,
                                       .view = e->study.views[0],
                                       .repeats = context->request.repeats};
    const bool ok =
        pen_batch_hook_done(context, pen_bill_make(&task, bill, st), st) &&
        write_report(e, output, st) &&
        pen_study_write_stats(&e->study, &bill->whole, &bill->accel, bill->build_ms, output, st);
    pen_bill_release(bill);
    return ok;
}

bool pen_batch_effects(struct pen_batch_context *context, struct pen_batch_output *output,
                       struct pen_status *st)
{
    struct effects e;
    const bool ok = pen_study_begin(&e.study, context, st) && make_bill(&e, output, st);
    pen_study_end(&e.study);
    return ok;
}
