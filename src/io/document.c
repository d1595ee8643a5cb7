/* SPDX-License-Identifier: MIT */
/* Parsing and reading documents in JSON and XML. */
#include "io/document.h"

#include <stdlib.h>
#include <string.h>

#include "io/scene/reader.h"
#include "io/xml/parse.h"
#include "io/xml/utf16.h"

bool pen_text_is_xml(const char *text, size_t bytes)
{
    size_t i = bytes >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    while (i < bytes && (text[i] == ' ' || text[i] == '\t' || text[i] == '\n' || text[i] == '\r'))
        i++;
    return (i < bytes && text[i] == '<') || pen_text_is_utf16(text, bytes);
}

bool pen_document_parse(const char *text, size_t bytes, bool xml, const struct pen_limits *limits,
                        struct pen_document *out, struct pen_status *st)
{
    *out = (struct pen_document){0};
    if (!xml) {
        out->json = pen_json_parse(text, bytes, limits, st);
        return out->json != NULL;
    }
    out->xml = calloc(1, sizeof *out->xml);
    if (!out->xml)
        return pen_fail(st, PEN_NO_MEMORY, "the document does not fit into memory");
    out->json = pen_xml_parse(text, bytes, limits, out->xml, st);
    return out->json != NULL;
}

void pen_document_release(struct pen_document *document)
{
    json_decref(document->json);
    if (document->xml)
        pen_xml_release(document->xml);
    free(document->xml);
    *document = (struct pen_document){0};
}

static bool is_before(const struct pen_status *a, const struct pen_status *b)
{
    return a->line < b->line || (a->line == b->line && a->column < b->column);
}

/* Sorts by line and column. Errors at the same position stay in the order they were found. */
static void sort_errors(struct pen_errors *errors)
{
    for (size_t i = 1; i < errors->count; i++) {
        struct pen_status moved = errors->item[i];
        size_t k = i;
        for (; k > 0 && is_before(&moved, &errors->item[k - 1]); k--)
            errors->item[k] = errors->item[k - 1];
        errors->item[k] = moved;
    }
}

bool pen_document_read(const struct pen_document *document, const struct pen_limits *limits,
                       struct pen_arena *arena, struct pen_scene_desc *desc,
                       struct pen_errors *errors)
{
    const struct pen_xml *xml = document->xml;
    size_t before = errors->total;
    for (size_t i = 0; xml && i < xml->errors.count; i++)
        pen_errors_add(errors, &xml->errors.item[i]);
    if (xml)
        errors->total += xml->errors.total - xml->errors.count;
    struct pen_source_map source;
    if (xml)
        source = pen_xml_source_map(document->xml);
    pen_scene_read_from(document->json, xml ? &source : NULL, "", limits, arena, desc, errors);
    if (xml)
        sort_errors(errors);
    return errors->total == before;
}

void pen_document_locate(const struct pen_document *document, struct pen_status *st)
{
    if (document->xml)
        pen_xml_locate(document->xml, st);
}

void pen_text_locate(const char *text, size_t bytes, const struct pen_limits *limits,
                     struct pen_status *st)
{
    struct pen_document document = {0};
    struct pen_status ignored;
    if (pen_text_is_xml(text, bytes) &&
        pen_document_parse(text, bytes, true, limits, &document, &ignored))
        pen_document_locate(&document, st);
    pen_document_release(&document);
}

bool pen_document_load(const char *text, size_t bytes, bool xml, const struct pen_limits *limits,
                       struct pen_arena *arena, struct pen_scene_desc *desc,
                       struct pen_errors *errors)
{
    struct pen_document document;
    struct pen_status st;
    bool ok = pen_document_parse(text, bytes, xml, limits, &document, &st);
    if (ok)
        ok = pen_document_read(&document, limits, arena, desc, errors);
    else
        pen_errors_add(errors, &st);
    pen_document_release(&document);
    return ok;
}

bool pen_scene_load(const char *text, size_t bytes, const struct pen_limits *limits,
                    struct pen_arena *arena, struct pen_scene_desc *desc, struct pen_errors *errors)
{
    return pen_document_load(text, bytes, pen_text_is_xml(text, bytes), limits, arena, desc,
                             errors);
}
