/* SPDX-License-Identifier: MIT */
/* `penumbra convert`: a scene in either dialect, written anew as JSON. Only what is valid is
 * written, and it is the document that the renderer reads: both render to the same bytes. */
#include <string.h>

#include "cmd/client/commands.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "io/document.h"

struct values {
    const char *output;
    bool json;
};

static const struct pen_option options[] = {{.name = "output",
                                             .letter = 'o',
                                             .kind = PEN_OPTION_TEXT,
                                             .offset = offsetof(struct values, output),
                                             .value = "OUT",
                                             .help = "the same as OUT behind SCENE"},
                                            {.name = "json",
                                             .kind = PEN_OPTION_FLAG,
                                             .offset = offsetof(struct values, json),
                                             .help = "print errors as a problem document, too"},
                                            {0}};

static bool check_output(const char *output, struct pen_status *st)
{
    size_t length = strlen(output);
    if (length > 4 && strcmp(output + length - 4, ".xml") == 0)
        return pen_fail(st, PEN_USAGE,
                        "OUT: found \"%s\", but what is written is JSON; allowed is any name that "
                        "does not end in .xml",
                        output);
    return pen_file_check(output, st);
}

/* The text of a valid scene as JSON. Errors of the document go to `errors`. */
static bool convert(const struct pen_source *source, struct pen_buf *out, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_document document = {0};
    struct pen_scene_desc desc;
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    const char *text = source->text.data ? (const char *)source->text.data : "";
    bool made = arena != NULL || pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    made =
        made && pen_document_parse(text, source->text.bytes, source->xml, &limits, &document, &st);
    bool ok = made && pen_document_read(&document, &limits, arena, &desc, errors);
    if (ok && !pen_json_write(document.json, out))
        ok = made = pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    if (!made)
        pen_errors_add(errors, &st);
    pen_document_release(&document);
    pen_arena_free(arena);
    return ok;
}

static int carry_out(const char *name, const char *output, bool json)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_source source = {0};
    struct pen_buf out = {0};
    struct pen_errors errors = {0};
    struct pen_status st;
    int code = 0;
    if (!check_output(output, &st))
        code = pen_report_json(NULL, json, &st);
    else if (!pen_source_read(&source, name, limits.body_bytes, &st))
        code = pen_report_json(name, json, &st);
    else if (!convert(&source, &out, &errors))
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
    return carry_out(parsed.args[0], output, values.json);
}

const struct pen_command pen_command_convert = {
    .program = "penumbra",
    .name = "convert",
    .arguments = "SCENE OUT",
    .summary = "Writes a scene in XML or JSON anew as JSON.",
    .details = "SCENE is a file, - for standard input, or builtin:NAME; XML is known by the ending "
               ".xml or by its first character. OUT is written whole or not at all, and only if "
               "the scene is valid; - is standard output. It renders to the same bytes as SCENE.",
    .options = options,
    .min_args = 1,
    .max_args = 2,
    .run = run,
};
