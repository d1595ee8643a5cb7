/* SPDX-License-Identifier: MIT */
/* An accuracy study in the worker. */
#include <math.h>

#include "jobs/accuracy_spec.h"
#include "jobs/internal/study.h"

struct accuracy {
    struct pen_study study; /* the first member: progress and keep take the address for the study */
    struct pen_accuracy_spec spec;
    struct pen_accuracy_task task;
    struct pen_accuracy accuracy;
    json_t *report;
};

/* Stores the forecast of the study, for readers of the job. A failure is ignored. */
static void forecast(void *user, const struct pen_accuracy_forecast *forecast)
{
    struct accuracy *a = user;
    struct pen_status ignored;
    const double ms = fmin(forecast->expected_ms, a->task.budget_ms);
    a->study.context->work.expected_ms = ms;
    pen_store_estimate(a->study.context->store, a->study.context->claim, (int64_t)ceil(ms), NULL,
                       &ignored);
}

static bool read_spec(struct accuracy *a, struct pen_status *st)
{
    struct pen_batch_context *context = a->study.context;
    const struct pen_stored_request *request = &context->request;
    struct pen_errors errors = {0};
    if (!pen_accuracy_spec_read(request->json, &a->study.desc, &request->settings, &a->spec,
                                &errors)) {
        *st = errors.item[0];
        return false;
    }
    a->task = pen_accuracy_of_spec(&a->spec);
    a->task.frame = pen_study_frame_of(&a->study, a);
    a->task.settings = &request->settings;
    a->task.view = a->study.views[0];
    a->task.limits = pen_limits_default();
    a->task.forecast = forecast;
    return true;
}

static bool write_report(struct accuracy *a, struct pen_batch_output *output, struct pen_status *st)
{
    const char *name = a->study.desc.name;
    struct pen_buf figures = {0};
    a->report = pen_accuracy_json(&a->accuracy, name ? name : "");
    const bool ok = a->report
                        ? pen_accuracy_figures(&a->accuracy, a->report, &figures, st) &&
                              pen_study_store_report(&a->study, a->report, &figures, output, st)
                        : pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    pen_buf_release(&figures);
    return ok;
}

bool pen_batch_accuracy(struct pen_batch_context *context, struct pen_batch_output *output,
                        struct pen_status *st)
{
    struct accuracy a = {.spec = {.ladder = NULL}};
    const bool ok = pen_study_begin(&a.study, context, st) && read_spec(&a, st) &&
                    pen_batch_hook_done(context, pen_accuracy_make(&a.task, &a.accuracy, st), st) &&
                    write_report(&a, output, st) &&
                    pen_study_write_stats(&a.study, &a.accuracy.stats, &a.accuracy.accel,
                                          a.accuracy.build_ms, output, st);
    json_decref(a.report);
    if (a.accuracy.task)
        pen_accuracy_release(&a.accuracy);
    pen_accuracy_spec_release(&a.spec);
    pen_study_end(&a.study);
    return ok;
}
