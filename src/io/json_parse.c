/* SPDX-License-Identifier: MIT */
/* Bytes to a JSON document. What is cheap to check is checked first: length, then nesting. */
#include "pen/io/scene_json.h"

#include "syntax.h"

/* Integers too long for 64 bits are read as reals, as RFC 8259 has all numbers be doubles; only
 * a document that holds one is read so as a whole, so that others keep theirs exact. */
static json_t *parse(const char *text, size_t bytes, json_error_t *error)
{
    const size_t flags = JSON_REJECT_DUPLICATES | JSON_DECODE_ANY;
    json_t *document = json_loadb(text, bytes, flags, error);
    if (document || json_error_code(error) != json_error_numeric_overflow)
        return document;
    return json_loadb(text, bytes, flags | JSON_DECODE_INT_AS_REAL, error);
}

json_t *pen_json_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                       struct pen_status *st)
{
    json_error_t error;
    if (bytes > limits->body_bytes) {
        pen_fail(st, PEN_TOO_LARGE, "the document has %zu bytes, at most %zu are allowed", bytes,
                 limits->body_bytes);
        return NULL;
    }
    size_t deep = pen_syntax_too_deep(text, bytes, limits->nesting);
    if (deep < bytes) {
        pen_syntax_fail_deep(text, deep, limits->nesting, st);
        return NULL;
    }
    json_t *document = parse(text, bytes, &error);
    if (!document)
        pen_syntax_fail(text, bytes, &error, st);
    return document;
}
