/* SPDX-License-Identifier: MIT */
/* Text in XML to a document of the JSON format. */
#ifndef PEN_IO_XML_PARSE_H
#define PEN_IO_XML_PARSE_H

#include "io/xml/positions.h"

/* Makes the document. What is well-formed but no scene is collected in xml->faults, and the
 * document is made all the same, so that its reader can say the rest.
 * Owns: the caller json_decref()s the document and pen_xml_release()s *xml, in any case.
 * Fails: NULL; PEN_SYNTAX with line and column, PEN_INVALID (nesting), PEN_TOO_LARGE,
 * PEN_NO_MEMORY. */
json_t *pen_xml_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                      struct pen_xml *xml, struct pen_status *st);
void pen_xml_release(struct pen_xml *xml);

/* What is done before expat sees the text, and what its errors are in words. */
enum { PEN_XML_DEPTH_MAX = 64, PEN_XML_ATTRIBUTES_MAX = 64 };

/* Refuses what is not UTF-8, characters that XML does not have, and a tag with more attributes
 * than any element can take, which would cost memory. Fails: PEN_SYNTAX. */
bool pen_xml_check_text(const char *text, size_t bytes, struct pen_status *st);

/* Fills *st for expat's error `code` at `offset`; `open` are the tags around it. Returns false. */
struct pen_xml_open {
    int count;
    size_t tag[PEN_XML_DEPTH_MAX]; /* offsets */
};
bool pen_xml_syntax_error(const char *text, size_t bytes, size_t offset, int code,
                          const struct pen_xml_open *open, struct pen_status *st);

/* The name in the tag at an offset, for messages. */
struct pen_text pen_xml_tag_name(const char *text, size_t bytes, size_t tag);

#endif
