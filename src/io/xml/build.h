/* SPDX-License-Identifier: MIT */
/* Making JSON values from XML elements as they open. io/xml/parse.c receives expat's events,
 * io/xml/build.c makes the value of each element, io/xml/errors.c reports errors. */
#ifndef PEN_IO_XML_BUILD_H
#define PEN_IO_XML_BUILD_H

#include <expat.h>

#include "io/json/number.h"
#include "io/xml/parse.h"

/* An open element. */
struct pen_xml_frame {
    const struct pen_xml_element *element;
    size_t tag;            /* offset of its tag */
    json_t *object, *list; /* the containers for members and list elements, or NULL. Borrowed. */
    int depth;             /* nesting of the object in the JSON values */
    bool text_reported;    /* the error that this element must not hold text */
};

struct pen_xml_builder {
    XML_Parser parser;
    const struct pen_limits *limits;
    struct pen_xml *xml;
    struct pen_status *st;
    json_t *document;
    struct pen_xml_frame frame[PEN_XML_DEPTH_MAX];
    int count;                /* frames */
    int skipped;              /* open elements inside the innermost frame that are ignored */
    struct pen_xml_open open; /* the tags of both */
    uint64_t elements;
    json_t *image; /* the value of <camera image="…">; NULL: none */
    struct pen_json_numbers numbers;
    size_t bytes_left; /* memory that further values may take */
    bool stopped;      /* parsing has ended with the error in *st */
};

/* Returns the value. NULL, or `done` false, means out of memory and stops parsing. */
json_t *pen_xml_check_value(struct pen_xml_builder *b, json_t *value);
void pen_xml_require(struct pen_xml_builder *b, bool done);

/* Reserves memory of the limit parsed_bytes for values about to be made. Returns false, and stops
 * parsing, if the limit is exceeded. */
bool pen_xml_reserve(struct pen_xml_builder *b, size_t bytes);

/* Adds an error at an offset into the text; parsing continues. */
void pen_xml_error(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* Stops parsing with an error at an offset into the text. */
void pen_xml_abort(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* The attribute that an error is about. The error's position is the attribute's name, or, if
 * `offset` is not 0, that many bytes into its value. */
struct pen_xml_attribute_ref {
    const struct pen_xml_frame *frame;
    const char *name;
    const char *value; /* as expat has decoded it; NULL if offset is 0 */
    size_t offset;
};

/* Adds the error "attribute NAME of <ELEMENT>: message". */
void pen_xml_attribute_error(struct pen_xml_builder *b, const struct pen_xml_attribute_ref *ref,
                             const char *format, ...) __attribute__((format(printf, 3, 4)));

void pen_xml_missing_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name);
void pen_xml_unknown_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name);
void pen_xml_unknown_element(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                             const char *name, size_t tag);

/* Makes the value of the element of *frame inside the element of *up. Returns the value, borrowed,
 * or NULL if the element and its content must be skipped. `attributes` alternates names and values
 * and ends with NULL. */
json_t *pen_xml_build(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                      struct pen_xml_frame *frame, const char *const *attributes);

/* Reads one attribute into the value that pen_xml_build has made. */
void pen_xml_attribute_read(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const char *name, const char *text);

/* Completes the value after all attributes (planes by three points, missing corners, groups). */
void pen_xml_finish(struct pen_xml_builder *b, struct pen_xml_frame *frame,
                    const char *const *attributes);

/* Called after the last element: adds the defaults of the XML format and puts the scene's parts
 * into the order of the JSON format. */
void pen_xml_document_end(struct pen_xml_builder *b);

#endif
