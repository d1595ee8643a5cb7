/* SPDX-License-Identifier: MIT */
/* The bill of a scene's effects in the worker. */
#include "jobs/internal/study.h"
#include "study/bill.h"

struct effects {
    struct pen_study study; /* the first member: progress and keep take it for the study */
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
    const struct pen_bill_task task = {.desc = &e->study.desc,
                                       .settings = &context->request.settings,
                                       .view = e->study.views[0],
                                       .repeats = context->request.repeats,
                                       .scene_cap_bytes = context->options->scene_cap_bytes,
                                       .pool = context->pool,
                                       .cancel = pen_heartbeat_cancel_flag(context->heart),
                                       .progress = pen_study_progress,
                                       .between = pen_study_keep,
                                       .kept = pen_study_kept(&e->study),
                                       .user = e,
                                       .pixel_begins = pen_batch_pixel_hook(context),
                                       .pixel_user = context};
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
