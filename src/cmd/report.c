/* SPDX-License-Identifier: MIT */
#include "cmd/report.h"

#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/message.h"
#include "jobs/jobs.h"

/* A line has at most a pointer, a message and a path. */
enum { LINE_BYTES = PEN_AT_BYTES + PEN_MSG_BYTES + 4096 };

int pen_report(const char *program, const char *file, const struct pen_status *st)
{
    char line[LINE_BYTES];
    pen_status_describe(st, file, line, sizeof line);
    fprintf(stderr, "%s: %s\n", program, line);
    return pen_code_exit(st->code);
}

int pen_report_errors(const char *program, const char *file, const struct pen_errors *errors)
{
    if (errors->count == 0)
        return pen_code_exit(PEN_INTERNAL);
    for (size_t i = 0; i < errors->count; i++)
        pen_report(program, file, &errors->item[i]);
    const size_t more = errors->total - errors->count;
    if (more > 0)
        pen_report_say(stderr, "%s: %s%s%zu more error%s", program, file ? file : "",
                       file ? ": " : "", more, more == 1 ? "" : "s");
    return pen_code_exit(errors->item[0].code);
}

/* Appends the text in its safe form. Characters of `kept` stay as they are. */
static void add_shown(struct pen_buf *out, const char *text, const char *kept)
{
    for (size_t left = strlen(text); left > 0;) {
        char shown[PEN_UTF8_SHOWN_BYTES] = {*text};
        size_t taken = 1;
        if (!strchr(kept, *text))
            taken = pen_utf8_show_char(text, left, shown);
        pen_buf_puts(out, shown);
        text += taken, left -= taken;
    }
}

/* Prints the text in one call, so that lines of several processes do not mix. */
static void print_shown(FILE *out, const char *text, const char *kept, const char *end)
{
    struct pen_buf shown = {0};
    add_shown(&shown, text, kept);
    pen_buf_puts(&shown, end);
    if (shown.failed)
        fputs("out of memory\n", out);
    else
        fwrite(shown.data, 1, shown.bytes, out);
    pen_buf_release(&shown);
}

void pen_report_say(FILE *out, const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    if (vasprintf(&text, format, args) < 0)
        text = NULL;
    va_end(args);
    print_shown(out, text ? text : "out of memory", "", "\n");
    free(text);
}

void pen_report_show(FILE *out, const char *text)
{
    print_shown(out, text, "\n\t", "");
}

enum { DIGITS = 15, EXACT_DIGITS = 17 };

static void print_line(json_t *value, size_t digits)
{
    char *text = value ? json_dumps(value, JSON_COMPACT | JSON_REAL_PRECISION(digits)) : NULL;
    /* In JSON, escapes of unsafe characters mean the same characters. */
    pen_report_say(stdout, "%s", text ? text : "{\"type\":\"no-memory\"}");
    free(text);
    json_decref(value);
}

void pen_report_line(json_t *value)
{
    print_line(value, DIGITS);
}

void pen_report_exact(json_t *value)
{
    print_line(value, EXACT_DIGITS);
}

bool pen_report_text(const json_t *value, struct pen_buf *out, struct pen_status *st)
{
    char *text = value ? json_dumps(value, JSON_INDENT(2) | JSON_REAL_PRECISION(DIGITS)) : NULL;
    bool ok = text && pen_buf_puts(out, text) && pen_buf_puts(out, "\n");
    free(text);
    return ok || pen_fail(st, PEN_NO_MEMORY, "out of memory");
}

int pen_report_json(const char *file, bool json, const struct pen_status *st)
{
    if (json)
        pen_report_line(pen_problem(st));
    return pen_report("penumbra", file, st);
}

int pen_report_errors_json(const char *file, bool json, const struct pen_errors *errors)
{
    if (json)
        pen_report_line(pen_problem_list(errors));
    return pen_report_errors("penumbra", file, errors);
}

void pen_report_version(const char *program)
{
    printf("%s %s\n", program, PEN_VERSION);
}

void pen_report_exit_codes(FILE *out)
{
    static const struct {
        enum pen_code code;
        const char *meaning;
    } rows[] = {
        {PEN_OK, "done"},
        {PEN_USAGE, "wrong command line or configuration"},
        {PEN_INVALID, "wrong input: malformed, invalid, too large, not supported yet"},
        {PEN_NOT_FOUND, "not found, or not in a state that allows this"},
        {PEN_NETWORK, "daemon out of reach, not ready or busy"},
        {PEN_RENDER_FAILED, "the job failed or was cancelled"},
        {PEN_DIFFERENT, "compared pictures or counts differ by more than allowed"},
        {PEN_IO, "a file or the store cannot be read or written"},
        {PEN_NO_MEMORY, "out of memory"},
        {PEN_TIMEOUT, "took longer than allowed"},
        {PEN_FORBIDDEN, "not permitted"},
        {PEN_INTERNAL, "a bug in Penumbra"},
    };
    fputs("Exit codes:\n", out);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        fprintf(out, "  %2d  %s\n", pen_code_exit(rows[i].code), rows[i].meaning);
}

int pen_report_finish(const char *program, int code)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return code;
    fprintf(stderr, "%s: cannot write to standard output: %s\n", program, strerror(errno));
    return code ? code : pen_code_exit(PEN_IO);
}
