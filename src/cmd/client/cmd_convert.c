/* SPDX-License-Identifier: MIT */
/* `penumbra convert`: writes a scene in XML or JSON as JSON. Only a valid scene is written. The
 * renderer reads this same JSON when it is given XML, so both render to the same bytes. */
#include <string.h>

#include "base/utf8.h"
#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "io/document.h"

struct values {
    const char *output;
    struct pen_model_options model;
    bool json;
};

static const struct pen_option options[] = {
    PEN_OUTPUT_OPTION(struct values, "OUT", "the same as the argument OUT"),
    PEN_MODEL_OPTIONS(struct values),
    PEN_JSON_OPTION(struct values, "print errors as a problem document too"),
    {0}};

static bool check_output(const char *output, struct pen_status *st)
{
    if (pen_name_ends_in(output, ".xml"))
        return pen_fail(
            st, PEN_USAGE,
            "OUT: found \"%s\", but the output is JSON; allowed is any name that does not "
            "end in .xml",
            output);
    return pen_file_check(output, st);
}

/* Returns the path from OUT's folder to the scene's, which model files are relative to: "" or
 * "sub/folder"; NULL if the scene's folder is not in OUT's. Both are without links. */
static const char *path_between(const char *from, const char *to)
{
    const size_t length = strcmp(from, "/") == 0 ? 0 : strlen(from);
    const char *rest = to + length;
    if (strncmp(from, to, length) != 0 || (*rest != '/' && *rest != '\0'))
        return NULL;
    return rest + (*rest == '/');
}

/* Makes the names of model files, also in groups, relative to OUT's folder. */
static bool move_files(json_t *objects, const char *path, struct pen_status *st)
{
    bool ok = true;
    for (size_t i = 0; ok && i < json_array_size(objects); i++) {
        json_t *object = json_array_get(objects, i);
        const char *file = json_string_value(json_object_get(object, "file"));
        if (file && !path)
            ok = pen_fail(st, PEN_USAGE,
                          "OUT: the scene names the model file \"%.200s\", and a scene's models "
                          "are in its folder or below; write OUT to the folder of SCENE",
                          file);
        else if (file && json_object_set_new(object, "file", json_sprintf("%s/%s", path, file)))
            ok = pen_utf8_is_valid(path, strlen(path))
                     ? pen_fail(st, PEN_NO_MEMORY, "out of memory")
                     : pen_fail(st, PEN_INVALID, "the folder's name is not UTF-8; rename it");
        ok = ok && move_files(json_object_get(object, "objects"), path, st);
    }
    return ok;
}

static bool convert(struct pen_source *source, const char *output, struct pen_buf *out,
                    struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_models beside = {0};
    struct pen_status st;
    json_t *scene = pen_source_json(source, &limits, errors);
    if (!scene)
        return false;
    bool ok = pen_model_files_open(strcmp(output, "-") == 0 ? NULL : output, NULL, &beside, &st);
    const char *path = ok ? path_between(beside.self, source->models.self) : NULL;
    ok = ok && (strcmp(beside.self, source->models.self) == 0 ||
                move_files(json_object_get(scene, "objects"), path, &st));
    ok = ok && (pen_json_write(scene, out) || pen_fail(&st, PEN_NO_MEMORY, "out of memory"));
    if (!ok)
        pen_errors_add(errors, &st);
    pen_model_files_release(&beside);
    json_decref(scene);
    return ok;
}

static int convert_file(const char *name, const char *output, const struct values *values)
{
    const bool json = values->json;
    struct pen_source source = {0};
    struct pen_buf out = {0};
    struct pen_errors errors = {0};
    struct pen_status st;
    int code = 0;
    if (!check_output(output, &st))
        code = pen_report_json(NULL, json, &st);
    else if (!pen_source_read_scene(&source, name, &values->model, &st))
        code = pen_report_json(name, json, &st);
    else if (!convert(&source, output, &out, &errors))
        code = pen_report_errors_json(source.label, json, &errors);
    else if (!pen_file_write(output, out.data, out.bytes, &st))
        code = pen_report_json(NULL, json, &st);
    pen_buf_release(&out);
    pen_source_release(&source);
    return code;
}

static int run(int argc, char **argv)
{
    struct values values = {0};
    struct pen_parsed parsed;
    struct pen_status st;
    int code = pen_command_begin(&pen_command_convert, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    if (parsed.count == 2 && values.output) {
        pen_fail(&st, PEN_USAGE, "-o: OUT is given already, \"%s\"", parsed.args[1]);
        return pen_report_json(NULL, values.json, &st);
    }
    const char *output = parsed.count == 2 ? parsed.args[1] : values.output;
    if (!output) {
        pen_fail(&st, PEN_USAGE, "missing OUT: a name for the JSON, or - for standard output");
        return pen_report_json(NULL, values.json, &st);
    }
    return convert_file(parsed.args[0], output, &values);
}

const struct pen_command pen_command_convert = {
    .program = "penumbra",
    .name = "convert",
    .arguments = "SCENE OUT",
    .summary = "Writes a scene in XML or JSON as JSON.",
    .details =
        "SCENE is a file, - for standard input, or builtin:NAME; it is XML if its name ends "
        "in .xml, or if it ends in neither .xml nor .json and the text begins with <. OUT "
        "is written whole or not at all, and only if the scene is valid; - is standard "
        "output. OUT renders to the same bytes as SCENE. If SCENE is a model or names one, OUT "
        "is in its folder or in one above it, and - is read in the working folder.",
    .options = options,
    .min_args = 1,
    .max_args = 2,
    .run = run,
};
