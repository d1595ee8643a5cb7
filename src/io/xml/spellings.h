/* SPDX-License-Identifier: MIT */
/* The other names of elements and attributes that scenes in XML may use. Classroom programs share
 * the parts of a scene, but not their names. This is the only table of them; api/scene-format.md
 * has the same rows, and a test compares both.
 *
 * A row applies wherever its own name is allowed. Names are compared without regard to case, - and
 * _, so kD is kd, and narrowBeam is narrow-beam. */
#ifndef PEN_IO_XML_SPELLINGS_H
#define PEN_IO_XML_SPELLINGS_H

#include <stdbool.h>
#include <stddef.h>

enum pen_xml_spelling_kind {
    PEN_XML_OTHER_ELEMENT,   /* other names of an element */
    PEN_XML_OTHER_ATTRIBUTE, /* other names of an attribute */
    PEN_XML_PARTS            /* attributes that have the numbers, or the points, one by one */
};

enum { PEN_XML_OTHER_NAMES = 6, PEN_XML_PARTS_MAX = 64 };

struct pen_xml_spelling {
    enum pen_xml_spelling_kind kind;
    const char *ours; /* NULL ends the table */
    /* Ends with NULL; "…" continues the numbers before it. */
    const char *other[PEN_XML_OTHER_NAMES];
};

extern const struct pen_xml_spelling pen_xml_spellings[];

/* Whether two names are the same without regard to case, - and _. */
bool pen_xml_same_name(const char *a, const char *b);

/* Whether the name is one of the row's other names. *index becomes its number; for parts, the
 * number of the part. */
bool pen_xml_spelling_has(const struct pen_xml_spelling *row, const char *name, size_t *index);

/* Whether the attribute is about namespaces and schemas of XML, which have no effect on a scene. */
bool pen_xml_is_about_xml(const char *name);

#endif
