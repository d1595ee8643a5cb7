/* SPDX-License-Identifier: MIT */
/* `penumbra accuracy`: what a picture's accuracy costs in time, without a daemon. */
#include <stdio.h>

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/progress.h"
#include "cmd/client/report_output.h"
#include "cmd/client/scene_input.h"
#include "cmd/client/setting_options.h"
#include "cmd/report.h"
#include "report/report.h"

struct values {
    struct pen_accuracy_values accuracy;
    const char *format, *view;
    struct pen_option_list output, set;
    double budget;
    int threads;
    bool quiet, json;
};

static const struct pen_option options[] = {
    PEN_ACCURACY_OPTIONS(struct values, ""),
    {.name = "budget",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, budget),
     .value = "SECONDS",
     .max = PEN_ACCURACY_BUDGET_MAX_S,
     .help = "what the whole study may take, 60 by default; the report says what it left out"},
    PEN_SET_OPTION(struct values),
    PEN_VIEW_OPTION(struct values),
    PEN_RENDER_THREADS_OPTION(struct values),
    {.name = "output",
     .letter = 'o',
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, output),
     .value = "OUT",
     .help = "the report's file; its ending, .html, .json, .csv or .md, gives the format; may be "
             "repeated"},
    PEN_FORMAT_OPTION(struct values, "json|csv|md|html", pen_report_formats),
    PEN_QUIET_OPTION(struct values, "no progress bar and no table"),
    PEN_JSON_OPTION(struct values, "print the report as a line of JSON instead of a table"),
    {0}};

/* All state of a study. run() frees what has been allocated, at any stage. */
struct study {
    const struct values *values;
    struct pen_scene_input input;
    struct pen_accuracy_spec spec;
    struct pen_thread_pool *pool;
    struct pen_accuracy_task task;
    struct pen_accuracy accuracy;
    json_t *report;
    struct pen_progress progress;
};

static const char *scene_name(const struct study *s)
{
    return s->input.desc.name[0] ? s->input.desc.name : s->input.source.label;
}

static void show_progress(void *user, int done, int total)
{
    struct study *s = user;
    pen_progress_show(&s->progress, (double)done / total, -1);
}

/* Shows the forecast before the study begins. */
static void show_forecast(void *user, const struct pen_accuracy_forecast *forecast)
{
    const struct study *s = user;
    const double budget_s = s->task.budget_ms / 1000;
    if (s->values->quiet)
        return;
    fprintf(stderr, "%d row%s, %d seed%s: expected to take %.3g s (%.3g to %.3g)",
            s->task.row_count, s->task.row_count == 1 ? "" : "s", s->task.seeds,
            s->task.seeds == 1 ? "" : "s", forecast->expected_ms / 1000, forecast->low_ms / 1000,
            forecast->high_ms / 1000);
    if (forecast->expected_ms > s->task.budget_ms)
        fprintf(stderr, ", of which %g s are allowed: --budget", budget_s);
    fputs("\n", stderr);
}

/* Makes the rows from the command line's options. */
static bool read_spec(struct study *s, struct pen_errors *errors)
{
    struct pen_status st;
    json_t *members = json_object();
    bool ok = pen_accuracy_options_add(members, &s->values->accuracy, &st);
    if (ok && s->values->budget >= 0)
        ok = json_object_set_new(members, "budget_seconds", json_real(s->values->budget)) == 0 ||
             pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    if (!ok)
        pen_errors_add(errors, &st);
    else
        ok = pen_accuracy_spec_read(members, &s->input.desc, &s->input.desc.settings, &s->spec,
                                    errors);
    pen_bench_options_errors(errors);
    json_decref(members);
    return ok;
}

static bool prepare(struct study *s, struct pen_errors *errors)
{
    struct pen_scene_desc *desc = &s->input.desc;
    struct pen_status st;
    if (!pen_set_options_apply(&s->values->set, &desc->settings, &st)) {
        pen_errors_add(errors, &st);
        return false;
    }
    if (!read_spec(s, errors))
        return false;
    s->task = pen_accuracy_of_spec(&s->spec);
    s->task.frame.desc = desc;
    s->task.settings = &desc->settings;
    s->task.limits = pen_limits_default();
    s->task.forecast = show_forecast;
    s->task.frame.progress = show_progress;
    s->task.frame.user = s;
    if (s->values->view)
        s->task.view = pen_scene_input_view(&s->input, s->values->view, &st);
    if (s->task.view >= 0 && pen_accuracy_check(&s->task, "", &st))
        return true;
    pen_errors_add(errors, &st);
    return false;
}

static bool measure(struct study *s, struct pen_status *st)
{
    if (!(s->pool = pen_thread_pool_new(s->values->threads, st)))
        return false;
    s->task.frame.pool = s->pool;
    pen_progress_begin(&s->progress, s->input.source.label, s->values->quiet);
    const bool ok = pen_accuracy_make(&s->task, &s->accuracy, st);
    pen_progress_end(&s->progress);
    if (!ok)
        return false;
    s->report = pen_accuracy_json(&s->accuracy, scene_name(s));
    return s->report || pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

static bool write_report(const struct study *s, struct pen_status *st)
{
    const struct pen_report_output output = PEN_REPORT_OUTPUT_OF(s->values);
    struct pen_buf figures = {0};
    const bool ok = pen_accuracy_figures(&s->accuracy, s->report, &figures, st) &&
                    pen_report_output_write(&output, s->report, &figures, st);
    pen_buf_release(&figures);
    return ok;
}

static int accuracy(struct study *s, const char *name)
{
    const bool json = s->values->json;
    const struct pen_report_output output = PEN_REPORT_OUTPUT_OF(s->values);
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!pen_report_output_check(&output, &st))
        return pen_report_json(NULL, json, &st);
    if (!pen_scene_input_read(&s->input, name, NULL, &errors))
        return pen_report_errors_json(s->input.source.label, json, &errors);
    if (!prepare(s, &errors))
        return pen_report_errors_json(NULL, json, &errors);
    if (!measure(s, &st) || !write_report(s, &st))
        return pen_report_json(NULL, json, &st);
    return 0;
}

static int run(int argc, char **argv)
{
    struct values values = {.accuracy.seeds = -1, .budget = -1};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_accuracy, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct study s = {.values = &values};
    code = accuracy(&s, parsed.args[0]);
    json_decref(s.report);
    if (s.accuracy.task)
        pen_accuracy_release(&s.accuracy);
    pen_accuracy_spec_release(&s.spec);
    pen_thread_pool_free(s.pool);
    pen_scene_input_release(&s.input);
    return code;
}

const struct pen_command pen_command_accuracy = {
    .program = "penumbra",
    .name = "accuracy",
    .arguments = "SCENE",
    .summary = "Says what a picture's accuracy costs in time, without a daemon.",
    .details =
        "SCENE is a file, - for standard input, or builtin:NAME. The scene is rendered as it is, "
        "and with each value of the ladder in place of its own; every row with several seeds, "
        "interleaved. All pictures are compared with a reference of far more samples, whose own "
        "error is estimated. The report sets time against error, says which row is the cheapest "
        "that meets the target, and how fast errors fall. The page that -o study.html writes "
        "shows the pictures and their error maps as well.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
