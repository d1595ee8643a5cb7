/* SPDX-License-Identifier: MIT */
/* Error reports of the scene reader: message and place, in the document's format (JSON or XML). */
#include "io/scene/reader.h"

#include <stdarg.h>
#include <stdio.h>

bool pen_reader_fail(struct pen_reader *r, const struct pen_place *at, enum pen_code code,
                     const char *format, ...)
{
    struct pen_status st = {.code = code};
    if (r->source && r->source->is_reported(r->source->user, at))
        return false;
    if (pen_reader_wants_message(r)) {
        /* longer than the fields of a status, so that pen_fail_at marks a cut */
        char pointer[2 * PEN_AT_BYTES], message[2 * PEN_MSG_BYTES];
        pen_place_pointer(at, r->prefix, pointer, sizeof pointer);
        va_list args;
        va_start(args, format);
        if (vsnprintf(message, sizeof message, format, args) < 0)
            message[0] = '\0';
        va_end(args);
        if (r->source && code != PEN_NO_MEMORY)
            r->source->fail(r->source->user, at, code, message, &st);
        else
            pen_fail_at(&st, code, pointer, "%s", message);
    }
    pen_errors_add(r->errors, &st);
    return false;
}

void *pen_reader_alloc(struct pen_reader *r, size_t count, size_t size)
{
    void *memory = r->no_memory ? NULL : pen_arena_alloc(r->arena, count, size);
    if (!memory && !r->no_memory) {
        const struct pen_place root = {0};
        r->no_memory = true;
        pen_reader_fail(r, &root, PEN_NO_MEMORY, "the scene does not fit into the memory allowed");
    }
    return memory;
}

bool pen_reader_unsupported(struct pen_reader *r, const struct pen_place *at, const char *feature)
{
    return pen_reader_fail(r, at, PEN_UNSUPPORTED, "known, not supported yet: %s", feature);
}

struct pen_text pen_reader_found(const struct pen_reader *r, const struct pen_place *at,
                                 const json_t *value)
{
    return r->source ? r->source->found(r->source->user, at, value) : pen_text_value(value);
}

struct pen_text pen_reader_name(const struct pen_reader *r, const struct pen_place *up,
                                const char *key)
{
    return r->source ? r->source->name(r->source->user, up, key) : pen_text_quote(key);
}

void pen_reader_place(const struct pen_reader *r, const struct pen_place *at, char *out,
                      size_t bytes)
{
    if (r->source)
        r->source->position(r->source->user, at, out, bytes);
    else
        pen_place_pointer(at, r->prefix, out, bytes);
}

bool pen_reader_missing(struct pen_reader *r, const struct pen_place *up, const char *key,
                        const char *other)
{
    const char *noun = pen_reader_is_xml(r) ? "attribute" : "key";
    if (!pen_reader_wants_message(r))
        return pen_reader_fail(r, up, PEN_INVALID, "missing %s", noun);
    struct pen_text one = pen_reader_name(r, up, key);
    if (!other)
        return pen_reader_fail(r, up, PEN_INVALID, "missing %s %s", noun, one.text);
    return pen_reader_fail(r, up, PEN_INVALID, "missing %s %s or %s", noun, one.text,
                           pen_reader_name(r, up, other).text);
}
