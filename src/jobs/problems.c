/* SPDX-License-Identifier: MIT */
/* Problem documents (RFC 9457). The type is urn:penumbra:problem:NAME with the name of the code; it
 * is an identifier, not an address. For invalid input, `errors` lists the places. A place is a JSON
 * Pointer into the document that was sent, or line and column of its text. Problems are written as
 * text, because a refused request should cost little. */
#include "jobs/jobs.h"

#include <stdio.h>
#include <string.h>

enum { MOSTLY_BYTES = 500 }; /* that a document has */

/* Returns true if the error is about the document that was sent. */
static bool is_about_input(const struct pen_status *st)
{
    return st->line > 0 || st->at[0] || st->code == PEN_INVALID || st->code == PEN_UNSUPPORTED;
}

/* Appends a character that a JSON string must escape. */
static void write_escaped(struct pen_buf *out, char c)
{
    static const char escaped[] = "\"\\\b\f\n\r\t", letters[] = "\"\\bfnrt";
    const char *found = strchr(escaped, c);
    if (found)
        pen_buf_printf(out, "\\%c", letters[found - escaped]);
    else
        pen_buf_printf(out, "\\u%04X", (unsigned)c);
}

/* Appends a string of valid UTF-8 as JSON. */
static void write_string(struct pen_buf *out, const char *text)
{
    pen_buf_puts(out, "\"");
    for (;;) {
        size_t plain = 0;
        while ((unsigned char)text[plain] >= ' ' && text[plain] != '"' && text[plain] != '\\')
            plain++;
        pen_buf_add(out, text, plain);
        text += plain;
        if (!*text)
            break;
        write_escaped(out, *text++);
    }
    pen_buf_puts(out, "\"");
}

/* Appends a member of an object. `before` is the text before its value, with the key. */
static void write_member(struct pen_buf *out, const char *before, const char *text)
{
    pen_buf_puts(out, before);
    write_string(out, text);
}

/* Appends the place of an error, as pen_problem_place. */
static void write_place(struct pen_buf *out, const struct pen_status *st)
{
    if (st->line > 0)
        pen_buf_printf(out, "{\"line\":%d,\"column\":%d", st->line, st->column);
    else
        write_member(out, "{\"pointer\":", st->at);
    write_member(out, ",\"detail\":", st->msg);
    pen_buf_puts(out, "}");
}

/* Appends a document without places, and its closing brace. */
static void write_problem(struct pen_buf *out, enum pen_code code, int http_status,
                          const char *detail)
{
    const int status = http_status ? http_status : pen_code_http(code);
    pen_buf_reserve(out, MOSTLY_BYTES);
    pen_buf_puts(out, "{\"type\":\"urn:penumbra:problem:");
    pen_buf_puts(out, pen_code_name(code));
    write_member(out, "\",\"title\":", pen_code_title(code));
    pen_buf_puts(out, ",\"status\":");
    pen_buf_number(out, (uint64_t)status);
    write_member(out, ",\"detail\":", detail);
}

/* Ends a document. */
static bool write_end(struct pen_buf *out, const char *request_id)
{
    if (request_id)
        write_member(out, ",\"request_id\":", request_id);
    return pen_buf_puts(out, "}\n");
}

bool pen_problem_write(struct pen_buf *out, const struct pen_status *st, int http_status,
                       const char *request_id)
{
    write_problem(out, st->code, http_status, st->msg);
    if (is_about_input(st)) {
        pen_buf_puts(out, ",\"errors\":[");
        write_place(out, st);
        pen_buf_puts(out, "]");
    }
    return write_end(out, request_id);
}

bool pen_problem_list_write(struct pen_buf *out, const struct pen_errors *errors,
                            const char *request_id)
{
    static const struct pen_status none = {.code = PEN_INTERNAL, .msg = "an error without a cause"};
    if (errors->count < 2)
        return pen_problem_write(out, errors->count ? &errors->item[0] : &none, 0, request_id);
    char detail[PEN_MSG_BYTES + 64];
    snprintf(detail, sizeof detail, "%zu errors, the first %zu are listed", errors->total,
             errors->count);
    if (errors->total == errors->count)
        snprintf(detail, sizeof detail, "%zu errors", errors->total);
    write_problem(out, errors->item[0].code, 0, detail);
    for (size_t i = 0; i < errors->count; i++) {
        pen_buf_puts(out, i ? "," : ",\"errors\":[");
        write_place(out, &errors->item[i]);
    }
    pen_buf_puts(out, "]");
    return write_end(out, request_id);
}

/* Parses the written text, and releases it. */
static json_t *read_back(struct pen_buf *text)
{
    const struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    json_t *json =
        text->failed ? NULL : pen_json_parse((const char *)text->data, text->bytes, &limits, &st);
    pen_buf_release(text);
    return json;
}

json_t *pen_problem_place(const struct pen_status *st)
{
    struct pen_buf text = {0};
    write_place(&text, st);
    return read_back(&text);
}

json_t *pen_problem(const struct pen_status *st)
{
    struct pen_buf text = {0};
    pen_problem_write(&text, st, 0, NULL);
    return read_back(&text);
}

json_t *pen_problem_list(const struct pen_errors *errors)
{
    struct pen_buf text = {0};
    pen_problem_list_write(&text, errors, NULL);
    return read_back(&text);
}
