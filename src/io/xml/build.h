/* SPDX-License-Identifier: MIT */
/* Making JSON values from XML elements as they open. io/xml/parse.c receives expat's events.
 * io/xml/build.c makes the value of each element. io/xml/finish.c completes it after its
 * attributes, and the document after its elements. io/xml/errors.c reports errors, io/xml/unknown.c
 * errors about unknown names. */
#ifndef PEN_IO_XML_BUILD_H
#define PEN_IO_XML_BUILD_H

#include <expat.h>
#include <string.h>

#include "io/json/memory.h"
#include "io/json/number.h"
#include "io/xml/parse.h"

/* An open element. */
struct pen_xml_frame {
    const struct pen_xml_element *element;
    size_t tag;            /* offset of its tag */
    json_t *object, *list; /* the containers of members and of list elements, or NULL; borrowed */
    int depth;             /* nesting of the object in the JSON values */
    bool text_reported;    /* it was reported that this element must not hold text */
};

/* An attribute of a tag. */
struct pen_xml_given {
    const char *name, *text; /* as written; as decoded by expat */
    struct pen_xml_row row;
    bool known; /* the element has this attribute, and `row` is set */
};

/* The attributes of a tag, except those about XML itself. */
struct pen_xml_given_list {
    size_t count;
    struct pen_xml_given item[PEN_XML_ATTRIBUTES_MAX];
};

/* An unknown name. If it is unknown at several lines, it is one error, which lists the lines. */
enum { PEN_XML_UNKNOWN_BYTES = 48, PEN_XML_UNKNOWN_LINES = 8 };
struct pen_xml_unknown {
    const struct pen_xml_element *element; /* the element without such an attribute or child */
    bool attribute;
    char name[PEN_XML_UNKNOWN_BYTES];
    size_t error;                     /* its index in the list of errors */
    size_t list_at;                   /* offset in its message at which the lines are listed */
    int lines[PEN_XML_UNKNOWN_LINES]; /* the first of `line_count` lines */
    int line_count, last_line;
};

struct pen_xml_builder {
    XML_Parser parser;
    const struct pen_limits *limits;
    struct pen_xml *xml;
    struct pen_status *st;
    json_t *document;
    struct pen_xml_frame frame[PEN_XML_DEPTH_MAX];
    int count;                /* frames */
    int skipped;              /* ignored open elements inside the innermost frame */
    struct pen_xml_open open; /* the tags of both */
    uint64_t elements;
    json_t *image; /* the value of <camera image="…">; NULL: none */
    struct pen_json_numbers numbers;
    size_t bytes_left; /* memory left for further values */
    bool stopped;      /* parsing has ended with the error in *st */
    struct pen_xml_unknown unknown[PEN_ERRORS_MAX];
    size_t unknown_count;
    size_t line_at; /* the offset up to which lines have been counted */
    int line;       /* the line there, from 0 */
};

/* The memory of containers, as estimated by io/json/memory.h. */
enum {
    PEN_XML_TRIPLE_BYTES = PEN_JSON_ARRAY_BYTES + 3 * PEN_JSON_ELEMENT_BYTES, /* without values */
    PEN_XML_NUMBERS_BYTES = PEN_XML_TRIPLE_BYTES + 3 * PEN_JSON_NUMBER_BYTES
};

static inline size_t pen_xml_member_bytes(const char *key)
{
    return PEN_JSON_MEMBER_BYTES + strlen(key);
}

/* Checks a value, or a step, for lack of memory. NULL, or `done` false, means out of memory and
 * stops parsing. Returns the value. */
json_t *pen_xml_check_value(struct pen_xml_builder *b, json_t *value);
void pen_xml_require(struct pen_xml_builder *b, bool done);

/* Reserves memory of the limit parsed_bytes for values before they are made. Returns false, and
 * stops parsing, if the limit is exceeded. */
bool pen_xml_reserve(struct pen_xml_builder *b, size_t bytes);

/* Whether the list of errors still keeps messages. */
static inline bool pen_xml_wants_message(const struct pen_xml_builder *b)
{
    return b->xml->errors.count < PEN_ERRORS_MAX;
}

/* The name of the frame's element as written. */
static inline struct pen_text pen_xml_frame_name(const struct pen_xml_builder *b,
                                                 const struct pen_xml_frame *frame)
{
    return pen_xml_tag_name(b->xml->text, b->xml->bytes, frame->tag);
}

/* Adds an error at an offset into the text; parsing continues. */
void pen_xml_error(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* Stops parsing with an error at an offset into the text. */
void pen_xml_abort(struct pen_xml_builder *b, size_t offset, enum pen_code code, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* The attribute of an error. The error's position is the attribute's name or, if `offset` is not 0,
 * that many bytes into its value. */
struct pen_xml_attribute_ref {
    const struct pen_xml_frame *frame;
    const char *name;  /* as written */
    const char *value; /* as expat has decoded it; NULL if offset is 0 */
    size_t offset;
};

/* Adds the error "attribute NAME of <ELEMENT>: message". */
void pen_xml_attribute_error(struct pen_xml_builder *b, const struct pen_xml_attribute_ref *ref,
                             const char *format, ...) __attribute__((format(printf, 3, 4)));

void pen_xml_missing_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name);

/* Reports names that the element does not have. */
void pen_xml_unknown_attribute(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                               const char *name);
void pen_xml_unknown_element(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                             const char *name, size_t tag);

/* Completes the errors about unknown names with their lines, after the last one. */
void pen_xml_list_lines(struct pen_xml_builder *b);

/* Reports that the attribute has another value than an earlier attribute, or an element, with the
 * same `path`. The message names the place of both. `old` is the earlier value. */
void pen_xml_conflict(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                      const struct pen_xml_given *given, const char *path, const json_t *old);

/* Reports that the element is a repetition; `old` is the value of the first. */
void pen_xml_duplicate(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                       const json_t *old);

/* The first attribute whose value has the path, or NULL. */
const struct pen_xml_given *pen_xml_given_at(const struct pen_xml_given_list *list,
                                             const char *path);

/* Makes the value of the element of *frame inside the element of *up. Returns the value, borrowed,
 * or NULL if the element and its content must be skipped. */
json_t *pen_xml_build(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                      struct pen_xml_frame *frame, const struct pen_xml_given_list *attributes);

/* Reads one attribute into the value that pen_xml_build has made. */
void pen_xml_attribute_read(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const struct pen_xml_given_list *attributes,
                            const struct pen_xml_given *given);

/* Completes the value after all attributes: planes by three points, missing corners, groups, the
 * attenuation of lights. */
void pen_xml_finish(struct pen_xml_builder *b, struct pen_xml_frame *frame,
                    const struct pen_xml_given_list *attributes);

/* Called after the last element: adds the defaults of the XML format and puts the scene's parts
 * into the order of the JSON format. */
void pen_xml_document_end(struct pen_xml_builder *b);

#endif
