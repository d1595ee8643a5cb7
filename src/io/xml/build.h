/* SPDX-License-Identifier: MIT */
/* Building the document's JSON values from XML elements as they open: parse.c has expat's events,
 * build.c makes the value of each element, errors.c reports errors. */
#ifndef PEN_IO_XML_BUILD_H
#define PEN_IO_XML_BUILD_H

#include <expat.h>

#include "base/buf.h"
#include "io/xml/parse.h"

/* An open element. */
struct pen_xml_frame {
    const struct pen_xml_element *element;
    size_t tag;            /* offset of its tag */
    json_t *object, *list; /* where members and items go; NULL: there are none. Borrowed. */
    int depth;             /* of the object in the document */
    bool text_reported;    /* the error that text is not allowed in this element */
};

struct pen_xml_builder {
    XML_Parser parser;
    const struct pen_limits *limits;
    struct pen_xml *xml;
    struct pen_status *st;
    json_t *document;
    struct pen_xml_frame frame[PEN_XML_DEPTH_MAX];
    int count, skipped;       /* frames, and open elements above them that are ignored */
    struct pen_xml_open open; /* both together */
    uint64_t elements;
    json_t *image; /* the value of <camera image="…">; NULL: none */
    struct pen_buf scratch;
    size_t room;  /* bytes that further values may take */
    bool stopped; /* parsing has ended with the error in *st */
};

/* Returns the value; NULL means out of memory and stops parsing. */
json_t *pen_xml_check_value(struct pen_xml_builder *b, json_t *value);
void pen_xml_require(struct pen_xml_builder *b, bool done);

/* Reserves memory for values about to be made; parsing stops when the limit is exceeded. Returns
 * whether it was not. */
bool pen_xml_reserve(struct pen_xml_builder *b, size_t bytes);

/* Adds an error; parsing goes on. */
void pen_xml_error(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* Stops parsing with an error. */
void pen_xml_abort(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* A fault of the attribute `name`, placed at it, or `offset` bytes into its value if that is not
 * 0; "attribute NAME of <ELEMENT>: message". */
struct pen_xml_about {
    const struct pen_xml_frame *frame;
    const char *name;
    const char *value; /* as expat gave it; NULL with offset 0 */
    size_t offset;
};
void pen_xml_attribute_error(struct pen_xml_builder *b, const struct pen_xml_about *about,
                             const char *format, ...) __attribute__((format(printf, 3, 4)));

void pen_xml_missing_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name);
void pen_xml_unknown_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name);
void pen_xml_unknown_element(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                             const char *name, size_t tag);

/* Makes the value of the element of *frame inside that of *up. Returns it, borrowed, or NULL if the
 * element is to be skipped with its content. `attributes` alternates names and values. */
json_t *pen_xml_build(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                      struct pen_xml_frame *frame, const char *const *attributes);

/* Puts an attribute into what was made. */
void pen_xml_attribute_read(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const char *name, const char *text);

/* After the attributes. */
void pen_xml_finish(struct pen_xml_builder *b, struct pen_xml_frame *frame,
                    const char *const *attributes);

/* After the last element: adds the XML dialect's defaults and puts the scene's parts into the order
 * of the format. */
void pen_xml_document_end(struct pen_xml_builder *b);

#endif
