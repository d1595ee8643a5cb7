/* SPDX-License-Identifier: MIT */
/* Where the values of a document made from XML stand in it. Objects and lists remember the element
 * they were made from; everything finer is found by reading the element's tag again, which only
 * an error pays for. */
#ifndef PEN_IO_XML_POSITIONS_H
#define PEN_IO_XML_POSITIONS_H

#include "io/xml/elements.h"

struct pen_xml_entry {
    const json_t *json;
    const struct pen_xml_element *element;
    size_t offset; /* of the tag */
};

/* The XML behind a document. A null in the document is a value whose fault is reported already:
 * the reader says nothing more about it.
 * Owns: entries. `text` and `document` are borrowed. */
struct pen_xml {
    const char *text;
    size_t bytes;
    const json_t *document;
    struct pen_xml_entry *entries;
    size_t count, capacity;
    bool sorted;
    size_t image;             /* offset of the tag with the attribute `image`; SIZE_MAX: none */
    struct pen_errors faults; /* found while the document was made */
};

/* Remembers what a container was made from. Fails: returns false when out of memory. */
bool pen_xml_record(struct pen_xml *xml, const json_t *json, const struct pen_xml_element *element,
                    size_t offset);

/* The positions of the document's values, for the reader; `xml` must outlive it. */
struct pen_source_map pen_xml_source_map(struct pen_xml *xml);

/* Replaces the JSON Pointer of *st by line and column, and names them in its message. */
void pen_xml_locate(struct pen_xml *xml, struct pen_status *st);

/* The attribute of that name in the tag at `offset`. Returns false if it has none. */
struct pen_xml_span {
    size_t name, value, end; /* offsets: of the name, of the value, after it */
};
bool pen_xml_attribute_find(const struct pen_xml *xml, size_t tag, const char *name,
                            struct pen_xml_span *span);

#endif
