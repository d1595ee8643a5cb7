/* SPDX-License-Identifier: MIT */
/* The bill of a scene's effects in the worker. Its pictures are gone after it, so all formats of
 * the report are made here: JSON is stored with the commit, the others before it. A worker that
 * makes the bill again, because the commit failed, replaces them. */
#include "jobs/internal/study.h"
#include "study/bill.h"

/* The formats that are stored before the commit. */
static const char *const stored_formats[] = {"html", "csv", "md", NULL};

static bool store_format(const struct pen_study *study, const struct pen_bill *bill,
                         const char *scene, const char *format, struct pen_status *st)
{
    struct pen_buf text = {0};
    const bool ok =
        pen_bill_write(bill, scene, format, &text, st) &&
        pen_batch_store(study->context, study->claim, PEN_REPORT_LAYER, format, &text, st);
    pen_buf_release(&text);
    return ok;
}

static bool write_report(const struct pen_study *study, const struct pen_bill *bill,
                         struct pen_batch_output *output, struct pen_status *st)
{
    const char *scene = study->desc.name ? study->desc.name : "";
    bool ok = true;
    for (int i = 0; ok && stored_formats[i]; i++)
        ok = store_format(study, bill, scene, stored_formats[i], st);
    ok = ok && pen_bill_write(bill, scene, PEN_REPORT_FORMAT, &output->artefact, st);
    pen_study_set_report(output);
    return ok;
}

static bool make_bill(struct pen_study *study, struct pen_batch_output *output,
                      struct pen_status *st)
{
    struct pen_batch_context *context = study->context;
    const struct pen_bill_task task = {.desc = &study->desc,
                                       .settings = &context->request.settings,
                                       .view = study->views[0],
                                       .repeats = context->request.repeats,
                                       .scene_cap_bytes = pen_scene_cache_cap(context->scenes),
                                       .pool = context->pool,
                                       .cancel = pen_heartbeat_cancel_flag(context->heart),
                                       .progress = pen_study_progress,
                                       .between = pen_study_keep,
                                       .kept = pen_study_kept(study),
                                       .user = study,
                                       .pixel_begins = pen_batch_pixel_hook(context),
                                       .pixel_user = context};
    struct pen_bill bill;
    const bool ok =
        pen_batch_hook_done(context, pen_bill_make(&task, &bill, st), st) &&
        write_report(study, &bill, output, st) &&
        pen_study_write_stats(study, &bill.whole, &bill.accel, bill.build_ms, output, st);
    pen_bill_release(&bill);
    return ok;
}

bool pen_batch_effects(struct pen_batch_context *context, const struct pen_claim *claim,
                       struct pen_batch_output *output, struct pen_status *st)
{
    struct pen_study study;
    const bool ok = pen_study_begin(&study, context, claim, st) && make_bill(&study, output, st);
    pen_study_end(&study);
    return ok;
}
