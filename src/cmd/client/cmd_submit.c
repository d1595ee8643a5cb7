/* SPDX-License-Identifier: MIT */
/* `penumbra submit`: makes a job from a scene and the command line, and sends it to a daemon.
 *
 *   document      options   sent as
 *   bare scene    none      the document as it is
 *   scene, JSON   some      a job around the document's own bytes: the daemon keeps the document as
 *                           written, and report() translates the places of its errors
 *   scene, XML    some      a job around the scene converted to JSON, since a job holds JSON only
 *   job           none      the document as it is
 *   job           some      the job, with the options in place of its own members */
#include <stdlib.h>
#include <string.h>

#include "cmd/client/audit_options.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/job_request.h"
#include "cmd/client/output.h"
#include "cmd/client/remote_job.h"
#include "cmd/client/setting_options.h"
#include "cmd/files.h"
#include "cmd/report.h"

struct values {
    struct pen_remote remote;
    struct pen_bench_values bench;
    struct pen_accuracy_values accuracy;
    struct pen_option_list set, view, label;
    const char *name, *idempotency_key, *output, *format, *kind;
    double audit;
    int audit_pixels, priority;
    bool has_priority;
    bool wait, quiet, json;
};

static const char *const kinds[] = {"render", "benchmark", "accuracy", "effects", NULL};

static const struct pen_option options[] = {
    PEN_SET_OPTION(struct values),
    {.name = "view",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, view),
     .value = "NAME",
     .help = "render only this view; may be repeated"},
    {.name = "kind",
     .kind = PEN_OPTION_CHOICE,
     .offset = offsetof(struct values, kind),
     .value = "render|benchmark|accuracy|effects",
     .choices = kinds,
     .help = "what the job does with the scene, render by default"},
    PEN_BENCH_OPTIONS(
        struct values, "of a study: ", "",
        "of a render: make the best picture of one view in this time; of a benchmark "),
    PEN_ACCURACY_OPTIONS(struct values, "of an accuracy study: "),
    PEN_AUDIT_OPTIONS(struct values, audit),
    {.name = "name",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, name),
     .value = "NAME",
     .help = "the job's name"},
    {.name = "label",
     .kind = PEN_OPTION_LIST,
     .offset = offsetof(struct values, label),
     .value = "KEY=VALUE",
     .help = "a label of the job; may be repeated"},
    {.name = "priority",
     .kind = PEN_OPTION_INT,
     .offset = offsetof(struct values, priority),
     .value = "N",
     .min = -100,
     .max = 100,
     .help = "jobs of larger priority run first; 0 by default"},
    {.name = "idempotency-key",
     .kind = PEN_OPTION_TEXT,
     .offset = offsetof(struct values, idempotency_key),
     .value = "KEY",
     .help = "a second submit of the same job with the same key within 24 hours gives the first "
             "job. By default the key is random, so a repeated request makes no second job"},
    {.name = "wait",
     .letter = 'w',
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, wait),
     .help = "wait until the job has ended"},
    PEN_OUTPUT_OPTION(struct values, "OUT",
                      "wait, then fetch the picture or the report to OUT, whose ending gives the "
                      "format: .png or .pfm, or .html, .json, .csv or .md"),
    PEN_FORMAT_OPTION(struct values, "png|png16|pfm|json|csv|md|html", pen_output_all_formats),
    PEN_QUIET_OPTION(struct values, "no progress bar"),
    PEN_JSON_OPTION(struct values, "print the job as a line of JSON instead of its id"),
    PEN_REMOTE_OPTIONS(struct values),
    {0}};

static bool fail_text(const char *option, struct pen_status *st)
{
    return pen_fail(st, PEN_USAGE, "--%s: must be text in UTF-8", option);
}

static bool add_labels(json_t *job, const struct pen_option_list *label, struct pen_status *st)
{
    json_t *labels = json_object_get(job, "labels");
    if (label->count == 0)
        return true;
    if (!json_is_object(labels)) {
        labels = json_object();
        json_object_set_new(job, "labels", labels);
    }
    for (int i = 0; i < label->count; i++) {
        const char *equals = strchr(label->item[i], '=');
        if (!equals || equals == label->item[i])
            return pen_fail(st, PEN_USAGE, "--label: found \"%s\", allowed is KEY=VALUE",
                            label->item[i]);
        if (json_object_setn_new(labels, label->item[i], (size_t)(equals - label->item[i]),
                                 json_string(equals + 1)) != 0)
            return fail_text("label", st);
    }
    return true;
}

/* Sets the members that the command line names, over those that the job has. */
static bool add_options(json_t *job, const struct values *values, struct pen_status *st)
{
    if (values->view.count > 0) {
        json_t *views = json_array();
        json_object_set_new(job, "views", views);
        for (int i = 0; i < values->view.count; i++) {
            if (json_array_append_new(views, json_string(values->view.item[i])) != 0)
                return fail_text("view", st);
        }
    }
    if (values->name && json_object_set_new(job, "name", json_string(values->name)) != 0)
        return fail_text("name", st);
    if (values->has_priority)
        json_object_set_new(job, "priority", json_integer(values->priority));
    if (values->kind)
        json_object_set_new(job, "kind", json_string(values->kind));
    if (values->audit >= 0)
        json_object_set_new(
            job, "audit",
            json_pack("{s:i, s:f}", "pixels", values->audit_pixels, "threshold", values->audit));
    return pen_bench_options_add(job, &values->bench, st) &&
           pen_accuracy_options_add(job, &values->accuracy, st) &&
           pen_set_options_add(job, &values->set, st) && add_labels(job, &values->label, st);
}

/* Makes the request for a document that is a job, or for a built-in scene, which has no text
 * here. */
static bool compose_job(const struct pen_source *source, json_t *job, const struct values *values,
                        struct pen_job_request *request, struct pen_status *st)
{
    json_t *before = json_deep_copy(job);
    bool ok = add_options(job, values, st);
    if (ok && source->text.bytes > 0 && json_equal(before, job))
        ok = pen_buf_add(&request->text, source->text.data, source->text.bytes);
    else if (ok)
        ok = pen_job_request_whole(request, job, st);
    json_decref(before);
    return ok;
}

static bool compose_scene(const struct pen_source *source, const json_t *document,
                          const struct values *values, struct pen_job_request *request,
                          struct pen_status *st)
{
    json_t *members = json_object();
    bool ok = add_options(members, values, st);
    if (ok && json_object_size(members) > 0)
        ok = pen_job_request_wrap(request, source, document, members, st);
    else if (ok)
        ok = pen_buf_add(&request->text, source->text.data, source->text.bytes) ||
             pen_fail(st, PEN_NO_MEMORY, "out of memory");
    request->xml = source->xml && !request->wrapped;
    json_decref(members);
    return ok;
}

/* Parses the document. A scene in XML is also checked as a whole here. After its conversion to
 * JSON, errors have no line and column. */
static json_t *read_document(const char *scene, struct pen_source *source,
                             struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    source->label = scene;
    if (strncmp(scene, "builtin:", 8) == 0)
        return json_pack("{s:s}", "scene", scene); /* the daemon has them too */
    bool read = pen_model_kind_of_name(scene) == PEN_MODEL_NONE
                    ? pen_source_read(source, scene, limits.body_bytes, &st)
                    : pen_fail(&st, PEN_UNSUPPORTED,
                               "known, not supported yet: a model on a daemon; `penumbra render` "
                               "renders it here");
    if (read && source->xml)
        return pen_source_json(source, &limits, errors);
    json_t *document =
        read ? pen_json_parse((const char *)source->text.data, source->text.bytes, &limits, &st)
             : NULL;
    if (!document)
        pen_errors_add(errors, &st);
    return document;
}

/* Checks that jobs of this kind (NULL: a render) have results in the output's format. */
static bool check_format(const struct values *values, const char *kind, struct pen_status *st)
{
    const bool study = kind && strcmp(kind, "render") != 0;
    return !values->output || (study ? pen_output_report_format(values->output, values->format, st)
                                     : pen_output_format(values->output, values->format, st));
}

static bool make_request(const char *scene, struct pen_source *source, const struct values *values,
                         struct pen_job_request *request, struct pen_errors *errors)
{
    struct pen_status st;
    json_t *document = read_document(scene, source, errors);
    if (!document)
        return false;
    const char *kind =
        values->kind ? values->kind : json_string_value(json_object_get(document, "kind"));
    bool ok = check_format(values, kind, &st) &&
              (json_object_get(document, "scene")
                   ? compose_job(source, document, values, request, &st)
                   : compose_scene(source, document, values, request, &st));
    json_decref(document);
    if (!ok)
        pen_errors_add(errors, &st);
    return ok;
}

static bool to_standard_output(const struct values *values)
{
    return values->output && strcmp(values->output, "-") == 0;
}

/* Prints the job's id. If the options ask for it, waits and fetches the result. */
static int follow(struct pen_client *client, const struct values *values, json_t *job)
{
    struct pen_errors errors = {0};
    char id[64];
    snprintf(id, sizeof id, "%s", pen_remote_text(job, "id"));
    bool waits = values->wait || values->output;
    if (!values->json)
        pen_report_say(to_standard_output(values) ? stderr : stdout, "%s", id);
    else if (!waits)
        pen_report_line(json_incref(job));
    fflush(stdout);
    if (!waits)
        return 0;
    const bool report = json_object_get(json_object_get(job, "links"), "report") != NULL;
    json_t *last;
    bool ok = pen_remote_wait(client, id, values->quiet, &last, &errors);
    if (values->json && last)
        pen_report_line(json_incref(last));
    json_decref(last);
    struct pen_fetch fetch = {.output = values->output, .format = values->format, .report = report};
    if (ok && values->output)
        ok = pen_remote_fetch(client, id, &fetch, &errors);
    return ok ? 0 : pen_report_errors("penumbra", NULL, &errors);
}

static int submit(struct pen_client *client, const struct values *values,
                  const struct pen_source *source, const struct pen_job_request *request)
{
    struct pen_errors errors = {0};
    json_t *job;
    if (!pen_job_request_post(client, request, &job, &errors))
        return pen_job_request_report(request, source, values->json, &errors);
    int code = follow(client, values, job);
    json_decref(job);
    return code;
}

/* Checks before the document is read that the output is possible and can be written. The output may
 * be of a render or, if the document may ask for one, of a study such as an explanation. */
static bool check_output(const struct values *values, struct pen_status *st)
{
    if (!values->output)
        return true;
    if (to_standard_output(values) && values->json)
        return pen_fail(st, PEN_USAGE, "-o -: standard output is also what --json uses");
    if (!check_format(values, values->kind, st) &&
        (values->kind || !check_format(values, "explain", st)))
        return false;
    return pen_file_check(values->output, st);
}

/* A daemon compares only rows. */
static bool check_baseline(const struct values *values, struct pen_status *st)
{
    const char *report;
    if (!pen_bench_options_report(&values->bench, &report, st))
        return false;
    return !report ||
           pen_fail(st, PEN_USAGE, "--baseline: found \"%s\", allowed is KEY=VALUE,…", report);
}

static int run(int argc, char **argv)
{
    struct values values = {.remote = PEN_REMOTE_DEFAULT,
                            .bench = PEN_BENCH_VALUES,
                            .accuracy.seeds = -1,
                            .audit = -1,
                            .audit_pixels = PEN_AUDIT_PIXELS};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_submit, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct pen_status st;
    struct pen_source source = {0};
    struct pen_job_request request = {.key = values.idempotency_key};
    struct pen_errors errors = {0};
    struct pen_client *client = NULL;
    values.remote.quiet = values.quiet;
    values.has_priority = pen_option_typed(&pen_command_submit, &parsed, "priority");
    if (!check_baseline(&values, &st) || !check_output(&values, &st))
        code = pen_report_json(NULL, values.json, &st);
    else if (!make_request(parsed.args[0], &source, &values, &request, &errors))
        code = pen_report_errors_json(errors.item[0].code == PEN_USAGE ? NULL : source.label,
                                      values.json, &errors);
    else if (!(client = pen_client_open(&values.remote, &st)))
        code = pen_report_json(NULL, values.json, &st);
    else
        code = submit(client, &values, &source, &request);
    pen_client_close(client);
    pen_buf_release(&request.text);
    pen_source_release(&source);
    return code;
}

const struct pen_command pen_command_submit = {
    .program = "penumbra",
    .name = "submit",
    .arguments = "SCENE",
    .summary = "Submits a scene or a job to a daemon and prints the job's id.",
    .details = "SCENE is a file, - for standard input, or builtin:NAME; a file may hold a bare "
               "scene, in JSON or XML, or a whole job. Once the id is printed, the job is on the "
               "daemon's disk. With -o - the id goes to standard error.",
    .options = options,
    .min_args = 1,
    .max_args = 1,
    .run = run,
};
