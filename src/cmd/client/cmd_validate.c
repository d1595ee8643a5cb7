/* SPDX-License-Identifier: MIT */
/* `penumbra validate`: checks documents as the daemon does, in this process. */
#include <stdio.h>
#include <string.h>

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "jobs/jobs.h"

struct values {
    struct pen_model_options model;
    bool json, quiet;
};

static const struct pen_option options[] = {
    PEN_JSON_OPTION(struct values,
                    "print {\"valid\": true, \"warnings\": […], …} or a problem document, "
                    "one line for each file"),
    PEN_MODEL_OPTIONS(struct values),
    PEN_QUIET_OPTION(struct values, "print errors only"),
    {0}};

/* Prints the warnings about a valid document. */
static void print_warnings(const char *file, const json_t *answer)
{
    size_t i;
    const json_t *warning;
    json_array_foreach(json_object_get(answer, "warnings"), i, warning)
    {
        const char *pointer = json_string_value(json_object_get(warning, "pointer"));
        const char *detail = json_string_value(json_object_get(warning, "detail"));
        json_int_t line = json_integer_value(json_object_get(warning, "line"));
        json_int_t column = json_integer_value(json_object_get(warning, "column"));
        if (line > 0)
            pen_report_say(stderr, "penumbra: %s:%d:%d: warning: %s", file, (int)line, (int)column,
                           detail ? detail : "");
        else
            pen_report_say(stderr, "penumbra: %s: %s%swarning: %s", file, pointer ? pointer : "",
                           pointer && *pointer ? ": " : "", detail ? detail : "");
    }
}

static void print_valid(const char *file, const json_t *meshes)
{
    if (meshes)
        pen_report_say(stdout, "%s: valid, meshes: %lld, triangles: %lld", file,
                       (long long)json_integer_value(json_object_get(meshes, "count")),
                       (long long)json_integer_value(json_object_get(meshes, "triangles")));
    else
        pen_report_say(stdout, "%s: valid", file);
}

static int validate(const char *name, const struct values *values)
{
    struct pen_source source;
    struct pen_status st;
    if (!pen_source_read_scene(&source, name, &values->model, &st)) {
        pen_source_release(&source);
        return pen_report_json(name, values->json, &st);
    }
    struct pen_submission submission = {.body = (const char *)source.text.data,
                                        .bytes = source.text.bytes,
                                        .xml = source.xml,
                                        .models = &source.models};
    struct pen_errors errors = {0};
    json_t *answer = NULL;
    int code = 0;
    if (!pen_jobs_validate(NULL, &submission, &answer, &errors)) {
        code = pen_report_errors_json(source.label, values->json, &errors);
    } else {
        if (!values->quiet)
            print_warnings(source.label, answer);
        if (values->json)
            pen_report_line(json_incref(answer));
        else if (!values->quiet)
            print_valid(source.label, json_object_get(answer, "meshes"));
    }
    json_decref(answer);
    pen_source_release(&source);
    return code;
}

static int run(int argc, char **argv)
{
    struct values values = {0};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_validate, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    code = 0;
    for (int i = 0; i < parsed.count; i++) {
        int one = validate(parsed.args[i], &values);
        code = code ? code : one;
    }
    return code;
}

const struct pen_command pen_command_validate = {
    .program = "penumbra",
    .name = "validate",
    .arguments = "SCENE…",
    .summary = "Checks scenes or jobs, without a daemon.",
    .details = "SCENE is a file, - for standard input, or builtin:NAME. Up to 20 errors of a "
               "document are reported together, each with its place: a JSON Pointer, or line and "
               "column in XML and malformed JSON. Warnings do not change the exit code. Meshes and "
               "their triangles are counted.",
    .options = options,
    .min_args = 1,
    .max_args = -1,
    .run = run,
};
