/* SPDX-License-Identifier: MIT */
/* Where the values of a document made from XML stand in it. Objects and lists remember the element
 * they were made from; everything finer is found by reading the element's tag again, which only
 * an error pays for. */
#ifndef PEN_IO_XML_PLACES_H
#define PEN_IO_XML_PLACES_H

#include "io/xml/xml.h"

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
bool pen_xml_remember(struct pen_xml *xml, const json_t *json,
                      const struct pen_xml_element *element, size_t offset);

/* Whether the value at a place, or one around it, is reported already. */
bool pen_xml_is_reported(struct pen_xml *xml, const struct pen_place *at);

/* Fills *st with the message, after the names of attribute and element, and its line and column. */
void pen_xml_fail(struct pen_xml *xml, const struct pen_place *at, enum pen_code code,
                  const char *message, struct pen_status *st);

/* What stands there, as it is written. */
struct pen_text pen_xml_found(struct pen_xml *xml, const struct pen_place *at, const json_t *value);

/* The quoted name of the attribute, the first if there are several, that `key` of the object at
 * `up` comes from. */
struct pen_text pen_xml_name(struct pen_xml *xml, const struct pen_place *up, const char *key);

/* "line 3, column 7" */
void pen_xml_place_text(struct pen_xml *xml, const struct pen_place *at, char *out, size_t bytes);

/* Replaces the JSON Pointer of *st by line and column, and names them in its message. */
void pen_xml_locate(struct pen_xml *xml, struct pen_status *st);

/* The attribute of that name in the tag at `offset`. Returns false if it has none. */
struct pen_xml_span {
    size_t name, value, end; /* offsets: of the name, of the value, after it */
};
bool pen_xml_attribute_find(const struct pen_xml *xml, size_t tag, const char *name,
                            struct pen_xml_span *span);

#endif
