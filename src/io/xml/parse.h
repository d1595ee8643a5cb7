/* SPDX-License-Identifier: MIT */
/* Converts a scene in XML to the values of the JSON format. */
#ifndef PEN_IO_XML_PARSE_H
#define PEN_IO_XML_PARSE_H

#include "io/xml/positions.h"

/* Parses the text and returns the JSON values. Errors in well-formed XML are collected in
 * xml->errors. The values are made nevertheless, so that the scene reader can add its own errors.
 * Owns: the caller json_decref()s the values and pen_xml_release()s *xml, also after a failure.
 * Fails: NULL; PEN_SYNTAX with line and column, PEN_INVALID (nesting), PEN_TOO_LARGE,
 * PEN_NO_MEMORY. */
json_t *pen_xml_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                      struct pen_xml *xml, struct pen_status *st);
void pen_xml_release(struct pen_xml *xml);

/* Limits of an element: the number of enclosing open elements, and of attributes. */
enum { PEN_XML_DEPTH_MAX = 64, PEN_XML_ATTRIBUTES_MAX = 64 };

/* Checks the text before expat reads it: refuses invalid UTF-8, characters that XML does not allow,
 * and tags with more than PEN_XML_ATTRIBUTES_MAX attributes, which would take memory.
 * Fails: PEN_SYNTAX. */
bool pen_xml_check_text(const char *text, size_t bytes, struct pen_status *st);

/* The open elements, the outermost first. */
struct pen_xml_open {
    int count;
    size_t tag[PEN_XML_DEPTH_MAX]; /* offsets */
};

/* Fills *st with a message for expat's error `code` at `offset`, inside the elements `open`.
 * Returns false. */
bool pen_xml_syntax_error(const char *text, size_t bytes, size_t offset, int code,
                          const struct pen_xml_open *open, struct pen_status *st);

#endif
