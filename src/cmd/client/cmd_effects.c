/* SPDX-License-Identifier: MIT */
/* `penumbra effects`: what each effect of a scene costs, without a daemon. */

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/progress.h"
#include "cmd/client/report_output.h"
#include "cmd/client/scene_input.h"
#include "cmd/client/setting_options.h"
#include "cmd/report.h"
#include "report/report.h"
#include "study/bill.h"

struct values {
    const char *format, *view;
    struct pen_option_list output, set;
    int repeats, threads;
    bool quiet, json;
};

static const struct pen_option options[] = {
    {.name = "repeats",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, repeats),
     .value = "N",
     .min = 1,
     .max = PEN_BENCH_REPEATS_MAX,
     .help = "timed renders of the scene and of each without an effect, 3 by default"},
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

/* All state of a bill. run() frees what has been allocated, at any stage. */
struct effects {
    const struct values *values;
    struct pen_scene_input input;
    struct pen_thread_pool *pool;
    struct pen_bill_task task;
    struct pen_bill bill;
    struct pen_progress progress;
};

static const char *scene_name(const struct effects *e)
{
    return e->input.desc.name[0] ? e->input.desc.name : e->input.source.label;
}

static void show_progress(void *user, int done, int total)
{
    pen_progress_show(user, (double)done / total, -1);
}

static bool make_bill(struct effects *e, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc *desc = &e->input.desc;
    if (!pen_set_options_apply(&e->values->set, &desc->settings, st))
        return false;
    e->task = (struct pen_bill_task){
        .frame = {.desc = desc, .progress = show_progress, .user = &e->progress},
        .settings = &desc->settings,
        .repeats = e->values->repeats};
    if (e->values->view)
        e->task.view = pen_scene_input_view(&e->input, e->values->view, st);
    if (e->task.view < 0 ||
        !pen_bill_check(&limits, desc, e->task.view, &desc->settings, e->values->repeats, "", st) ||
        !(e->pool = pen_thread_pool_new(e->values->threads, st)))
        return false;
    e->task.frame.pool = e->pool;
    pen_progress_begin(&e->progress, e->input.source.label, e->values->quiet);
    const bool ok = pen_bill_make(&e->task, &e->bill, st);
    pen_progress_end(&e->progress);
    return ok;
}

static bool write_report(const struct effects *e, struct pen_status *st)
{
    const struct pen_report_output output = PEN_REPORT_OUTPUT_OF(e->values);
    struct pen_buf figures = {0};
    json_t *report = pen_bill_json(&e->bill, scene_name(e));
    pen_bill_figures(&e->bill, &figures);
    const bool ok = report && !figures.failed
                        ? pen_report_output_write(&output, report, &figures, st)
                        : pen_fail(st, PEN_NO_MEMORY, "out of memory");
    pen_buf_release(&figures);
    json_decref(report);
    return ok;
}

static int effects(struct effects *e, const char *name)
{
    const bool json = e->values->json;
    const struct pen_report_output output = PEN_REPORT_OUTPUT_OF(e->values);
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!pen_report_output_check(&output, &st))
        return pen_report_json(NULL, json, &st);
    if (!pen_scene_input_read(&e->input, name, NULL, &errors))
        return pen_report_errors_json(e->input.source.label, json, &errors);
    if (!make_bill(e, &st) || !write_report(e, &st)) {
        pen_source_locate(&e->input.source, &st);
        return pen_report_json(st.at[0] || st.line > 0 ? e->input.source.label : NULL, json, &st);
    }
    return 0;
}

static int run(int argc, char **argv)
{
    struct values values = {.repeats = 3};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_effects, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct effects e = {.values = &values};
    code = effects(&e, parsed.args[0]);
    pen_bill_release(&e.bill);
    pen_thread_pool_free(e.pool);
    pen_scene_input_release(&e.input);
    return code;
}

const struct pen_command pen_command_effects = {
    .program = "penumbra",
    .name = "effects",
    .arguments = "SCENE",
    .summary = "Says what each effect of a scene costs, without a daemon.",
    .details =
        "SCENE is a file, - for standard input, or builtin:NAME. The scene is rendered as it is, "
        "and with each of its effects left out in turn; the renders are interleaved, and times "
        "are medians. What an effect costs is the whole time less the time without it. The page "
        "that -o bill.html writes shows the pictures as well.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
