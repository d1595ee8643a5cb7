/* SPDX-License-Identifier: MIT */
/* `penumbra bench`: a benchmark in this process or, with --server, as a job of a daemon. Runs and
 * report are the same. In both cases this process checks the command line and makes the table and
 * all formats. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cmd/client/bench_history.h"
#include "cmd/client/bench_remote.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/progress.h"
#include "cmd/client/report_output.h"
#include "cmd/client/report_source.h"
#include "cmd/client/scene_input.h"
#include "cmd/client/setting_options.h"
#include "cmd/report.h"
#include "report/report.h"
#include "study/comparison.h"

struct values {
    struct pen_bench_values bench;
    struct pen_remote remote;
    const char *format, *csv, *compare, *history;
    struct pen_option_list output, set, view;
    int threads;
    bool quiet, json;
    bool on_daemon; /* --server was given */
};

static const char *const compared[] = {"nothing", "counters", "time", NULL};

static const struct pen_option options[] = {
    PEN_BENCH_OPTIONS(struct values, "",
                      "; without a `=`: a report made earlier, as a JSON file, or the URL or id of "
                      "a job, with which the rows are compared",
                      ""),
    {.name = "compare",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, compare),
     .value = "nothing|counters|time",
     .choices = compared,
     .help = "with a report as --baseline: what makes the command end with code 7; counters, the "
             "default: other numbers of rays or tests, or other pictures; time: also a row that is "
             "slower"},
    {.name = "history",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, history),
     .value = "DIR",
     .help = "run nothing; show the reports in a folder, files .json, in the order of time, and "
             "where times have changed; SCENE, if given, is the name of the reports' scene"},
    PEN_SET_OPTION(struct values),
    {.name = "view",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, view),
     .value = "NAME",
     .help = "only this view of the scene, instead of all; may be repeated"},
    PEN_THREADS_OPTION(
        struct values,
        "size of the thread pool, of which the setting `threads` uses a part; 0, the "
        "default, is one per core"),
    {.name = "output",
     .letter = 'o',
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, output),
     .value = "OUT",
     .help = "the report's file; its ending, .json, .csv, .md or .html, gives the format; may be "
             "repeated"},
    PEN_FORMAT_OPTION(struct values, "json|csv|md|html", pen_report_formats),
    {.name = "csv",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, csv),
     .value = "FILE",
     .help = "write the rows to FILE too, as CSV"},
    PEN_QUIET_OPTION(struct values, "no progress bar and no table"),
    PEN_JSON_OPTION(struct values, "print the report as a line of JSON instead of a table"),
    PEN_SERVER_OPTION(struct values,
                      "run the benchmark on this daemon; PENUMBRA_URL alone does not do so, but "
                      "names the daemon of a --baseline that is a job"),
    PEN_ACCESS_OPTIONS(struct values),
    {0}};

/* All state of a benchmark. release() frees what has been allocated, at any stage. */
struct benchmark {
    const struct values *values;
    struct pen_remote remote;
    struct pen_client *client; /* NULL: runs in this process */
    struct pen_scene_input input;
    struct pen_bench_spec spec;
    struct pen_bench bench;
    struct pen_bench_result result;
    int *views;
    json_t *report, *earlier; /* earlier: the report to compare with; NULL: none */
    struct pen_progress progress;
};

static bool check_values(const struct values *v, struct pen_status *st)
{
    const struct pen_report_output output = PEN_REPORT_OUTPUT_OF(v);
    if (v->on_daemon && v->threads >= 0)
        return pen_fail(st, PEN_USAGE,
                        "--threads: a daemon has its own pool; --set threads=N uses a part of it");
    for (int i = 0; v->csv && i < v->output.count; i++)
        if (strcmp(v->output.item[i], v->csv) == 0)
            return pen_fail(st, PEN_USAGE, "--csv: is the same as -o, \"%s\"", v->csv);
    return pen_report_output_check(&output, st) && (!v->csv || pen_file_check(v->csv, st));
}

/* Opens the client if a daemon runs the benchmark. A warning that it prints is not printed again
 * for the baseline. */
static int open_daemon(struct benchmark *b)
{
    struct pen_status st;
    if (!b->values->on_daemon)
        return 0;
    b->client = pen_client_open(&b->remote, &st);
    b->remote.quiet = true;
    return b->client ? 0 : pen_report_json(NULL, b->values->json, &st);
}

/* Reads the report to compare with, if --baseline names one. */
static int read_earlier(struct benchmark *b)
{
    const struct values *v = b->values;
    struct pen_errors errors = {0};
    struct pen_status st;
    const char *name;
    if (!pen_bench_options_report(&v->bench, &name, &st))
        return pen_report_json(NULL, v->json, &st);
    if (!name && v->compare) {
        pen_fail(&st, PEN_USAGE, "--compare: needs a report as --baseline");
        return pen_report_json(NULL, v->json, &st);
    }
    return !name || pen_report_source_read(name, &b->remote, &b->earlier, &errors)
               ? 0
               : pen_report_errors_json(name, v->json, &errors);
}

static bool choose_views(struct benchmark *b, struct pen_status *st)
{
    const struct pen_option_list *wanted = &b->values->view;
    int count = wanted->count > 0 ? wanted->count : (int)b->input.desc.view_count;
    b->views = calloc((size_t)count, sizeof *b->views);
    if (!b->views)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    for (int i = 0; i < count; i++) {
        b->views[i] = i;
        if (wanted->count > 0)
            b->views[i] = pen_scene_input_view(&b->input, wanted->item[i], st);
        if (b->views[i] < 0)
            return false;
    }
    b->bench.views = b->views;
    b->bench.view_count = count;
    return true;
}

/* Makes the rows from the command line's options. */
static bool read_spec(struct benchmark *b, struct pen_errors *errors)
{
    const struct values *v = b->values;
    struct pen_status st;
    json_t *members = json_object();
    bool ok = pen_bench_options_add(members, &v->bench, &st);
    if (!ok)
        pen_errors_add(errors, &st);
    else
        ok = pen_bench_spec_read(members, &b->input.desc.settings, &b->spec, errors);
    pen_bench_options_errors(errors);
    json_decref(members);
    return ok;
}

static bool prepare(struct benchmark *b, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    if (!pen_set_options_apply(&b->values->set, &b->input.desc.settings, &st)) {
        pen_errors_add(errors, &st);
        return false;
    }
    if (!read_spec(b, errors))
        return false;
    b->bench = pen_bench_of_spec(&b->spec);
    b->bench.frame.desc = &b->input.desc;
    if (choose_views(b, &st) &&
        pen_bench_spec_check(&b->spec, &limits, &b->input.desc, b->bench.view_count, &st))
        return true;
    pen_errors_add(errors, &st);
    pen_bench_options_errors(errors);
    return false;
}

static void show_progress(void *user, int done, int total)
{
    pen_progress_show(user, (double)done / total, -1);
}

static bool run_here(struct benchmark *b, struct pen_status *st)
{
    struct pen_thread_pool *pool =
        pen_thread_pool_new(b->values->threads < 0 ? 0 : b->values->threads, st);
    if (!pool)
        return false;
    b->bench.frame.pool = pool;
    b->bench.frame.progress = show_progress;
    b->bench.frame.user = &b->progress;
    pen_progress_begin(&b->progress, b->input.source.label, b->values->quiet);
    bool ok = pen_bench_run(&b->bench, &b->result, st);
    pen_progress_end(&b->progress);
    if (ok) {
        b->report =
            pen_bench_report_new(&b->bench, &b->result,
                                 pen_bench_spec_head(&b->spec, &b->bench, &b->input.desc.settings));
        ok = b->report || pen_fail(st, PEN_NO_MEMORY, "out of memory");
    }
    pen_thread_pool_free(pool);
    return ok;
}

/* Makes the members of the job, without the scene. NULL after a failure. */
static json_t *job_members(const struct values *v, struct pen_status *st)
{
    json_t *job = json_pack("{s:s}", "kind", "benchmark"), *views = json_array();
    bool ok = (job && views) || pen_fail(st, PEN_NO_MEMORY, "out of memory");
    for (int i = 0; ok && i < v->view.count; i++)
        ok = json_array_append_new(views, json_string(v->view.item[i])) == 0 ||
             pen_fail(st, PEN_USAGE, "--view: must be text in UTF-8");
    if (ok && v->view.count > 0)
        json_object_set(job, "views", views);
    ok = ok && pen_bench_options_add(job, &v->bench, st) && pen_set_options_add(job, &v->set, st);
    json_decref(views);
    if (ok)
        return job;
    json_decref(job);
    return NULL;
}

/* Makes the report. Returns the exit code. */
static int measure(struct benchmark *b)
{
    const struct values *v = b->values;
    struct pen_status st;
    if (!b->client)
        return run_here(b, &st) ? 0 : pen_report_json(NULL, v->json, &st);
    json_t *members = job_members(v, &st);
    if (!members)
        return pen_report_json(NULL, v->json, &st);
    const struct pen_bench_remote remote = {.client = b->client,
                                            .source = &b->input.source,
                                            .members = members,
                                            .quiet = v->quiet,
                                            .json = v->json};
    const int code = pen_bench_remote_run(&remote, &b->report);
    json_decref(members);
    return code;
}

/* Adds the comparison with the earlier report to the report. */
static bool compare(struct benchmark *b, struct pen_status *st)
{
    if (!b->earlier)
        return true;
    json_t *comparison = pen_comparison_new(b->earlier, b->report, st);
    return comparison && (json_object_set_new(b->report, "comparison", comparison) == 0 ||
                          pen_fail(st, PEN_NO_MEMORY, "out of memory"));
}

/* Checks that the comparison is as --compare asks for. */
static bool judge(const struct benchmark *b, struct pen_status *st)
{
    const char *compare = b->values->compare ? b->values->compare : "counters";
    const json_t *comparison = json_object_get(b->report, "comparison");
    return !comparison || strcmp(compare, "nothing") == 0 ||
           pen_comparison_judge(comparison, strcmp(compare, "time") == 0, st);
}

static bool write_report(const struct benchmark *b, struct pen_status *st)
{
    const struct pen_report_output output = PEN_REPORT_OUTPUT_OF(b->values);
    const char *csv = b->values->csv;
    return (!csv || pen_report_output_file(csv, "csv", b->report, NULL, st)) &&
           pen_report_output_write(&output, b->report, NULL, st);
}

static void release(struct benchmark *b)
{
    json_decref(b->report);
    json_decref(b->earlier);
    pen_bench_result_release(&b->bench, &b->result);
    pen_bench_spec_release(&b->spec);
    free(b->views);
    pen_scene_input_release(&b->input);
    pen_client_close(b->client);
}

static int benchmark(struct benchmark *b, const char *name)
{
    bool json = b->values->json;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!check_values(b->values, &st))
        return pen_report_json(NULL, json, &st);
    int code = open_daemon(b);
    if (code == 0)
        code = read_earlier(b);
    if (code != 0)
        return code;
    if (!pen_scene_input_read(&b->input, name, NULL, &errors))
        return pen_report_errors_json(b->input.source.label, json, &errors);
    if (!prepare(b, &errors))
        return pen_report_errors_json(NULL, json, &errors);
    if ((code = measure(b)) != 0)
        return code;
    if (!compare(b, &st) || !write_report(b, &st))
        return pen_report_json(NULL, json, &st);
    if (judge(b, &st))
        return 0;
    return b->values->quiet ? pen_code_exit(st.code) : pen_report("penumbra", NULL, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {.bench = PEN_BENCH_VALUES, .remote = PEN_REMOTE_DEFAULT, .threads = -1};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_bench, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    if (values.history)
        return pen_bench_history(&(struct pen_bench_history){
            .folder = values.history,
            .scene = parsed.count > 0 ? parsed.args[0] : NULL,
            .output = PEN_REPORT_OUTPUT_OF(&values),
            .least_effect = values.bench.least_effect >= 0 ? values.bench.least_effect : 0.02});
    if (parsed.count == 0) {
        struct pen_status st;
        pen_fail(&st, PEN_USAGE, "missing argument, usage: penumbra bench SCENE");
        return pen_report_json(NULL, values.json, &st);
    }
    values.on_daemon = pen_option_typed(&pen_command_bench, &parsed, "server");
    values.remote.quiet = values.quiet;
    struct benchmark b = {.values = &values, .remote = values.remote};
    code = benchmark(&b, parsed.args[0]);
    release(&b);
    return code;
}

const struct pen_command pen_command_bench = {
    .program = "penumbra",
    .name = "bench",
    .arguments = "SCENE",
    .summary = "Times a scene under several settings, here or on a daemon.",
    .details =
        "SCENE is a file, - for standard input, or builtin:NAME. A run builds the tree and "
        "renders all views; the runs of the rows are interleaved, and a row's time is the "
        "median of its runs. Rows that differ only in accelerator, threads or tile must "
        "give the same picture, bit for bit; otherwise the command ends with code 7 and "
        "names the first pixel that differs. With --server the runs are a job of kind "
        "benchmark; the report has the daemon's host, and the job goes on if this command is "
        "ended.",
    .options = options,
    .min_args = 0,
    .max_args = 1,
    .daemon_optional = true,
    .run = run,
};
