/* SPDX-License-Identifier: MIT */
/* Reading objects by tables of fields. */
#include <stdio.h>
#include <string.h>

#include "io/scene/reader.h"

static bool read_number_field(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                              const struct pen_field *field, double *out)
{
    if (!pen_read_number(r, at, value, field->range, out))
        return false;
    if (!field->unsupported || *out == field->off)
        return true;
    struct pen_text found = pen_reader_found(r, at, value), off = pen_text_number(field->off);
    return pen_reader_fail(r, at, PEN_UNSUPPORTED,
                           "known, not supported yet: %s; found %s, only %s is accepted so far",
                           field->unsupported, found.text, off.text);
}

static bool read_bool(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                      bool *out)
{
    *out = json_is_true(value);
    if (json_is_boolean(value))
        return true;
    struct pen_text found = pen_reader_found(r, at, value);
    return pen_reader_fail(r, at, PEN_INVALID, "must be true or false, found %s", found.text);
}

static bool read_note(struct pen_reader *r, const struct pen_place *at, const json_t *value)
{
    if (json_is_string(value))
        return true;
    struct pen_text found = pen_reader_found(r, at, value);
    return pen_reader_fail(r, at, PEN_INVALID, "must be a string, found %s", found.text);
}

static bool read_field(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                       const struct pen_field *field, void *out)
{
    switch (field->type) {
    case PEN_FIELD_OTHER:
        return true;
    case PEN_FIELD_NOTE:
        return read_note(r, at, value);
    case PEN_FIELD_NUMBER:
        return read_number_field(r, at, value, field, out);
    case PEN_FIELD_INTEGER:
        return pen_read_integer(r, at, value, field->range, out);
    case PEN_FIELD_SEED:
        return pen_read_seed(r, at, value, out);
    case PEN_FIELD_BOOL:
        return read_bool(r, at, value, out);
    case PEN_FIELD_WORD:
        return pen_read_word(r, at, value, field->words, out);
    case PEN_FIELD_STRING:
        return pen_read_string(r, at, value, out);
    case PEN_FIELD_COLOUR_OR_PATTERN:
        if (json_is_object(value))
            return true;
        return pen_read_vec3(r, at, value, &pen_range_not_negative, out);
    case PEN_FIELD_COLOUR:
        return pen_read_vec3(r, at, value, &pen_range_not_negative, out);
    case PEN_FIELD_FACTOR_OR_PATTERN:
        if (json_is_object(value))
            return true;
        return pen_read_factor(r, at, value, out);
    case PEN_FIELD_FACTOR:
        return pen_read_factor(r, at, value, out);
    case PEN_FIELD_POINT:
        return pen_read_vec3(r, at, value, &pen_range_any, out);
    case PEN_FIELD_DIRECTION:
        return pen_read_direction(r, at, value, out);
    case PEN_FIELD_COEFFICIENTS:
        return pen_read_coefficients(r, at, value, out);
    }
    return false;
}

/* Writes "; the keys here are a, b, c". */
static void list_keys(const struct pen_field *fields, char *out, size_t bytes)
{
    size_t used = (size_t)snprintf(out, bytes, "; the keys here are ");
    const char *comma = "";
    for (const struct pen_field *f = fields; f->key && used < bytes; f++) {
        if (f->type == PEN_FIELD_NOTE)
            continue;
        used += (size_t)snprintf(out + used, bytes - used, "%s%s", comma, f->key);
        comma = ", ";
    }
}

static bool refuse_unknown(struct pen_reader *r, const struct pen_place *at, const char *key,
                           const struct pen_field *fields)
{
    enum { KEYS_MAX = 32 };
    struct pen_place place = pen_place_key(at, key);
    if (!pen_reader_wants_message(r))
        return pen_reader_fail(r, &place, PEN_INVALID, "unknown key");
    const char *names[KEYS_MAX + 2] = {NULL};
    int count = 0;
    for (; count < KEYS_MAX && fields[count].key; count++)
        names[count] = fields[count].key;
    names[count] = PEN_COMMENT_KEY;
    struct pen_text quoted = pen_text_quote(key), near = pen_text_nearest(key, names);
    char keys[384] = "";
    if (!near.text[0])
        list_keys(fields, keys, sizeof keys);
    return pen_reader_fail(r, &place, PEN_INVALID, "unknown key %s%s%s", quoted.text, near.text,
                           keys);
}

const struct pen_field *pen_field_find(const struct pen_field *fields, const char *key)
{
    while (fields->key && strcmp(fields->key, key) != 0)
        fields++;
    return fields->key ? fields : NULL;
}

bool pen_fields_read_member(struct pen_reader *r, const struct pen_place *at, const char *key,
                            const json_t *value, const struct pen_field *fields, void *target)
{
    const struct pen_field *field = pen_field_find(fields, key);
    struct pen_place place = pen_place_key(at, key);
    if (!field)
        return refuse_unknown(r, at, key, fields);
    return read_field(r, &place, value, field, (char *)target + field->offset);
}

size_t pen_fields_count(const json_t *object)
{
    return json_object_size(object) - (json_object_get(object, PEN_COMMENT_KEY) ? 1 : 0);
}

/* Reads the comment that the object may have. */
static bool read_comment(struct pen_reader *r, const struct pen_place *at, const json_t *object)
{
    const json_t *comment = json_object_get(object, PEN_COMMENT_KEY);
    struct pen_place place = pen_place_key(at, PEN_COMMENT_KEY);
    return !comment || read_note(r, &place, comment);
}

bool pen_fields_read(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                     const struct pen_field *fields, void *target)
{
    bool ok = true;
    size_t present = 0;
    if (!json_is_object(object)) {
        struct pen_text found = pen_text_value(object);
        return pen_reader_fail(r, at, PEN_INVALID, "must be an object, found %s", found.text);
    }
    for (const struct pen_field *f = fields; f->key; f++) {
        const json_t *value = json_object_get(object, f->key);
        if (!value)
            continue;
        struct pen_place place = pen_place_key(at, f->key);
        ok &= read_field(r, &place, value, f, (char *)target + f->offset);
        present++;
    }
    if (present == json_object_size(object))
        return ok;
    ok &= read_comment(r, at, object);
    json_t *members = (json_t *)object; /* jansson's iterator takes no const; nothing changes */
    for (void *i = json_object_iter(members); i; i = json_object_iter_next(members, i)) {
        const char *key = json_object_iter_key(i);
        if (!pen_field_find(fields, key) && strcmp(key, PEN_COMMENT_KEY) != 0)
            ok = refuse_unknown(r, at, key, fields);
    }
    return ok;
}

bool pen_fields_read_whole(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                           const struct pen_field *fields, void *target)
{
    bool ok = pen_fields_read(r, at, object, fields, target);
    for (const struct pen_field *f = fields; f->key && json_is_object(object); f++) {
        if (f->required && !json_object_get(object, f->key))
            ok = pen_reader_missing(r, at, f->key, NULL);
    }
    return ok;
}

bool pen_read_type(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                   const struct pen_word *types, int *type)
{
    const json_t *value = json_object_get(object, "type");
    struct pen_place place = pen_place_key(at, "type");
    if (value)
        return pen_read_word(r, &place, value, types, type);
    if (json_is_object(object))
        return pen_reader_fail(r, at, PEN_INVALID, "missing key \"type\"");
    struct pen_text found = pen_text_value(object);
    return pen_reader_fail(r, at, PEN_INVALID, "must be an object, found %s", found.text);
}
