/* SPDX-License-Identifier: MIT */
/* `penumbra bench`: a benchmark in this process, without a daemon; the same runs and the same
 * report as a job of kind benchmark. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cmd/client/bench_options.h"
#include "cmd/client/commands.h"
#include "cmd/client/output.h"
#include "cmd/client/progress.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "jobs/bench_spec.h"
#include "study/report.h"

struct values {
    const char *format, *csv, *baseline;
    struct pen_option_list output, set, matrix, view;
    int repeats, warmup, threads;
    bool quiet, json;
};

static const struct pen_option options[] = {
    {.name = "matrix",
     .letter = 'm',
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, matrix),
     .value = "KEY=VALUE,…",
     .help = "values of a render setting to be compared; may be repeated, every combination is a "
             "row"},
    {.name = "repeats",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, repeats),
     .value = "N",
     .min = 1,
     .max = PEN_BENCH_REPEATS_MAX,
     .help = "runs of each row, 3 by default"},
    {.name = "warmup",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, warmup),
     .value = "N",
     .max = PEN_BENCH_WARMUP_MAX,
     .help = "runs of each row before those, not counted; 1 by default"},
    {.name = "baseline",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, baseline),
     .value = "KEY=VALUE,…",
     .help = "the row that speed-ups refer to, the first by default"},
    {.name = "set",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, set),
     .value = "KEY=VALUE",
     .help = "a render setting of all rows, over what the scene says; may be repeated"},
    {.name = "view",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, view),
     .value = "NAME",
     .help = "only this view of the scene, instead of all; may be repeated"},
    {.name = "threads",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, threads),
     .value = "N",
     .max = 1024,
     .help = "the pool that the setting threads is a share of; 0, the default, is one per core"},
    {.name = "output",
     .letter = 'o',
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, output),
     .value = "OUT",
     .help = "where the report goes; .json, .csv, .md or .html by its ending; may be repeated"},
    {.name = "format",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, format),
     .value = "json|csv|md|html",
     .choices = pen_bench_report_formats,
     .help = "whatever the ending of OUT says"},
    {.name = "csv",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, csv),
     .value = "FILE",
     .help = "writes the rows there too, as CSV"},
    {.name = "quiet",
     .letter = 'q',
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, quiet),
     .help = "no progress bar and no table"},
    {.name = "json",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, json),
     .help = "print the report as a line of JSON instead of a table"},
    {0}};

/* Everything one benchmark holds; released whole, whatever was reached. */
struct study {
    const struct values *values;
    struct pen_source source;
    struct pen_arena *arena;
    struct pen_scene_desc desc; /* in the arena */
    struct pen_bench_spec order;
    struct pen_bench bench;
    struct pen_bench_result result;
    int *views;
    json_t *report;
    struct pen_progress progress;
};

static bool check_output(const struct values *v, const char *output, struct pen_status *st)
{
    if (!pen_output_report_format(output, v->format, st))
        return false;
    if (strcmp(output, "-") == 0 && v->json)
        return pen_fail(st, PEN_USAGE, "-o -: standard output is also what --json uses");
    if (v->csv && strcmp(output, v->csv) == 0)
        return pen_fail(st, PEN_USAGE, "--csv: is the same as -o, \"%s\"", v->csv);
    return pen_file_check(output, st);
}

static bool check_values(const struct values *v, struct pen_status *st)
{
    if (v->format && v->output.count != 1)
        return pen_fail(st, PEN_USAGE, "--format: needs one -o OUT");
    for (int i = 0; i < v->output.count; i++) {
        if (!check_output(v, v->output.item[i], st))
            return false;
    }
    return !v->csv || pen_file_check(v->csv, st);
}

/* Text to description. Errors of the document go to `errors`. */
static bool read_scene(struct study *s, const char *name, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    bool ok = pen_source_read(&s->source, name, limits.body_bytes, &st);
    if (ok && !(s->arena = pen_arena_new(0)))
        ok = pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    if (!ok) {
        pen_errors_add(errors, &st);
        return false;
    }
    return pen_source_scene(&s->source, &limits, s->arena, &s->desc, errors);
}

static bool find_view(const struct study *s, const char *name, int *view, struct pen_status *st)
{
    for (uint32_t i = 0; i < s->desc.view_count; i++) {
        if (strcmp(s->desc.views[i].name, name) == 0) {
            *view = (int)i;
            return true;
        }
    }
    return pen_fail(st, PEN_NOT_FOUND, "no view \"%s\", the first is \"%s\"", name,
                    s->desc.views[0].name);
}

static bool choose_views(struct study *s, struct pen_status *st)
{
    const struct pen_option_list *wanted = &s->values->view;
    int count = wanted->count > 0 ? wanted->count : (int)s->desc.view_count;
    s->views = calloc((size_t)count, sizeof *s->views);
    if (!s->views)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    for (int i = 0; i < count; i++) {
        s->views[i] = i;
        if (wanted->count > 0 && !find_view(s, wanted->item[i], &s->views[i], st))
            return false;
    }
    s->bench.views = s->views;
    s->bench.view_count = count;
    return true;
}

static bool apply_settings(struct study *s, struct pen_status *st)
{
    for (int i = 0; i < s->values->set.count; i++) {
        if (!pen_output_set(&s->desc.settings, s->values->set.item[i], st))
            return false;
    }
    return true;
}

/* The rows, from the command line's options. */
static bool read_order(struct study *s, struct pen_errors *errors)
{
    const struct values *v = s->values;
    struct pen_status st;
    json_t *members = json_pack("{s:i, s:i}", "repeats", v->repeats, "warmup", v->warmup);
    bool ok = pen_bench_options_add(members, &v->matrix, v->baseline, &st);
    if (!ok)
        pen_errors_add(errors, &st);
    else
        ok = pen_bench_spec_read(members, &s->desc.settings, &s->order, errors);
    pen_bench_options_errors(errors);
    json_decref(members);
    return ok;
}

static bool plan(struct study *s, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    if (!apply_settings(s, &st)) {
        pen_errors_add(errors, &st);
        return false;
    }
    if (!read_order(s, errors))
        return false;
    s->bench = pen_bench_of_spec(&s->order);
    s->bench.desc = &s->desc;
    if (choose_views(s, &st) &&
        pen_bench_spec_check(&s->order, &limits, &s->desc, s->bench.view_count, &st))
        return true;
    pen_errors_add(errors, &st);
    pen_bench_options_errors(errors);
    return false;
}

static void show_progress(void *user, int done, int total)
{
    pen_progress_show(user, (double)done / total, -1);
}

static bool measure(struct study *s, struct pen_status *st)
{
    struct pen_thread_pool *pool = pen_thread_pool_new(s->values->threads, st);
    if (!pool)
        return false;
    s->bench.pool = pool;
    s->bench.progress = show_progress;
    s->bench.user = &s->progress;
    pen_progress_begin(&s->progress, s->source.label, s->values->quiet);
    bool ok = pen_bench_run(&s->bench, &s->result, st);
    pen_progress_end(&s->progress);
    if (ok) {
        s->report = pen_bench_report_new(
            &s->bench, &s->result, pen_bench_spec_head(&s->order, &s->bench, &s->desc.settings));
        ok = s->report || pen_fail(st, PEN_NO_MEMORY, "out of memory");
    }
    pen_thread_pool_free(pool);
    return ok;
}

static bool write_form(const struct study *s, const char *path, const char *form,
                       struct pen_status *st)
{
    struct pen_buf text = {0};
    bool ok = pen_bench_report_write(s->report, form, &text, st) &&
              pen_file_write(path, text.data, text.bytes, st);
    pen_buf_release(&text);
    return ok;
}

static bool write_reports(const struct study *s, struct pen_status *st)
{
    const struct values *v = s->values;
    for (int i = 0; i < v->output.count; i++) {
        const char *output = v->output.item[i];
        const char *form = pen_output_report_format(output, v->format, st);
        if (!form || !write_form(s, output, form, st))
            return false;
    }
    return !v->csv || write_form(s, v->csv, "csv", st);
}

static bool uses_standard_output(const struct values *v)
{
    for (int i = 0; i < v->output.count; i++) {
        if (strcmp(v->output.item[i], "-") == 0)
            return true;
    }
    return false;
}

static void print_report(const struct study *s)
{
    struct pen_buf text = {0};
    if (s->values->json) {
        pen_report_line(json_incref(s->report));
    } else if (!s->values->quiet && !uses_standard_output(s->values)) {
        pen_bench_report_write_text(s->report, &text);
        fputs(text.data ? (const char *)text.data : "", stdout);
        pen_buf_release(&text);
    }
}

static void release(struct study *s)
{
    json_decref(s->report);
    pen_bench_result_release(&s->bench, &s->result);
    pen_bench_spec_release(&s->order);
    free(s->views);
    pen_arena_free(s->arena);
    pen_source_release(&s->source);
}

static int study(struct study *s, const char *name)
{
    bool json = s->values->json;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!check_values(s->values, &st))
        return pen_report_json(NULL, json, &st);
    if (!read_scene(s, name, &errors))
        return pen_report_errors_json(s->source.label, json, &errors);
    if (!plan(s, &errors))
        return pen_report_errors_json(NULL, json, &errors);
    if (!measure(s, &st) || !write_reports(s, &st))
        return pen_report_json(NULL, json, &st);
    print_report(s);
    return 0;
}

static int run(int argc, char **argv)
{
    struct values values = {.repeats = 3, .warmup = 1};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_bench, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct study s = {.values = &values};
    code = study(&s, parsed.args[0]);
    release(&s);
    return code;
}

const struct pen_command pen_command_bench = {
    .program = "penumbra",
    .name = "bench",
    .arguments = "SCENE",
    .summary = "Times a scene under several settings, without a daemon.",
    .details = "SCENE is a file, - for standard input, or builtin:NAME. What is timed is the "
               "building of the tree and the rendering of all views, in interleaved runs; a row's "
               "time is the median. Rows that differ in accelerator, threads or tile alone must "
               "give the same picture, bit for bit, or the command ends with code 7 and says "
               "where they part.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
