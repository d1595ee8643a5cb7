/* SPDX-License-Identifier: MIT */
/* Scene documents in JSON or XML. An XML document is converted to the JSON values of the same
 * scene, with a record of the source element of each object and list. So the scene reader is the
 * same for both, and errors in XML still have a line and a column.
 *
 * Mapping of XML to the JSON format (all rules: api/openapi.yaml, SceneXml):
 *  - A list is an element that holds its members (`<views>`, `<materials>`, `<lights>`,
 *    `<geometries>`).
 *  - An object inside an object is an element inside an element (`<transform>`, `<transforms>`).
 *  - Every other key is an attribute, with - for _.
 *  - Colours are 0 to 255, and `color` is a light's intensity.
 *  - The attributes of a primitive's own material are in the primitive's element, or in an element
 *    `<material>`.
 *  - Names are compared without regard to case, - and _. Some have other names
 *    (io/xml/spellings.h).
 *  - Without `transfer` in `<render>`, pictures are encoded linearly.
 *
 * Numbers are read and written in the calling thread's locale, which must be "C". The programs
 * never set another locale, and module embed sets it during its calls.
 *
 * Text that is not well-formed, or neither UTF-8 nor UTF-16 with a byte-order mark, is PEN_SYNTAX:
 * only the first error, with line and column. Document types and entity declarations are refused in
 * the same way. All other errors are collected as in JSON. */
#ifndef PEN_IO_DOCUMENT_H
#define PEN_IO_DOCUMENT_H

#include "base/buf.h"
#include "io/scene_json.h"

struct pen_xml;

struct pen_document {
    json_t *json;        /* the values in the JSON format, also of an XML document */
    struct pen_xml *xml; /* the positions of an XML document; NULL for JSON */
};

/* Whether the text is XML: begins with `<` after an optional byte-order mark and white space, or is
 * in UTF-16, which JSON cannot be. */
bool pen_text_is_xml(const char *text, size_t bytes);

/* Whether the text begins with a byte-order mark of UTF-16. */
bool pen_text_is_utf16(const char *text, size_t bytes);

/* Parses JSON or, if `xml` is set, XML, whose text must outlive the document. Well-formed XML that
 * is not a scene (unknown elements, wrong attributes) is parsed too; pen_document_read reports its
 * errors.
 * Owns: the caller releases *out, also after a failure.
 * Fails: as pen_json_parse. */
bool pen_document_parse(const char *text, size_t bytes, bool xml, const struct pen_limits *limits,
                        struct pen_document *out, struct pen_status *st);
void pen_document_release(struct pen_document *document);

/* Reads the scene like pen_scene_read with at = "". Errors in XML are sorted by line and column. */
bool pen_document_read(const struct pen_document *document, const struct pen_limits *limits,
                       struct pen_arena *arena, struct pen_scene_desc *desc,
                       struct pen_errors *errors);

/* Parses and reads in one step. An error of pen_document_parse is added to *errors. */
bool pen_document_load(const char *text, size_t bytes, bool xml, const struct pen_limits *limits,
                       struct pen_arena *arena, struct pen_scene_desc *desc,
                       struct pen_errors *errors);

/* Replaces a JSON Pointer into the document by line and column if the document was XML. */
void pen_document_locate(const struct pen_document *document, struct pen_status *st);

/* The same, for a caller that has only the text of a document that was read before. */
void pen_text_locate(const char *text, size_t bytes, const struct pen_limits *limits,
                     struct pen_status *st);

/* Appends a document as indented JSON, with lines up to 100 characters if possible. Numbers have
 * the fewest digits that read back as the same value. Arrays of numbers or strings are on one line.
 * Fails: returns false when out of memory. */
bool pen_json_write(const json_t *json, struct pen_buf *out);

#endif
