/* SPDX-License-Identifier: MIT */
/* Errors in well-formed XML that is not a scene. */
#include <stdio.h>
#include <string.h>

#include "io/xml/build.h"

/* After this many errors the rest of a document is not parsed. */
enum { ERRORS_MAX = 1000 };

static void stop(struct pen_xml_builder *b)
{
    b->stopped = true;
    XML_StopParser(b->parser, XML_FALSE);
}

json_t *pen_xml_check_value(struct pen_xml_builder *b, json_t *value)
{
    if (!value && !b->stopped) {
        pen_fail(b->st, PEN_NO_MEMORY, "the document does not fit into memory");
        stop(b);
    }
    return value;
}

bool pen_xml_reserve(struct pen_xml_builder *b, size_t bytes)
{
    if (bytes > b->bytes_left && !b->stopped) {
        pen_fail(b->st, PEN_TOO_LARGE,
                 "the document's values take more than %zu bytes of memory, which is what is "
                 "allowed",
                 b->limits->parsed_bytes);
        stop(b);
    }
    b->bytes_left -= b->stopped ? 0 : bytes;
    return !b->stopped;
}

void pen_xml_require(struct pen_xml_builder *b, bool done)
{
    if (!done)
        pen_xml_check_value(b, NULL);
}

void pen_xml_error(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...)
{
    struct pen_status st = {.code = code};
    struct pen_errors *errors = &b->xml->errors;
    if (errors->count < PEN_ERRORS_MAX) {
        va_list args;
        va_start(args, format);
        pen_text_fail(&st, code, b->xml->text, offset, format, args);
        va_end(args);
    }
    pen_errors_add(errors, &st);
    if (errors->total == ERRORS_MAX &&
        !b->stopped) /* the scene reader still reads what was parsed */
        XML_StopParser(b->parser, XML_FALSE);
}

void pen_xml_abort(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...)
{
    va_list args;
    va_start(args, format);
    pen_text_fail(b->st, code, b->xml->text, offset, format, args);
    va_end(args);
    stop(b);
}

/* The offset of an attribute. It is the offset of a byte of its value if the value in the text has
 * no references such as &amp;. */
static size_t offset_of(const struct pen_xml_builder *b, const struct pen_xml_attribute_ref *ref)
{
    struct pen_xml_span span;
    if (!pen_xml_attribute_find(b->xml, ref->frame->tag, ref->name, &span))
        return ref->frame->tag;
    bool verbatim = ref->value && span.end - span.value == strlen(ref->value);
    return verbatim && ref->offset > 0 ? span.value + ref->offset : span.name;
}

void pen_xml_attribute_error(struct pen_xml_builder *b, const struct pen_xml_attribute_ref *ref,
                             const char *format, ...)
{
    char message[2 * PEN_MSG_BYTES];
    va_list args;
    va_start(args, format);
    if (vsnprintf(message, sizeof message, format, args) < 0)
        message[0] = '\0';
    va_end(args);
    pen_xml_error(b, offset_of(b, ref), PEN_INVALID, "attribute \"%s\" of <%s>: %s", ref->name,
                  pen_xml_frame_name(b, ref->frame).text, message);
}

void pen_xml_missing_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name)
{
    pen_xml_error(b, frame->tag, PEN_INVALID, "<%s>: missing attribute \"%s\"",
                  pen_xml_frame_name(b, frame).text, name);
}

/* Whether one of two paths leads to the other's value or to a part of it. */
static bool is_along(const char *a, const char *b)
{
    while (*a && *a == *b)
        a++, b++;
    return (!*a || !*b) && (*a == *b || *a == '/' || *b == '/');
}

/* Finds the first attribute of the frame's element, other than `except`, with a value on the path.
 */
static bool find_other(const struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                       const char *path, const char *except, struct pen_xml_span *span)
{
    size_t at = pen_xml_attributes_begin(b->xml, frame->tag);
    struct pen_text written;
    struct pen_xml_row row;
    while (pen_xml_attribute_next(b->xml, &at, span)) {
        if (pen_xml_attribute_row(b->xml, span, frame->element, &written, &row) &&
            is_along(row.path, path) && strcmp(written.text, except) != 0)
            return true;
    }
    return false;
}

void pen_xml_conflict(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                      const struct pen_xml_given *given, const char *path, const json_t *old)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = given->name};
    const char *text = b->xml->text;
    char around[2 * PEN_XML_PATH_BYTES];
    struct pen_xml_span span;
    int line, column;
    if (!pen_xml_wants_message(b)) {
        pen_xml_error(b, frame->tag, PEN_INVALID, "given twice");
        return;
    }
    bool found = find_other(b, frame, path, given->name, &span);
    if (!found && frame->element->build == PEN_XML_MEMBER_MORE) {
        snprintf(around, sizeof around, "%s/%s", frame->element->key, path);
        found = find_other(b, frame - 1, around, "", &span);
    }
    const struct pen_xml_entry *entry = found ? NULL : pen_xml_latest(b->xml, old, 0);
    pen_text_position(text, found ? span.name : entry ? entry->offset : frame->tag, &line, &column);
    if (!found) {
        pen_xml_attribute_error(b, &ref,
                                "has the same meaning as the element at line %d, column %d: keep "
                                "one of them",
                                line, column);
        return;
    }
    char name[PEN_XML_UNKNOWN_BYTES], value[PEN_TEXT_BYTES];
    snprintf(name, sizeof name, "%.*s", (int)(span.name_end - span.name), text + span.name);
    snprintf(value, sizeof value, "%.*s", (int)(span.end - span.value), text + span.value);
    pen_xml_attribute_error(b, &ref,
                            "says %s, but \"%s\" at line %d, column %d has the same meaning and "
                            "says %s: keep one of them",
                            pen_text_quote(given->text).text, name, line, column,
                            pen_text_quote(value).text);
}

void pen_xml_duplicate(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                       const json_t *old)
{
    char place[64] = "";
    int line, column;
    const struct pen_xml_entry *entry =
        pen_xml_wants_message(b) ? pen_xml_latest(b->xml, old, 0) : NULL;
    if (entry) {
        pen_text_position(b->xml->text, entry->offset, &line, &column);
        snprintf(place, sizeof place, " at line %d, column %d", line, column);
    }
    pen_xml_error(b, frame->tag, PEN_INVALID, "duplicate element <%s>: there is one already%s",
                  pen_xml_frame_name(b, frame).text, place);
}
