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

/* The offset of an attribute, or of a byte of its value if the value in the text has no references
 * such as &amp;. */
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
                  ref->frame->element->name, message);
}

void pen_xml_missing_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name)
{
    pen_xml_error(b, frame->tag, PEN_INVALID, "<%s>: missing attribute \"%s\"",
                  frame->element->name, name);
}

/* "; did you mean NAME?", or "; the NOUNs here are a, b, c" if no name is near. */
static struct pen_text hint(const char *word, const char *noun, const char *const *names)
{
    struct pen_text out = pen_text_nearest(word, names);
    if (out.text[0])
        return out;
    if (!*names)
        snprintf(out.text, sizeof out.text, "; there are no %ss here", noun);
    else {
        size_t used = (size_t)snprintf(out.text, sizeof out.text, "; the %ss here are ", noun);
        for (size_t i = 0; names[i]; i++) {
            size_t length = strlen(names[i]) + (i ? 2 : 0);
            if (used + length + 5 > sizeof out.text) {
                strcat(out.text, ", …");
                break;
            }
            used += (size_t)sprintf(out.text + used, "%s%s", i ? ", " : "", names[i]);
        }
    }
    return out;
}

void pen_xml_unknown_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name)
{
    struct pen_xml_row rows[PEN_XML_NAMES_MAX];
    const char *names[PEN_XML_NAMES_MAX + 1] = {NULL};
    size_t count = pen_xml_rows(frame->element, rows);
    for (size_t i = 0; i < count; i++)
        names[i] = rows[i].name;
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = name};
    pen_xml_error(b, offset_of(b, &ref), PEN_INVALID, "<%s>: unknown attribute %s%s",
                  frame->element->name, pen_text_quote(name).text,
                  hint(name, "attribute", names).text);
}

void pen_xml_unknown_element(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                             const char *name, size_t tag)
{
    const char *names[PEN_XML_NAMES_MAX + 1] = {NULL};
    const struct pen_xml_element *const *children = up->element->children;
    size_t count = 0;
    for (; children && *children && count < PEN_XML_NAMES_MAX; children++)
        if ((*children)->build != PEN_XML_UNSUPPORTED)
            names[count++] = (*children)->name;
    pen_xml_error(b, tag, PEN_INVALID, "<%s>: unknown element %s%s", up->element->name,
                  pen_text_quote(name).text, hint(name, "element", names).text);
}
