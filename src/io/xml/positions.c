/* SPDX-License-Identifier: MIT */
#include "io/xml/positions.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "io/xml/values.h"

/* The most steps from the document to a value. The limits of nesting are far lower. */
enum { STEPS_MAX = 256 };

/* The steps from the document to a value: a place in reverse order. */
struct path {
    size_t count;
    const struct pen_place *step[STEPS_MAX];
};

/* The position of a place in the text. */
struct position {
    const struct pen_xml_element *element;
    size_t tag;           /* offset of the element's tag */
    struct pen_text name; /* of the attribute as it is written; "": the element itself */
    size_t at;            /* the offset for an error */
    size_t start, end;    /* offsets of the text found there; equal: none */
    bool reported;        /* an error in a value on the path has been reported */
};

bool pen_xml_record(struct pen_xml *xml, const json_t *json, const struct pen_xml_element *element,
                    size_t offset)
{
    if (xml->count == xml->capacity) {
        size_t capacity = xml->capacity ? 2 * xml->capacity : 64;
        struct pen_xml_entry *wider = realloc(xml->entries, capacity * sizeof *wider);
        if (!wider)
            return false;
        xml->entries = wider;
        xml->capacity = capacity;
    }
    xml->entries[xml->count++] = (struct pen_xml_entry){json, element, offset};
    xml->sorted = false;
    return true;
}

static int compare_entries(const void *a, const void *b)
{
    uintptr_t x = (uintptr_t)((const struct pen_xml_entry *)a)->json;
    uintptr_t y = (uintptr_t)((const struct pen_xml_entry *)b)->json;
    return x < y ? -1 : x > y;
}

static const struct pen_xml_entry *find_entry(struct pen_xml *xml, const json_t *json)
{
    const struct pen_xml_entry wanted = {.json = json};
    if (!xml->sorted)
        qsort(xml->entries, xml->count, sizeof *xml->entries, compare_entries);
    xml->sorted = true;
    return bsearch(&wanted, xml->entries, xml->count, sizeof wanted, compare_entries);
}

const struct pen_xml_entry *pen_xml_latest(const struct pen_xml *xml, const json_t *json,
                                           size_t from)
{
    for (size_t i = xml->count; i-- > 0 && xml->entries[i].offset >= from;)
        if (xml->entries[i].json == json)
            return &xml->entries[i];
    return NULL;
}

static bool is_name_end(char c)
{
    return pen_xml_is_space(c) || c == '=' || c == '>' || c == '/';
}

size_t pen_xml_attributes_begin(const struct pen_xml *xml, size_t tag)
{
    size_t i = tag + 1;
    while (i < xml->bytes && !is_name_end(xml->text[i]))
        i++;
    return i;
}

bool pen_xml_attribute_next(const struct pen_xml *xml, size_t *at, struct pen_xml_span *span)
{
    const char *s = xml->text;
    size_t i = *at;
    while (i < xml->bytes && pen_xml_is_space(s[i]))
        i++;
    span->name = i;
    while (i < xml->bytes && !is_name_end(s[i]))
        i++;
    span->name_end = i;
    while (i < xml->bytes && (pen_xml_is_space(s[i]) || s[i] == '='))
        i++;
    if (span->name_end == span->name || i >= xml->bytes || (s[i] != '"' && s[i] != '\''))
        return false;
    const char *close = memchr(s + i + 1, s[i], xml->bytes - i - 1);
    span->value = i + 1;
    span->end = close ? (size_t)(close - s) : xml->bytes;
    *at = span->end + 1;
    return true;
}

bool pen_xml_attribute_find(const struct pen_xml *xml, size_t tag, const char *name,
                            struct pen_xml_span *span)
{
    size_t length = strlen(name), at = pen_xml_attributes_begin(xml, tag);
    while (pen_xml_attribute_next(xml, &at, span)) {
        if (span->name_end - span->name == length &&
            memcmp(xml->text + span->name, name, length) == 0)
            return true;
    }
    return false;
}

bool pen_xml_attribute_row(const struct pen_xml *xml, const struct pen_xml_span *span,
                           const struct pen_xml_element *element, struct pen_text *written,
                           struct pen_xml_row *row)
{
    snprintf(written->text, sizeof written->text, "%.*s", (int)(span->name_end - span->name),
             xml->text + span->name);
    return pen_xml_row_find(element, written->text, row);
}

static struct path path_of(const struct pen_place *at)
{
    struct path path = {0};
    size_t depth = 0;
    for (const struct pen_place *p = at; p->up; p = p->up)
        depth++;
    for (size_t i = depth; at->up; at = at->up) {
        if (--i < STEPS_MAX)
            path.step[i] = at;
    }
    path.count = depth < STEPS_MAX ? depth : STEPS_MAX;
    return path;
}

static size_t index_of(const struct pen_place *step)
{
    return step->key ? strtoul(step->key, NULL, 10) : step->index;
}

static const json_t *follow(const json_t *json, const struct pen_place *step)
{
    return json_is_array(json) ? json_array_get(json, index_of(step))
           : step->key         ? json_object_get(json, step->key)
                               : NULL;
}

/* Follows a path through the JSON values as far as they exist. Finds the innermost element that is
 * at most `limit` steps away, and whether an error on the way has been reported. Returns the number
 * of steps to that element. */
static size_t find_element(struct pen_xml *xml, const struct path *path, size_t limit,
                           struct position *position)
{
    const json_t *json = xml->document;
    const struct pen_xml_entry *entry = find_entry(xml, json);
    size_t used = 0;
    position->element = entry ? entry->element : &pen_xml_scene;
    position->at = position->tag = entry ? entry->offset : 0;
    for (size_t i = 0; i < path->count; i++) {
        json = follow(json, path->step[i]);
        position->reported = position->reported || json_is_null(json);
        bool may_have = i < limit && (json_is_array(json) || json_is_object(json));
        entry = may_have ? find_entry(xml, json) : NULL;
        if (!entry)
            continue;
        position->element = entry->element;
        position->at = position->tag = entry->offset;
        used = i + 1;
    }
    return used;
}

/* The number of steps, from step `from`, that the row's path matches; -1 if it does not match. */
static int match_path(const char *row_path, const struct path *path, size_t from)
{
    int taken = 0;
    while (*row_path) {
        size_t length = strcspn(row_path, "/");
        char digits[24];
        if (from + (size_t)taken >= path->count)
            return -1;
        const struct pen_place *step = path->step[from + (size_t)taken];
        snprintf(digits, sizeof digits, "%zu", step->index);
        const char *word = step->key ? step->key : digits;
        if (strlen(word) != length || strncmp(word, row_path, length) != 0)
            return -1;
        taken++;
        row_path += length + (row_path[length] == '/');
    }
    return taken;
}

/* Narrows the position to an attribute. If the path has steps from `from` on, narrows it to one
 * number of the attribute. */
static void narrow(const struct pen_xml *xml, const struct pen_xml_span *span,
                   enum pen_xml_shape shape, const struct path *path, size_t from,
                   struct position *position)
{
    position->at = span->name;
    position->start = span->value;
    position->end = span->end;
    bool points = shape == PEN_XML_POINTS;
    if (from >= path->count || memchr(xml->text + span->value, '&', span->end - span->value))
        return;
    size_t index = index_of(path->step[from]) * (points ? 3 : 1), start, end;
    if (points && from + 1 < path->count)
        index += index_of(path->step[from + 1]);
    if (!pen_xml_token(xml->text + span->value, span->end - span->value, index, &start, &end))
        return;
    position->at = position->start = span->value + start;
    position->end = span->value + end;
}

/* Finds the attribute of the position's element that has the value at the path, whose first `used`
 * steps lead to the element. Returns false if the tag has no such attribute. */
static bool find_attribute(const struct pen_xml *xml, const struct path *path, size_t used,
                           struct position *position)
{
    struct pen_xml_span span;
    struct pen_xml_row row;
    struct pen_text written;
    size_t at = pen_xml_attributes_begin(xml, position->tag);
    while (pen_xml_attribute_next(xml, &at, &span)) {
        if (!pen_xml_attribute_row(xml, &span, position->element, &written, &row))
            continue;
        int taken = match_path(row.path, path, used);
        if (taken < 0)
            continue;
        position->name = written;
        narrow(xml, &span, row.shape, path, used + (size_t)taken, position);
        return true;
    }
    return false;
}

/* Finds render/width or render/height in the attribute `image` of the camera. */
static bool find_image(struct pen_xml *xml, const struct path *path, struct position *position)
{
    const char *first = path->count == 2 ? path->step[0]->key : NULL;
    const char *second = path->count == 2 ? path->step[1]->key : NULL;
    if (xml->image == SIZE_MAX || !first || !second || strcmp(first, "render") != 0)
        return false;
    bool height = strcmp(second, "height") == 0;
    if (!height && strcmp(second, "width") != 0)
        return false;
    const struct pen_place image = {.key = "@image"}, index = {.index = height};
    const struct path element = {2, {&image, &index}};
    position->tag = xml->image;
    position->element = pen_xml_child_find(&pen_xml_scene, "camera");
    return find_attribute(xml, &element, 0, position);
}

/* A material may be an element whose members are in part attributes of the enclosing element. So if
 * the innermost element has no attribute for the place, the enclosing one may have it. */
static struct position resolve(struct pen_xml *xml, const struct pen_place *at)
{
    struct path path = path_of(at);
    struct position position = {0};
    size_t used = find_element(xml, &path, path.count, &position);
    if (find_attribute(xml, &path, used, &position))
        return position;
    struct position around = {0};
    if (used > 0 &&
        find_attribute(xml, &path, find_element(xml, &path, used - 1, &around), &around))
        return around;
    find_image(xml, &path, &position);
    return position;
}

static bool is_reported(void *user, const struct pen_place *at)
{
    struct pen_xml *xml = user;
    struct path path = path_of(at);
    struct position position = {0};
    find_element(xml, &path, path.count, &position);
    return position.reported;
}

static void fail_at(void *user, const struct pen_place *at, enum pen_code code, const char *message,
                    struct pen_status *st)
{
    struct pen_xml *xml = user;
    struct position position = resolve(xml, at);
    int line, column;
    pen_text_position(xml->text, position.at, &line, &column);
    struct pen_text tag = pen_xml_tag_name(xml->text, xml->bytes, position.tag);
    if (position.name.text[0])
        pen_fail_line(st, code, line, column, "attribute \"%s\" of <%s>: %s", position.name.text,
                      tag.text, message);
    else
        pen_fail_line(st, code, line, column, "<%s>: %s", tag.text, message);
}

static struct pen_text text_found(void *user, const struct pen_place *at, const json_t *value)
{
    struct pen_xml *xml = user;
    enum { SHOWN = 160 };
    struct position position = resolve(xml, at);
    struct pen_text raw, out;
    if (position.end == position.start)
        return position.name.text[0] ? (struct pen_text){"nothing"} : pen_text_value(value);
    size_t bytes = position.end - position.start < SHOWN ? position.end - position.start : SHOWN;
    memcpy(raw.text, xml->text + position.start, bytes);
    raw.text[bytes] = '\0';
    if (!json_is_number(value))
        return pen_text_quote(raw.text);
    pen_utf8_copy(out.text, sizeof out.text, raw.text);
    return out;
}

static struct pen_text attribute_name(void *user, const struct pen_place *up, const char *key)
{
    struct pen_xml *xml = user;
    struct path path = path_of(up);
    struct position position = {0};
    struct pen_xml_row rows[PEN_XML_NAMES_MAX];
    if (path.count == STEPS_MAX)
        return pen_text_quote(key);
    const struct pen_place last = pen_place_key(up, key);
    size_t used = find_element(xml, &path, path.count, &position);
    path.step[path.count++] = &last;
    if (find_attribute(xml, &path, used, &position))
        return pen_text_quote(position.name.text);
    size_t count = pen_xml_rows(position.element, rows);
    size_t length = strlen(key);
    for (size_t i = 0; i < count; i++) {
        bool first = used + 1 == path.count && strncmp(rows[i].path, key, length) == 0 &&
                     rows[i].path[length] == '/';
        if (first || (rows[i].path[0] && match_path(rows[i].path, &path, used) >= 0))
            return pen_text_quote(rows[i].name);
    }
    return pen_text_quote(key);
}

static void position_text(void *user, const struct pen_place *at, char *out, size_t bytes)
{
    struct pen_xml *xml = user;
    struct position position = resolve(xml, at);
    int line, column;
    pen_text_position(xml->text, position.at, &line, &column);
    snprintf(out, bytes, "line %d, column %d", line, column);
}

struct pen_source_map pen_xml_source_map(struct pen_xml *xml)
{
    return (struct pen_source_map){.user = xml,
                                   .is_reported = is_reported,
                                   .fail = fail_at,
                                   .found = text_found,
                                   .name = attribute_name,
                                   .position = position_text};
}

/* Splits a JSON Pointer into steps, unescaped in place. The last step of a truncated pointer may be
 * incomplete. Returns the number of steps, including one for the document. */
static size_t split(char *pointer, struct pen_place steps[PEN_AT_BYTES])
{
    size_t count = 0;
    steps[count++] = (struct pen_place){0};
    for (bool more = *pointer == '/'; more; count++) {
        char *key = ++pointer, *out = key;
        for (; *pointer && *pointer != '/'; pointer++) {
            bool escape = *pointer == '~' && (pointer[1] == '0' || pointer[1] == '1');
            *out++ = escape ? (pointer[1] == '0' ? '~' : '/') : *pointer;
            pointer += escape;
        }
        more = *pointer == '/';
        *out = '\0';
        steps[count] = pen_place_key(&steps[count - 1], key);
    }
    return count;
}

void pen_xml_locate(struct pen_xml *xml, struct pen_status *st)
{
    char pointer[PEN_AT_BYTES];
    struct pen_place steps[PEN_AT_BYTES];
    struct pen_status out;
    bool about_text = st->code == PEN_OK || st->code == PEN_INVALID ||
                      st->code == PEN_UNSUPPORTED || st->code == PEN_TOO_LARGE;
    if (st->line > 0 || !about_text)
        return;
    memcpy(pointer, st->at, sizeof pointer);
    size_t count = split(pointer, steps);
    fail_at(xml, &steps[count - 1], st->code, st->msg, &out);
    *st = out;
}
