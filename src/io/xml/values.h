/* SPDX-License-Identifier: MIT */
/* The text of an attribute as a value of the JSON format. */
#ifndef PEN_IO_XML_VALUES_H
#define PEN_IO_XML_VALUES_H

#include "base/buf.h"
#include "io/xml/elements.h"

struct pen_xml_value_error {
    size_t offset;       /* into the text */
    bool no_memory;      /* this, and no message */
    bool no_room;        /* or this */
    struct pen_text msg; /* a sentence that begins with "must" or with the piece */
};

/* The value. What is no number where one is wanted becomes a string, which the reader refuses with
 * what is allowed; wrong counts are refused here. Owns: the caller json_decref()s. Fails: NULL,
 * after filling *fault. `room` is what values may still take of memory: it grows less by what the
 * value takes. `scratch` is a place to work in, kept between calls. */
json_t *pen_xml_value(enum pen_xml_shape shape, const char *text, struct pen_buf *scratch,
                      size_t *room, struct pen_xml_value_error *fault);

/* The piece number `index` of the text: a run without white space and semicolons. Returns false if
 * there are fewer. */
bool pen_xml_token(const char *text, size_t bytes, size_t index, size_t *start, size_t *end);

#endif
