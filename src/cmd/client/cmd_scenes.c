/* SPDX-License-Identifier: MIT */
/* `penumbra scenes`: the scenes built into the program. */
#include <stdio.h>
#include <string.h>

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "jobs/jobs.h"

struct values {
    const char *output;
    bool json;
};

static const struct pen_option options[] = {
    PEN_OUTPUT_OPTION(struct values, "FILE",
                      "with NAME: write the scene to FILE instead of standard output"),
    PEN_JSON_OPTION(struct values, "print the list as {\"scenes\": […]}"),
    {0}};

static const char *text_of(const json_t *scene, const char *key)
{
    const char *text = json_string_value(json_object_get(scene, key));
    return text ? text : "";
}

static int print_list(const struct values *values)
{
    json_t *list = pen_jobs_scenes();
    if (values->json) {
        pen_report_line(list);
        return 0;
    }
    size_t i;
    const json_t *scene;
    int width = 0;
    json_array_foreach(json_object_get(list, "scenes"), i, scene)
    {
        int length = (int)strlen(text_of(scene, "name"));
        width = length > width ? length : width;
    }
    json_array_foreach(json_object_get(list, "scenes"), i, scene)
        printf("%-*s%s%s\n", width, text_of(scene, "name"), *text_of(scene, "title") ? "  " : "",
               text_of(scene, "title"));
    json_decref(list);
    return 0;
}

static int print_scene(const char *name, const struct values *values)
{
    char builtin[128];
    struct pen_source source;
    struct pen_status st;
    snprintf(builtin, sizeof builtin, "builtin:%s", name);
    bool ok = pen_source_read(&source, builtin, 0, &st) &&
              pen_file_write(values->output ? values->output : "-", source.text.data,
                             source.text.bytes, &st);
    pen_source_release(&source);
    return ok ? 0 : pen_report_json(NULL, values->json, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {0};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_scenes, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    return parsed.count ? print_scene(parsed.args[0], &values) : print_list(&values);
}

const struct pen_command pen_command_scenes = {
    .program = "penumbra",
    .name = "scenes",
    .arguments = "[NAME]",
    .summary = "Lists the built-in scenes, or prints one.",
    .details = "Every command that takes a scene takes builtin:NAME as well.",
    .options = options,
    .min_args = 0,
    .max_args = 1,
    .run = run,
};
