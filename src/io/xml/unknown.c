/* SPDX-License-Identifier: MIT */
/* Errors about unknown names in XML scenes. All of them are reported together; each name of an
 * element is reported once, with its lines. */
#include <stdio.h>
#include <string.h>

#include "base/utf8.h"
#include "io/xml/build.h"
#include "io/xml/spellings.h"

/* The names of an element's attributes or children: first the names that a message lists, then
 * their other names, for comparison with misspelt names only. */
enum { OTHERS_MAX = 64 };
struct names {
    size_t count, listed;
    const char *name[PEN_XML_NAMES_MAX + OTHERS_MAX + 1];
};

/* Adds the other names of the listed names. */
static void add_others(struct names *names, bool attributes)
{
    for (const struct pen_xml_spelling *s = pen_xml_spellings; s->ours; s++) {
        bool here = (s->kind != PEN_XML_OTHER_ELEMENT) == attributes;
        for (size_t i = 0; here && i < names->listed; i++) {
            if (strcmp(names->name[i], s->ours) != 0)
                continue;
            for (const char *const *other = s->other; *other; other++)
                if (names->count < sizeof names->name / sizeof names->name[0] - 1)
                    names->name[names->count++] = *other;
        }
    }
    names->name[names->count] = NULL;
}

/* "; did you mean NAME?", or "; the NOUNs here are a, b, c" if no name is near. */
static struct pen_text hint(const char *word, const char *noun, const struct names *names)
{
    struct pen_text out = pen_text_nearest(word, names->name);
    if (out.text[0])
        return out;
    if (names->listed == 0)
        snprintf(out.text, sizeof out.text, "; there are no %ss here", noun);
    else {
        size_t used = (size_t)snprintf(out.text, sizeof out.text, "; the %ss here are ", noun);
        for (size_t i = 0; i < names->listed; i++) {
            size_t length = strlen(names->name[i]) + (i ? 2 : 0);
            if (used + length + 5 > sizeof out.text) {
                strcat(out.text, ", …");
                break;
            }
            used += (size_t)sprintf(out.text + used, "%s%s", i ? ", " : "", names->name[i]);
        }
    }
    return out;
}

/* The line of an offset after those of earlier calls, so that all lines take one pass. */
static int line_of(struct pen_xml_builder *b, size_t offset)
{
    for (; b->line_at < offset; b->line_at++)
        b->line += b->xml->text[b->line_at] == '\n';
    return b->line + 1;
}

/* Adds the line to the error about the same name. Returns false if there is none. Then *unknown is
 * the name to store, without its text if that is too long. */
static bool is_again(struct pen_xml_builder *b, const struct pen_xml_frame *frame, const char *name,
                     bool attribute, size_t offset, struct pen_xml_unknown *unknown)
{
    const int line = line_of(b, offset);
    *unknown = (struct pen_xml_unknown){
        .element = frame->element, .attribute = attribute, .last_line = line};
    if (strlen(name) < sizeof unknown->name)
        strcpy(unknown->name, name);
    struct pen_xml_unknown *u = b->unknown, *end = u + b->unknown_count;
    while (u < end && (u->element != frame->element || u->attribute != attribute ||
                       strcmp(u->name, name) != 0))
        u++;
    if (u == end)
        return false;
    if (u->last_line != line) {
        if (u->line_count < PEN_XML_UNKNOWN_LINES)
            u->lines[u->line_count] = line;
        u->line_count++;
    }
    u->last_line = line;
    return true;
}

/* Reports a name that is not one of the names. */
static void report(struct pen_xml_builder *b, const struct pen_xml_frame *frame, const char *name,
                   size_t offset, struct pen_xml_unknown *unknown, struct names *names)
{
    const char *noun = unknown->attribute ? "attribute" : "element";
    struct pen_text tag = pen_xml_frame_name(b, frame), quoted = pen_text_quote(name);
    add_others(names, unknown->attribute);
    unknown->error = b->xml->errors.count;
    unknown->list_at =
        strlen("<>: unknown  ") + strlen(tag.text) + strlen(noun) + strlen(quoted.text);
    pen_xml_error(b, offset, PEN_INVALID, "<%s>: unknown %s %s%s", tag.text, noun, quoted.text,
                  hint(name, noun, names).text);
    if (unknown->name[0] && unknown->error < PEN_ERRORS_MAX)
        b->unknown[b->unknown_count++] = *unknown;
}

void pen_xml_unknown_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name)
{
    struct pen_xml_span span = {.name = frame->tag};
    struct pen_xml_unknown unknown;
    struct pen_xml_row rows[PEN_XML_NAMES_MAX];
    struct names names = {0};
    pen_xml_attribute_find(b->xml, frame->tag, name, &span);
    if (is_again(b, frame, name, true, span.name, &unknown))
        return;
    names.count = names.listed = pen_xml_rows(frame->element, rows);
    for (size_t i = 0; i < names.count; i++)
        names.name[i] = rows[i].name;
    report(b, frame, name, span.name, &unknown, &names);
}

void pen_xml_unknown_element(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                             const char *name, size_t tag)
{
    struct pen_xml_unknown unknown;
    struct names names = {0};
    if (is_again(b, up, name, false, tag, &unknown))
        return;
    const struct pen_xml_element *const *children = up->element->children;
    for (; children && *children && names.count < PEN_XML_NAMES_MAX; children++)
        if ((*children)->build != PEN_XML_UNSUPPORTED)
            names.name[names.count++] = (*children)->name;
    names.listed = names.count;
    report(b, up, name, tag, &unknown, &names);
}

void pen_xml_list_lines(struct pen_xml_builder *b)
{
    for (size_t i = 0; i < b->unknown_count; i++) {
        const struct pen_xml_unknown *u = &b->unknown[i];
        const int shown =
            u->line_count < PEN_XML_UNKNOWN_LINES ? u->line_count : PEN_XML_UNKNOWN_LINES;
        char *message = b->xml->errors.item[u->error].msg, text[2 * PEN_MSG_BYTES];
        if (shown == 0 || strlen(message) < u->list_at)
            continue;
        int used = snprintf(text, sizeof text, "%.*s (also on line%s", (int)u->list_at, message,
                            u->line_count > 1 ? "s" : "");
        for (int k = 0; k < shown; k++)
            used += snprintf(text + used, sizeof text - (size_t)used, "%s%d",
                             k == 0                                     ? " "
                             : k + 1 == shown && u->line_count == shown ? " and "
                                                                        : ", ",
                             u->lines[k]);
        if (u->line_count > shown)
            used += snprintf(text + used, sizeof text - (size_t)used, " and %d more",
                             u->line_count - shown);
        snprintf(text + used, sizeof text - (size_t)used, ")%s", message + u->list_at);
        pen_utf8_copy(message, PEN_MSG_BYTES, text);
    }
}
