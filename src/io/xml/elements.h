/* SPDX-License-Identifier: MIT */
/* Scenes in XML: which elements and attributes there are, and what each becomes in the document
 * of the JSON format. That document is then read by the one reader there is, so both dialects mean
 * the same and are refused for the same reasons.
 *
 * An attribute is, in this order, a row of its element's own table, or the key of a pen_field
 * table with - for _. A table of fields is the reader's own: a key that is new there is an
 * attribute here at once. */
#ifndef PEN_IO_XML_ELEMENTS_H
#define PEN_IO_XML_ELEMENTS_H

#include "io/scene/reader.h"

/* How the text of an attribute becomes a value. */
enum pen_xml_shape {
    PEN_XML_HIDDEN, /* no attribute: keeps a key of the fields from being one */
    PEN_XML_TEXT,
    PEN_XML_NUMBER,
    PEN_XML_BOOL,
    PEN_XML_TRIPLE,
    PEN_XML_COLOUR, /* a triple of 0 to 255 */
    PEN_XML_FACTOR, /* one number or three */
    PEN_XML_MATRIX, /* twelve numbers */
    PEN_XML_PAIR,
    PEN_XML_POINTS, /* triples between semicolons */
    PEN_XML_AXIS    /* a word or a triple */
};

struct pen_xml_attribute {
    const char *name; /* NULL ends a table */
    enum pen_xml_shape shape;
    /* Where the value goes, in steps from the element's object: "view_plane/width". "" is the
     * element's value itself, and "@image" the picture's size, which belongs to `render`. */
    const char *path;
};

/* What an element becomes. */
enum pen_xml_build {
    PEN_XML_ROOT,
    PEN_XML_MEMBER_OBJECT, /* the member `key` of the parent's object, once */
    PEN_XML_MEMBER_LIST,   /* the same, a list */
    PEN_XML_MEMBER_VALUE,  /* the same, the value of its attribute */
    PEN_XML_ITEM,          /* an object in the parent's list, with the `type` that key says */
    PEN_XML_ITEM_MEMBER,   /* an object in the parent's list that has one member, an object */
    PEN_XML_ITEM_VALUE,    /* the same, the member being the value of the attribute */
    PEN_XML_NAMED,         /* a member of the parent's object, named by the attribute `name` */
    PEN_XML_LATER          /* known, not supported yet */
};

/* What is to be done when the attributes are read. */
enum pen_xml_finish { PEN_XML_AS_IT_IS, PEN_XML_TRIANGLE, PEN_XML_PLANE, PEN_XML_GROUP };

struct pen_xml_element {
    const char *name;
    enum pen_xml_build build;
    const char *key;
    const struct pen_xml_attribute *own; /* NULL: none */
    const struct pen_field *fields;      /* NULL: none */
    const struct pen_field *material;    /* fields of the member `material`; NULL: none */
    const struct pen_xml_element *const *children;
    enum pen_xml_finish finish;
};

extern const struct pen_xml_element pen_xml_scene;

/* An attribute that an element has: a row as above, made of a field if need be. */
enum { PEN_XML_NAME_BYTES = 32, PEN_XML_PATH_BYTES = 64, PEN_XML_NAMES_MAX = 64 };
struct pen_xml_row {
    char name[PEN_XML_NAME_BYTES];
    enum pen_xml_shape shape;
    char path[PEN_XML_PATH_BYTES];
};

/* All attributes of an element. Returns how many, at most PEN_XML_NAMES_MAX. */
size_t pen_xml_rows(const struct pen_xml_element *element,
                    struct pen_xml_row rows[PEN_XML_NAMES_MAX]);

/* The attribute of that name. Returns false if there is none. */
bool pen_xml_row_find(const struct pen_xml_element *element, const char *name,
                      struct pen_xml_row *row);

/* The child element of that name, or NULL. */
const struct pen_xml_element *pen_xml_child_find(const struct pen_xml_element *element,
                                                 const char *name);

#endif
