/* SPDX-License-Identifier: MIT */
/* Scene documents in JSON or XML. XML is made into the same document that JSON is, with a memory
 * of where its parts came from: one reader, one meaning, and every error at its line and column.
 *
 * In XML a list of the format is an element that holds its members (`<views>`, `<materials>`,
 * `<lights>`, `<geometries>`), an object in an object is an element in an element (`<transform>`,
 * `<transforms>`), and every other key an attribute with - for _. Colours are 0 to 255, `color` is
 * a light's intensity, material attributes stand on bodies, and without `render` pictures are
 * encoded linearly. api/openapi.yaml (SceneXml) has all rules.
 *
 * What is not well-formed, or not UTF-8, is PEN_SYNTAX, reported alone; document types and entity
 * declarations are refused as such. Everything else is collected as in JSON. */
#ifndef PEN_IO_DOCUMENT_H
#define PEN_IO_DOCUMENT_H

#include "base/buf.h"
#include "io/scene_json.h"

struct pen_xml;

struct pen_document {
    json_t *json;        /* of the JSON format, whatever was read */
    struct pen_xml *xml; /* NULL: it was JSON */
};

/* Whether the text begins as XML does: with `<`, after white space or a byte order mark. */
bool pen_text_is_xml(const char *text, size_t bytes);

/* Parses JSON or, if `xml` is set, XML, whose text must outlive the document. What is well-formed
 * XML and no scene still is a document; pen_document_read reports it.
 * Owns: release *out in any case. Fails: as pen_json_parse. */
bool pen_document_parse(const char *text, size_t bytes, bool xml, const struct pen_limits *limits,
                        struct pen_document *out, struct pen_status *st);
void pen_document_release(struct pen_document *document);

/* As pen_scene_read of a bare scene. Errors of XML come in the order of the text. */
bool pen_document_read(const struct pen_document *document, const struct pen_limits *limits,
                       struct pen_arena *arena, struct pen_scene_desc *desc,
                       struct pen_errors *errors);

/* Parses and reads in one step. Fails: what pen_document_parse says is added to *errors. */
bool pen_document_load(const char *text, size_t bytes, bool xml, const struct pen_limits *limits,
                       struct pen_arena *arena, struct pen_scene_desc *desc,
                       struct pen_errors *errors);

/* Replaces a JSON Pointer into the document by line and column, if it was XML. */
void pen_document_locate(const struct pen_document *document, struct pen_status *st);

/* The same, for who has but the text of a document that was read before. */
void pen_text_locate(const char *text, size_t bytes, const struct pen_limits *limits,
                     struct pen_status *st);

/* Appends JSON as people like to read it: numbers in the fewest digits that read back as the same,
 * a list of numbers or strings on one line. Fails: returns false when out of memory. */
bool pen_json_write(const json_t *json, struct pen_buf *out);

#endif
