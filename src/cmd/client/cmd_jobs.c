/* SPDX-License-Identifier: MIT */
/* The subcommands about jobs of a daemon: wait, fetch, stats, cancel, delete. */
#include <stdio.h>
#include <string.h>

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/output.h"
#include "cmd/client/remote_job.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "render/layers.h"

struct values {
    struct pen_remote remote;
    const char *output, *format, *view, *layer;
    bool quiet, json, report, stats;
};

/* Runs a subcommand for one job and reports errors. Returns the exit code. */
typedef int job_fn(struct pen_client *client, const char *id, const struct values *values);

/* Calls `each` for every argument. Returns the exit code of the first that failed. */
static int run_each(const struct pen_command *command, int argc, char **argv, job_fn *each)
{
    struct values values = {.remote = PEN_REMOTE_DEFAULT};
    struct pen_parsed parsed;
    int code = pen_command_begin(command, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    values.remote.quiet = values.quiet;
    struct pen_status st;
    struct pen_client *client = pen_client_open(&values.remote, &st);
    if (!client)
        return pen_report_json(NULL, values.json, &st);
    code = 0;
    for (int i = 0; i < parsed.count; i++) {
        int one = each(client, parsed.args[i], &values);
        fflush(stdout);
        code = code ? code : one;
    }
    pen_client_close(client);
    return code;
}

static void print_state(const json_t *job, const struct values *values)
{
    if (values->json)
        pen_report_line(json_deep_copy(job));
    else if (!values->quiet)
        pen_report_say(stdout, "%s %s", pen_remote_text(job, "id"), pen_remote_text(job, "state"));
}

static int wait_one(struct pen_client *client, const char *id, const struct values *values)
{
    struct pen_errors errors = {0};
    json_t *job;
    bool ok = pen_remote_wait(client, id, values->quiet, &job, &errors);
    if (job)
        print_state(job, values);
    bool printed = job != NULL; /* and with it the error of the job */
    json_decref(job);
    return ok ? 0 : pen_report_errors_json(NULL, values->json && !printed, &errors);
}

static int fetch_one(struct pen_client *client, const char *id, const struct values *values)
{
    struct pen_errors errors = {0};
    struct pen_status st;
    struct pen_fetch fetch = {.output = values->output,
                              .format = values->format,
                              .view = values->view,
                              .layer = values->layer,
                              .report = values->report};
    if (!values->output) {
        pen_fail(&st, PEN_USAGE, "missing -o OUT");
        return pen_report_json(NULL, values->json, &st);
    }
    if (pen_remote_fetch(client, id, &fetch, &errors))
        return 0;
    return pen_report_errors_json(NULL, values->json, &errors);
}

static int stats_one(struct pen_client *client, const char *id, const struct values *values)
{
    struct pen_errors errors = {0};
    struct pen_status st;
    struct pen_buf text = {0};
    json_t *stats;
    if (!pen_remote_job(client, "GET", id, "/stats", &stats, &errors))
        return pen_report_errors_json(NULL, values->json, &errors);
    int code = 0;
    if (values->json && !values->output)
        pen_report_line(json_incref(stats));
    else if (!pen_report_text(stats, &text, &st) ||
             !pen_file_write(values->output ? values->output : "-", text.data, text.bytes, &st))
        code = pen_report_json(NULL, values->json, &st);
    pen_buf_release(&text);
    json_decref(stats);
    return code;
}

static int cancel_one(struct pen_client *client, const char *id, const struct values *values)
{
    struct pen_errors errors = {0};
    json_t *job;
    if (!pen_remote_job(client, "POST", id, "/cancel", &job, &errors))
        return pen_report_errors_json(NULL, values->json, &errors);
    print_state(job, values);
    json_decref(job);
    return 0;
}

static int delete_one(struct pen_client *client, const char *id, const struct values *values)
{
    struct pen_errors errors = {0};
    json_t *none;
    bool ok =
        pen_remote_job(client, "DELETE", id, values->stats ? "?stats=true" : "", &none, &errors);
    json_decref(none);
    if (!ok)
        return pen_report_errors_json(NULL, values->json, &errors);
    if (values->json)
        pen_report_line(json_pack("{s:s, s:b}", "id", id, "deleted", 1));
    else if (!values->quiet)
        pen_report_say(stdout, "%s deleted", id);
    return 0;
}

static const struct pen_option state_options[] = {
    PEN_QUIET_OPTION(struct values, "no progress bar, no states"),
    PEN_JSON_OPTION(struct values, "print each job as a line of JSON"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

static const struct pen_option delete_options[] = {
    {.name = "stats",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, stats),
     .help = "remove the statistics too, which otherwise stay for five years; also of a job that "
             "was deleted before"},
    PEN_QUIET_OPTION(struct values, "print nothing"),
    PEN_JSON_OPTION(struct values, "print each job as a line of JSON"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

static const struct pen_option fetch_options[] = {
    PEN_OUTPUT_OPTION(
        struct values, "OUT",
        "the file; its ending gives the format: .png or .pfm of a picture, .html, .json, .csv "
        "or .md of a report"),
    {.name = "report",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, report),
     .help = "the report of a benchmark or a bill of effects, instead of a picture"},
    PEN_FORMAT_OPTION(struct values, "png|png16|pfm|json|csv|md|html", pen_output_all_formats),
    {.name = "view",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, view),
     .value = "NAME",
     .help = "which view of the job, the first by default"},
    {.name = "layer",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, layer),
     .value = "NAME",
     .choices = pen_layer_names,
     .help = "which layer of the job, beauty by default"},
    PEN_JSON_OPTION(struct values, "print errors as a problem document too"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

static const struct pen_option stats_options[] = {
    PEN_OUTPUT_OPTION(struct values, "FILE", "write to FILE instead of standard output"),
    PEN_JSON_OPTION(struct values, "print on one line"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

static int run_wait(int argc, char **argv)
{
    return run_each(&pen_command_wait, argc, argv, wait_one);
}

static int run_fetch(int argc, char **argv)
{
    return run_each(&pen_command_fetch, argc, argv, fetch_one);
}

static int run_stats(int argc, char **argv)
{
    return run_each(&pen_command_stats, argc, argv, stats_one);
}

static int run_cancel(int argc, char **argv)
{
    return run_each(&pen_command_cancel, argc, argv, cancel_one);
}

static int run_delete(int argc, char **argv)
{
    return run_each(&pen_command_delete, argc, argv, delete_one);
}

const struct pen_command pen_command_wait = {
    .program = "penumbra",
    .name = "wait",
    .arguments = "ID…",
    .summary = "Waits until jobs have ended.",
    .details = "Prints each job's id and last state. A progress bar is shown on a terminal.",
    .options = state_options,
    .min_args = 1,
    .max_args = -1,
    .run = run_wait,
};

const struct pen_command pen_command_fetch = {
    .program = "penumbra",
    .name = "fetch",
    .arguments = "ID -o OUT",
    .summary = "Fetches the picture of a job, or the report of a benchmark or a bill of effects.",
    .options = fetch_options,
    .min_args = 1,
    .max_args = 1,
    .run = run_fetch,
};

const struct pen_command pen_command_stats = {
    .program = "penumbra",
    .name = "stats",
    .arguments = "ID",
    .summary = "Prints the statistics of a job that has ended.",
    .options = stats_options,
    .min_args = 1,
    .max_args = 1,
    .run = run_stats,
};

const struct pen_command pen_command_cancel = {
    .program = "penumbra",
    .name = "cancel",
    .arguments = "ID…",
    .summary = "Cancels jobs; jobs that have ended do not change.",
    .options = state_options,
    .min_args = 1,
    .max_args = -1,
    .run = run_cancel,
};

const struct pen_command pen_command_delete = {
    .program = "penumbra",
    .name = "delete",
    .arguments = "ID…",
    .summary = "Removes jobs that have ended, with their results.",
    .options = delete_options,
    .min_args = 1,
    .max_args = -1,
    .run = run_delete,
};
