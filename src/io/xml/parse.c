/* SPDX-License-Identifier: MIT */
/* Receives expat's events and makes each part of the JSON values at once; there is no tree of the
 * XML.
 *
 * One call of XML_Parse gets the whole text, so expat does not copy it and scans a long token only
 * once. Memory is bounded: nesting, attributes of a tag, elements and errors have limits. The
 * memory of values is counted as for JSON. Document types are refused where they begin, so no
 * entity is ever defined. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "io/document.h"
#include "io/xml/build.h"
#include "io/xml/spellings.h"
#include "io/xml/utf16.h"
#include "io/xml/values.h"

/* The most elements besides pen_limits.objects. */
enum { OTHER_ELEMENTS = 100000 };

static size_t offset_now(const struct pen_xml_builder *b)
{
    return (size_t)XML_GetCurrentByteIndex(b->parser);
}

/* Checks the nesting limit. A vector of an object inside this element is two levels deeper than the
 * element's own object. */
static bool check_depth(struct pen_xml_builder *b, const struct pen_xml_frame *frame)
{
    if (frame->depth + 2 <= b->limits->nesting)
        return true;
    pen_xml_abort(b, frame->tag, PEN_INVALID,
                  "nested deeper than the %d levels allowed, of which a group takes 2",
                  b->limits->nesting);
    return false;
}

/* Finds the rows of a tag's attributes, and leaves out attributes about XML itself. */
static void find_attributes(const struct pen_xml_element *element, const char *const *pairs,
                            struct pen_xml_given_list *out)
{
    out->count = 0;
    for (; *pairs && out->count < PEN_XML_ATTRIBUTES_MAX; pairs += 2) {
        struct pen_xml_given *given = &out->item[out->count];
        if (pen_xml_is_about_xml(pairs[0]))
            continue;
        given->name = pairs[0];
        given->text = pairs[1];
        given->known = pen_xml_row_find(element, pairs[0], &given->row);
        out->count++;
    }
}

static void enter(struct pen_xml_builder *b, const struct pen_xml_element *element,
                  const char *const *pairs)
{
    const struct pen_xml_frame *up = b->count ? &b->frame[b->count - 1] : NULL;
    struct pen_xml_frame *frame = &b->frame[b->count];
    struct pen_xml_given_list attributes;
    *frame = (struct pen_xml_frame){.element = element, .tag = offset_now(b), .depth = 1};
    if (up)
        frame->depth = up->depth + 1 + (up->element->finish == PEN_XML_GROUP);
    if (!check_depth(b, frame))
        return;
    frame->object = up ? NULL : b->document;
    find_attributes(element, pairs, &attributes);
    json_t *value = pen_xml_build(b, up, frame, &attributes);
    if (!value) {
        b->skipped = 1;
        return;
    }
    b->count++;
    if (json_is_object(value) || json_is_array(value))
        pen_xml_require(b, pen_xml_record(b->xml, value, element, frame->tag));
    for (size_t i = 0; i < attributes.count && !b->stopped; i++)
        pen_xml_attribute_read(b, frame, &attributes, &attributes.item[i]);
    if (!b->stopped)
        pen_xml_finish(b, frame, &attributes);
}

static void enter_root(struct pen_xml_builder *b, const char *name, const char *const *attributes)
{
    static const char *const names[] = {"scene", NULL};
    if (pen_xml_same_name(name, names[0])) {
        enter(b, &pen_xml_scene, attributes);
        return;
    }
    pen_xml_abort(b, offset_now(b), PEN_INVALID,
                  "the document's element must be <scene>, found %s%s", pen_text_quote(name).text,
                  pen_text_nearest(name, names).text);
}

static void XMLCALL on_start(void *user, const XML_Char *name, const XML_Char **attributes)
{
    struct pen_xml_builder *b = user;
    if (b->stopped)
        return;
    if (b->open.count == PEN_XML_DEPTH_MAX) {
        pen_xml_abort(b, offset_now(b), PEN_INVALID, "nested deeper than the %d elements allowed",
                      (int)PEN_XML_DEPTH_MAX);
        return;
    }
    if (b->elements++ >= b->limits->objects && b->elements - b->limits->objects > OTHER_ELEMENTS) {
        pen_xml_abort(b, offset_now(b), PEN_INVALID,
                      "there are more elements than a scene may hold");
        return;
    }
    b->open.tag[b->open.count++] = offset_now(b);
    if (b->skipped > 0) {
        b->skipped++;
        return;
    }
    if (b->count == 0) {
        enter_root(b, name, (const char *const *)attributes);
        return;
    }
    const struct pen_xml_frame *up = &b->frame[b->count - 1];
    const struct pen_xml_element *element = pen_xml_child_find(up->element, name);
    if (element) {
        enter(b, element, (const char *const *)attributes);
        return;
    }
    pen_xml_unknown_element(b, up, name, offset_now(b));
    b->skipped = 1;
}

static void XMLCALL on_end(void *user, const XML_Char *name)
{
    struct pen_xml_builder *b = user;
    (void)name;
    if (b->stopped)
        return;
    b->open.count--;
    if (b->skipped > 0)
        b->skipped--;
    else
        b->count--;
}

static void XMLCALL on_text(void *user, const XML_Char *text, int bytes)
{
    enum { SHOWN = 48 };
    struct pen_xml_builder *b = user;
    struct pen_xml_frame *frame = b->count ? &b->frame[b->count - 1] : NULL;
    char word[SHOWN + 1];
    size_t start, end;
    if (b->stopped || b->skipped || !frame || frame->text_reported ||
        !pen_xml_token(text, (size_t)bytes, 0, &start, &end))
        return;
    frame->text_reported = true;
    snprintf(word, sizeof word, "%.*s", (int)(end - start), text + start);
    pen_xml_error(b, offset_now(b) + start, PEN_INVALID,
                  "<%s>: text is not allowed here, found %s; values stand in attributes",
                  pen_xml_tag_name(b->xml->text, b->xml->bytes, frame->tag).text,
                  pen_text_quote(word).text);
}

static void XMLCALL on_doctype(void *user, const XML_Char *name, const XML_Char *system_id,
                               const XML_Char *public_id, int has_internal_subset)
{
    static const char begin[] = "<!DOCTYPE";
    struct pen_xml_builder *b = user;
    size_t at = offset_now(b);
    (void)name, (void)system_id, (void)public_id, (void)has_internal_subset;
    while (at > 0 && (b->xml->bytes - at < sizeof begin ||
                      memcmp(b->xml->text + at, begin, sizeof begin - 1) != 0))
        at--;
    pen_xml_abort(
        b, at, PEN_SYNTAX,
        "document types (DTDs), and the entities that they declare, are not allowed; leave "
        "<!DOCTYPE …> out");
}

static void XMLCALL on_declaration(void *user, const XML_Char *version, const XML_Char *encoding,
                                   int standalone)
{
    struct pen_xml_builder *b = user;
    (void)standalone;
    if (version && strcmp(version, "1.0") != 0)
        pen_xml_abort(b, offset_now(b), PEN_SYNTAX, "XML version %s is not read: allowed is 1.0",
                      pen_text_quote(version).text);
    if (!encoding || strcasecmp(encoding, "UTF-8") == 0 || strcasecmp(encoding, "US-ASCII") == 0 ||
        (b->xml->converted && strncasecmp(encoding, "UTF-16", strlen("UTF-16")) == 0))
        return;
    pen_xml_abort(
        b, offset_now(b), PEN_SYNTAX,
        "the encoding %s is not read: save the document in UTF-8, in its subset US-ASCII, "
        "or in UTF-16 with a byte-order mark",
        pen_text_quote(encoding).text);
}

static void parse(struct pen_xml_builder *b)
{
    XML_SetUserData(b->parser, b);
    XML_SetElementHandler(b->parser, on_start, on_end);
    XML_SetCharacterDataHandler(b->parser, on_text);
    XML_SetStartDoctypeDeclHandler(b->parser, on_doctype);
    XML_SetXmlDeclHandler(b->parser, on_declaration);
    if (XML_Parse(b->parser, b->xml->text, (int)b->xml->bytes, 1) != XML_STATUS_ERROR || b->stopped)
        return;
    enum XML_Error code = XML_GetErrorCode(b->parser);
    if (code == XML_ERROR_ABORTED)
        return; /* pen_xml_error has stopped expat after too many errors */
    b->stopped = true;
    pen_xml_syntax_error(b->xml->text, b->xml->bytes, offset_now(b), (int)code, &b->open, b->st);
}

json_t *pen_xml_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                      struct pen_xml *xml, struct pen_status *st)
{
    struct pen_xml_builder b = {
        .limits = limits, .xml = xml, .st = st, .bytes_left = limits->parsed_bytes};
    *xml = (struct pen_xml){.text = text, .bytes = bytes, .image = SIZE_MAX};
    if (bytes > limits->body_bytes || bytes > INT_MAX / 2) { /* UTF-8 may take 3/2 of UTF-16 */
        pen_fail(st, PEN_TOO_LARGE, "the document has %zu bytes, at most %zu are allowed", bytes,
                 limits->body_bytes < INT_MAX / 2 ? limits->body_bytes : (size_t)INT_MAX / 2);
        return NULL;
    }
    if (pen_text_is_utf16(text, bytes)) {
        xml->converted = pen_utf16_to_utf8(text, bytes, &xml->bytes, st);
        xml->text = xml->converted;
        if (!xml->converted)
            return NULL;
    }
    if (!pen_xml_check_text(xml->text, xml->bytes, st))
        return NULL;
    b.parser = XML_ParserCreate("UTF-8");
    b.document = b.parser ? json_object() : NULL;
    if (b.document)
        parse(&b);
    else
        b.stopped = !pen_fail(st, PEN_NO_MEMORY, "the document does not fit into memory");
    if (!b.stopped)
        pen_xml_document_end(&b);
    XML_ParserFree(b.parser);
    pen_json_numbers_release(&b.numbers);
    json_decref(b.image);
    if (b.stopped) {
        json_decref(b.document);
        return NULL;
    }
    return xml->document = b.document, b.document;
}

void pen_xml_release(struct pen_xml *xml)
{
    free(xml->entries);
    free(xml->converted);
    *xml = (struct pen_xml){0};
}
