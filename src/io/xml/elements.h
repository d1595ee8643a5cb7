/* SPDX-License-Identifier: MIT */
/* The elements and attributes of scenes in XML, and the JSON value of each. The scene reader then
 * reads those values, so both formats mean the same and are refused for the same reasons.
 *
 * The attributes of an element are the rows of its own table, and the keys of the reader's tables
 * of fields (io/scene/tables.h) with - for _. So a key that is added there is an attribute here. If
 * both have an attribute, the element's own row counts. Other names of elements and attributes are
 * in io/xml/spellings.h. */
#ifndef PEN_IO_XML_ELEMENTS_H
#define PEN_IO_XML_ELEMENTS_H

#include "io/scene/reader.h"

/* The conversion of an attribute's text to a value. */
enum pen_xml_shape {
    PEN_XML_HIDDEN, /* not an attribute: hides a key of the fields */
    PEN_XML_TEXT,
    PEN_XML_NUMBER,
    PEN_XML_BOOL,
    PEN_XML_TRIPLE,
    PEN_XML_COLOUR, /* three numbers from 0 to 255 */
    PEN_XML_FACTOR, /* one number or three */
    PEN_XML_MATRIX, /* twelve numbers */
    PEN_XML_PAIR,
    PEN_XML_POINTS, /* triples separated by semicolons */
    PEN_XML_AXIS    /* a word or a triple */
};

struct pen_xml_attribute {
    const char *name; /* NULL ends a table */
    enum pen_xml_shape shape;
    /* The path of the value from the element's object: "view_plane/width". "" is the element's
     * value itself, "@factor" a factor of that, "@name" the key of a PEN_XML_NAMED element.
     * "@image" is the picture's size, which becomes part of `render`. */
    const char *path;
};

/* The JSON value of an element. */
enum pen_xml_build {
    PEN_XML_ROOT,
    PEN_XML_MEMBER_OBJECT, /* an object at the path `key` from the parent's object, once */
    PEN_XML_MEMBER_MORE,   /* the same, but the parent's attributes may also have members of it */
    PEN_XML_MEMBER_LIST,   /* a list, the member `key` of the parent's object, once */
    PEN_XML_MEMBER_VALUE,  /* the same, as the value of its only attribute */
    PEN_XML_ITEM,          /* an object in the parent's list; `key` is its `type`, NULL: none */
    PEN_XML_ITEM_MEMBER,   /* an object in the parent's list that has one member, an object */
    PEN_XML_ITEM_VALUE,    /* the same, with the value of its only attribute as the member */
    PEN_XML_NAMED,         /* a member of the parent's object, named by the attribute `name` */
    PEN_XML_UNSUPPORTED    /* known, not supported yet */
};

/* The work of pen_xml_finish after the attributes of an element have been read. */
enum pen_xml_finish {
    PEN_XML_FINISH_NONE,
    PEN_XML_TRIANGLE,
    PEN_XML_POLYGON,
    PEN_XML_PLANE,
    PEN_XML_GROUP,
    PEN_XML_LIGHT
};

struct pen_xml_element {
    const char *name;
    enum pen_xml_build build;
    const char *key;                     /* see enum pen_xml_build; the feature, if unsupported */
    const struct pen_xml_attribute *own; /* NULL: none */
    const struct pen_field *fields;      /* NULL: none */
    const struct pen_field *material;    /* fields of the member `material`; NULL: none */
    const struct pen_xml_element *const *children;
    enum pen_xml_finish finish;
    const char *list; /* for a PEN_XML_ITEM: its list if the parent is not a list; NULL: the parent
                         is one */
};

extern const struct pen_xml_element pen_xml_scene;

/* An attribute of an element: its own row, or one made from a field. */
enum { PEN_XML_NAME_BYTES = 32, PEN_XML_PATH_BYTES = 64, PEN_XML_NAMES_MAX = 64 };
struct pen_xml_row {
    char name[PEN_XML_NAME_BYTES];
    enum pen_xml_shape shape;
    char path[PEN_XML_PATH_BYTES];
};

/* Lists all attributes of an element, without their other names. Returns their number, at most
 * PEN_XML_NAMES_MAX. */
size_t pen_xml_rows(const struct pen_xml_element *element,
                    struct pen_xml_row rows[PEN_XML_NAMES_MAX]);

/* Finds the attribute called `name`, which may be one of its other names. Returns false if the
 * element has none. */
bool pen_xml_row_find(const struct pen_xml_element *element, const char *name,
                      struct pen_xml_row *row);

/* The child element called `name`, which may be one of its other names, or NULL. */
const struct pen_xml_element *pen_xml_child_find(const struct pen_xml_element *element,
                                                 const char *name);

#endif
