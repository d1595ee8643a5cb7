/* SPDX-License-Identifier: MIT */
/* Writes JSON values as indented text. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "io/error/text.h"

enum { INDENT = 2, LINE = 100 };

static void write_value(struct pen_buf *out, const json_t *json, int depth);

static void write_newline(struct pen_buf *out, int depth)
{
    pen_buf_puts(out, "\n");
    for (int i = 0; i < depth * INDENT; i++)
        pen_buf_puts(out, " ");
}

static void write_string(struct pen_buf *out, const json_t *json)
{
    char *text = json_dumps(json, JSON_ENCODE_ANY);
    if (!text || !pen_buf_puts(out, text))
        out->failed = true;
    free(text);
}

static void write_key(struct pen_buf *out, const char *key)
{
    json_t *string = json_string_nocheck(key);
    if (string)
        write_string(out, string);
    else
        out->failed = true;
    json_decref(string);
    pen_buf_puts(out, ": ");
}

/* Whether an array contains no arrays or objects, so that it is written on one line. */
static bool is_flat(const json_t *list)
{
    bool flat = true;
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *value = json_array_get(list, i);
        flat = flat && !json_is_array(value) && !json_is_object(value);
    }
    return flat;
}

static void write_list(struct pen_buf *out, const json_t *list, int depth)
{
    size_t count = json_array_size(list);
    bool flat = is_flat(list);
    pen_buf_puts(out, "[");
    for (size_t i = 0; i < count; i++) {
        if (i > 0)
            pen_buf_puts(out, flat ? ", " : ",");
        if (!flat)
            write_newline(out, depth + 1);
        write_value(out, json_array_get(list, i), depth + 1);
    }
    if (!flat)
        write_newline(out, depth);
    pen_buf_puts(out, "]");
}

static void write_members(struct pen_buf *out, const json_t *object, int depth, bool flat)
{
    json_t *members = (json_t *)object; /* jansson's iterator takes no const; nothing changes */
    size_t count = 0;
    for (void *i = json_object_iter(members); i; i = json_object_iter_next(members, i)) {
        if (count++ > 0)
            pen_buf_puts(out, flat ? ", " : ",");
        if (!flat)
            write_newline(out, depth + 1);
        write_key(out, json_object_iter_key(i));
        write_value(out, json_object_iter_value(i), depth + 1);
    }
}

static bool has_containers(const json_t *object)
{
    json_t *members = (json_t *)object;
    for (void *i = json_object_iter(members); i; i = json_object_iter_next(members, i)) {
        const json_t *value = json_object_iter_value(i);
        if (json_is_object(value) || (json_is_array(value) && !is_flat(value)))
            return true;
    }
    return false;
}

/* Writes an object on one line if it fits there and contains nothing that needs its own lines. */
static void write_object(struct pen_buf *out, const json_t *object, int depth)
{
    struct pen_buf line = {0};
    bool flat = !has_containers(object);
    if (flat)
        write_members(&line, object, depth, true);
    flat = flat && (size_t)(depth * INDENT) + line.bytes + 2 <= LINE;
    out->failed |= line.failed;
    pen_buf_puts(out, "{");
    if (flat)
        pen_buf_add(out, line.data, line.bytes);
    else {
        write_members(out, object, depth, false);
        write_newline(out, depth);
    }
    pen_buf_puts(out, "}");
    pen_buf_release(&line);
}

/* "-0" is read as the integer 0, which has no sign. */
static bool is_minus_zero(const json_t *json)
{
    return json_is_real(json) && json_real_value(json) == 0 && signbit(json_real_value(json));
}

static void write_value(struct pen_buf *out, const json_t *json, int depth)
{
    if (json_is_object(json))
        write_object(out, json, depth);
    else if (json_is_array(json))
        write_list(out, json, depth);
    else if (json_is_string(json))
        write_string(out, json);
    else
        pen_buf_puts(out, is_minus_zero(json) ? "-0.0" : pen_text_value(json).text);
}

bool pen_json_write(const json_t *json, struct pen_buf *out)
{
    write_value(out, json, 0);
    return pen_buf_puts(out, "\n");
}
