/* SPDX-License-Identifier: MIT */
/* Converts the text of an attribute to a value of the JSON format. */
#ifndef PEN_IO_XML_VALUES_H
#define PEN_IO_XML_VALUES_H

#include "io/json/number.h"
#include "io/xml/elements.h"

/* The reason why an attribute has no value: no_memory, or over_limit, or else msg. */
struct pen_xml_value_error {
    bool no_memory;
    bool over_limit;     /* the limit of memory for values is exceeded */
    struct pen_text msg; /* a sentence that begins with "must" or with the wrong token */
    size_t offset;       /* of the error, into the text */
};

/* Converts a text. A token that should be a number but is not becomes a string, which the scene
 * reader refuses. A wrong count of numbers is refused here. *bytes_left is the memory that values
 * may still take; it is reduced by the value's memory. `numbers` belong to the whole document.
 * Owns: the caller json_decref()s the value.
 * Fails: NULL, after filling *error. */
json_t *pen_xml_value(enum pen_xml_shape shape, const char *text, struct pen_json_numbers *numbers,
                      size_t *bytes_left, struct pen_xml_value_error *error);

/* Whether c is white space of XML. */
static inline bool pen_xml_is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Finds token number `index` of the text: a run without white space and semicolons. Returns false
 * if there are fewer tokens. */
bool pen_xml_token(const char *text, size_t bytes, size_t index, size_t *start, size_t *end);

#endif
