/* SPDX-License-Identifier: MIT */
/* The positions of JSON values in their source text in XML. The element of each object and list is
 * recorded. Attributes and single numbers are found by scanning the element's tag again, only when
 * there is an error. */
#ifndef PEN_IO_XML_POSITIONS_H
#define PEN_IO_XML_POSITIONS_H

#include "io/xml/elements.h"

/* The source element of an object or list. */
struct pen_xml_entry {
    const json_t *json;
    const struct pen_xml_element *element;
    size_t offset; /* of the tag */
};

/* A parsed XML document. JSON null represents a value whose error has already been reported; the
 * scene reader reports nothing more about it.
 * Owns: entries and `converted`. `text` and `document` (the JSON values) are borrowed. */
struct pen_xml {
    const char *text; /* in UTF-8 */
    char *converted;  /* the same, if the document was in UTF-16; else NULL */
    size_t bytes;
    const json_t *document;
    struct pen_xml_entry *entries;
    size_t count, capacity;
    bool sorted;
    size_t image; /* offset of the <camera> with the attribute `image`; SIZE_MAX: none */
    struct pen_errors errors; /* found while parsing */
};

/* Records the source element, at `offset`, of a container.
 * Fails: returns false when out of memory. */
bool pen_xml_record(struct pen_xml *xml, const json_t *json, const struct pen_xml_element *element,
                    size_t offset);

/* The source element of an object or list, while the document is parsed; NULL if there is none at
 * the offset `from` or after it. */
const struct pen_xml_entry *pen_xml_latest(const struct pen_xml *xml, const json_t *json,
                                           size_t from);

/* The source map for the scene reader; *xml must outlive it. */
struct pen_source_map pen_xml_source_map(struct pen_xml *xml);

/* Replaces the JSON Pointer of *st by line and column, and names element and attribute in the
 * message. A status without a pointer is about the whole document. */
void pen_xml_locate(struct pen_xml *xml, struct pen_status *st);

/* Offsets of an attribute: begin and end of its name, begin and end of its value. */
struct pen_xml_span {
    size_t name, name_end, value, end;
};

/* The offset after the name in the tag at offset `tag`, where its attributes begin. */
size_t pen_xml_attributes_begin(const struct pen_xml *xml, size_t tag);

/* Finds the next attribute from *at on, and moves *at behind it. Returns false at the end. expat
 * has accepted the text up to this tag; in a later tag the search ends where the text is malformed.
 */
bool pen_xml_attribute_next(const struct pen_xml *xml, size_t *at, struct pen_xml_span *span);

/* Finds the attribute written as `name` in the tag at offset `tag`. Returns false if there is none.
 */
bool pen_xml_attribute_find(const struct pen_xml *xml, size_t tag, const char *name,
                            struct pen_xml_span *span);

/* The name of the attribute as written, and its row. Returns false if the element has no such
 * attribute. */
bool pen_xml_attribute_row(const struct pen_xml *xml, const struct pen_xml_span *span,
                           const struct pen_xml_element *element, struct pen_text *written,
                           struct pen_xml_row *row);

/* The name in the tag at offset `tag`, as written, for messages. */
struct pen_text pen_xml_tag_name(const char *text, size_t bytes, size_t tag);

#endif
