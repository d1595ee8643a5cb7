/* SPDX-License-Identifier: MIT */
/* Makes the JSON value of one element or attribute at a time. A value may be given twice, by two
 * names of one attribute or by an attribute and an element, if both are equal. */
#include "io/xml/build.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene/reader.h"
#include "io/xml/values.h"

enum { OBJECT = PEN_JSON_OBJECT_BYTES, ARRAY = PEN_JSON_ARRAY_BYTES };

const struct pen_xml_given *pen_xml_given_at(const struct pen_xml_given_list *list,
                                             const char *path)
{
    for (size_t i = 0; i < list->count; i++)
        if (list->item[i].known && strcmp(list->item[i].row.path, path) == 0)
            return &list->item[i];
    return NULL;
}

/* Follows all steps of *path except the last from `object`, and makes missing containers. Returns
 * the last container, and *path becomes the last step. Returns NULL if a value on the path is not a
 * container, or after an error. */
static json_t *descend(struct pen_xml_builder *b, json_t *object, const char **path)
{
    for (const char *slash; object && (slash = strchr(*path, '/')); *path = slash + 1) {
        char key[PEN_XML_PATH_BYTES];
        snprintf(key, sizeof key, "%.*s", (int)(slash - *path), *path);
        bool list = slash[1] >= '0' && slash[1] <= '9';
        json_t *inner = json_object_get(object, key);
        if (!inner && pen_xml_reserve(b, pen_xml_member_bytes(key) +
                                             (list ? PEN_XML_TRIPLE_BYTES : OBJECT))) {
            inner = pen_xml_check_value(b, list ? json_pack("[n, n, n]") : json_object());
            pen_xml_require(b, inner && json_object_set_new(object, key, inner) == 0);
        }
        object =
            !b->stopped && (list ? json_is_array(inner) : json_is_object(inner)) ? inner : NULL;
    }
    return object;
}

/* Whether two values are the same: for example 1 and 1.0, or a number and three of it. */
static bool is_same(const json_t *a, const json_t *b)
{
    if (json_is_number(a) && json_is_number(b))
        return json_number_value(a) == json_number_value(b);
    if (json_is_number(a) && json_is_array(b))
        return is_same(b, a);
    if (!json_is_array(a) || (json_is_array(b) && json_array_size(a) != json_array_size(b)))
        return json_equal(a, b);
    for (size_t i = 0; i < json_array_size(a); i++)
        if (!is_same(json_array_get(a, i), json_is_array(b) ? json_array_get(b, i) : b))
            return false;
    return true;
}

/* Merges a value with the earlier value at its place. The elements of lists, which may have been
 * given in parts, are merged one by one; JSON null is a missing part. Returns false if they differ.
 * *index is the number of the differing element, SIZE_MAX if they are no such lists. */
static bool merge(struct pen_xml_builder *b, json_t *old, json_t *value, size_t *index)
{
    *index = SIZE_MAX;
    if (!json_is_array(old) || !json_is_array(value) ||
        json_array_size(old) != json_array_size(value))
        return is_same(old, value);
    for (*index = 0; *index < json_array_size(old); ++*index) {
        json_t *was = json_array_get(old, *index), *is = json_array_get(value, *index);
        if (json_is_null(was))
            pen_xml_require(b, json_array_set(old, *index, is) == 0);
        else if (!json_is_null(is) && !is_same(was, is))
            return false;
    }
    return true;
}

/* Reports both: a primitive's attribute `material` and the attributes of its own material have the
 * same key in JSON. */
static void refuse_both(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                        const char *name)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = name};
    pen_xml_attribute_error(
        b, &ref,
        "\"material\" and the attributes of a material exclude each other, found "
        "both");
}

/* Merges the value with the earlier one at its place, and reports a difference. A value with an
 * earlier error is JSON null and is not reported again. */
static void add_again(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                      const struct pen_xml_given *given, json_t *old, json_t *value)
{
    char path[PEN_XML_PATH_BYTES + 24];
    size_t index;
    if (json_is_null(old) || json_is_null(value) || merge(b, old, value, &index))
        return;
    snprintf(path, sizeof path, index == SIZE_MAX ? "%s" : "%s/%zu", given->row.path, index);
    if (json_is_string(value) && json_is_object(old))
        refuse_both(b, frame, given->name);
    else
        pen_xml_conflict(b, frame, given, path, old);
}

/* Appends JSON null until the list has an element `index`. */
static void lengthen(struct pen_xml_builder *b, json_t *list, size_t index)
{
    while (!b->stopped && json_array_size(list) <= index &&
           pen_xml_reserve(b, PEN_JSON_ELEMENT_BYTES))
        pen_xml_require(b, json_array_append_new(list, json_null()) == 0);
}

/* Whether the value is a part after the end of a list that another attribute gives as a whole. */
static bool is_beyond(const struct pen_xml_given_list *attributes, const char *path,
                      const json_t *list, size_t index)
{
    char whole[PEN_XML_PATH_BYTES];
    snprintf(whole, sizeof whole, "%.*s", (int)(strrchr(path, '/') - path), path);
    return index >= json_array_size(list) && pen_xml_given_at(attributes, whole);
}

/* Stores the value at the path of its row; takes ownership of it. */
static void store(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                  const struct pen_xml_given_list *attributes, const struct pen_xml_given *given,
                  json_t *value)
{
    const char *path = given->row.path, *step = path;
    json_t *at = descend(b, frame->object, &step);
    const size_t index = strtoul(step, NULL, 10);
    bool beyond = json_is_array(at) && is_beyond(attributes, path, at, index);
    if (json_is_array(at) && !beyond)
        lengthen(b, at, index);
    json_t *old = json_is_array(at) ? json_array_get(at, index) : json_object_get(at, step);
    if (b->stopped || (!at && !json_is_string(json_object_get(frame->object, "material"))))
        ; /* or an error about a value on the path has been reported */
    else if (!at)
        refuse_both(b, frame, given->name);
    else if (beyond)
        pen_xml_conflict(b, frame, given, path, at);
    else if (json_is_array(at) && json_is_null(old))
        pen_xml_require(b, json_array_set(at, index, value) == 0);
    else if (old)
        add_again(b, frame, given, old, value);
    else if (pen_xml_reserve(b, pen_xml_member_bytes(step)))
        pen_xml_require(b, json_object_set(at, step, value) == 0);
    json_decref(value);
}

/* The attribute's value; NULL if it has none, for the reason in *error, or if parsing has stopped.
 */
static json_t *parse_value(struct pen_xml_builder *b, const struct pen_xml_given *given,
                           enum pen_xml_shape shape, struct pen_xml_value_error *error)
{
    json_t *value = pen_xml_value(shape, given->text, &b->numbers, &b->bytes_left, error);
    if (error->over_limit)
        pen_xml_reserve(b, SIZE_MAX);
    if (value || error->no_memory)
        return pen_xml_check_value(b, value);
    return NULL;
}

/* The attribute's value; JSON null after an error has been reported. NULL only when parsing has
 * stopped. */
static json_t *read_value(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                          const struct pen_xml_given *given, enum pen_xml_shape shape)
{
    struct pen_xml_value_error error;
    json_t *value = parse_value(b, given, shape, &error);
    if (value || b->stopped)
        return value;
    const struct pen_xml_attribute_ref ref = {
        .frame = frame, .name = given->name, .value = given->text, .offset = error.offset};
    pen_xml_attribute_error(b, &ref, "%s", error.msg.text);
    return json_null();
}

/* Whether two attributes have the same text, or texts of the same value. Errors in a text are
 * reported elsewhere. */
static bool says_same(struct pen_xml_builder *b, const struct pen_xml_given *first,
                      const struct pen_xml_given *again)
{
    struct pen_xml_value_error error;
    if (strcmp(first->text, again->text) == 0)
        return true;
    json_t *x = parse_value(b, first, first->row.shape, &error);
    json_t *y = parse_value(b, again, again->row.shape, &error);
    const bool same = b->stopped || (x && y && is_same(x, y));
    json_decref(x);
    json_decref(y);
    return same;
}

void pen_xml_attribute_read(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const struct pen_xml_given_list *attributes,
                            const struct pen_xml_given *given)
{
    const char *path = given->row.path;
    if (!given->known) {
        pen_xml_unknown_attribute(b, frame, given->name);
    } else if (path[0] == '\0' || path[0] == '@') {
        const struct pen_xml_given *first = pen_xml_given_at(attributes, path);
        if (!says_same(b, first, given)) {
            pen_xml_conflict(b, frame, given, path, NULL);
        } else if (first == given && strcmp(path, "@image") == 0) {
            b->image = read_value(b, frame, given, given->row.shape);
            b->xml->image = frame->tag;
        } /* the element's value, its factor and its name, which pen_xml_build has read */
    } else {
        json_t *value = read_value(b, frame, given, given->row.shape);
        if (value)
            store(b, frame, attributes, given, value);
    }
}

/* Adds a member and takes ownership of the value. Reports a second element with the same key.
 * Returns the value, or NULL. */
static json_t *add_member(struct pen_xml_builder *b, json_t *object, const char *key, json_t *value,
                          const struct pen_xml_frame *frame)
{
    json_t *old = json_object_get(object, key);
    if (value && old) {
        json_decref(value);
        pen_xml_duplicate(b, frame, old);
        return NULL;
    }
    if (value && !pen_xml_reserve(b, pen_xml_member_bytes(key))) {
        json_decref(value);
        return NULL;
    }
    bool done = value && json_object_set_new(object, key, value) == 0;
    pen_xml_require(b, done);
    return done ? value : NULL;
}

static json_t *new_object(struct pen_xml_builder *b)
{
    return pen_xml_reserve(b, OBJECT) ? json_object() : NULL;
}

/* The attribute of the parent's element that has the place of the element's object. */
static const char *attribute_in_place(const struct pen_xml_frame *up,
                                      const struct pen_xml_frame *frame,
                                      struct pen_xml_row rows[PEN_XML_NAMES_MAX])
{
    size_t count = pen_xml_rows(up->element, rows);
    for (size_t i = 0; i < count; i++)
        if (strcmp(rows[i].path, frame->element->key) == 0)
            return rows[i].name;
    return "material";
}

/* Adds an object at the path that is the element's key, or takes the one that the parent's
 * attributes have made. Reports an attribute that has the same place, or an attribute on the path,
 * which is `material`. Returns the object, or NULL. */
static json_t *add_object(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                          const struct pen_xml_frame *frame)
{
    struct pen_xml_row rows[PEN_XML_NAMES_MAX];
    const char *step = frame->element->key;
    json_t *at = descend(b, up->object, &step), *old = at ? json_object_get(at, step) : NULL;
    if (b->stopped)
        return NULL;
    if (frame->element->build == PEN_XML_MEMBER_MORE && json_is_object(old) &&
        !pen_xml_latest(b->xml, old, up->tag))
        return old;
    if (at && (!old || json_is_object(old)))
        return add_member(b, at, step, new_object(b), frame);
    pen_xml_error(b, frame->tag, PEN_INVALID, "<%s> excludes the attribute \"%s\", found both",
                  pen_xml_tag_name(b->xml->text, b->xml->bytes, frame->tag).text,
                  at ? attribute_in_place(up, frame, rows) : "material");
    return NULL;
}

/* Adds an element to a list and takes ownership of the value. Returns the value, or NULL. */
static json_t *add_item(struct pen_xml_builder *b, json_t *list, json_t *value)
{
    if (value && !pen_xml_reserve(b, PEN_JSON_ELEMENT_BYTES)) {
        json_decref(value);
        return NULL;
    }
    bool done = value && json_array_append_new(list, value) == 0;
    pen_xml_require(b, done);
    return done ? value : NULL;
}

/* Whether the value is a factor of a colour, or three: each a number that is not negative. */
static bool is_factor(const json_t *value)
{
    for (size_t i = 0; json_is_array(value) && i < json_array_size(value); i++)
        if (!is_factor(json_array_get(value, i)))
            return false;
    return json_is_array(value) || (json_is_number(value) && json_number_value(value) >= 0 &&
                                    json_number_value(value) <= PEN_NUMBER_MAX);
}

/* The colour times its factor, both in the units of the document. */
static json_t *read_product(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const struct pen_xml_given *colour, const struct pen_xml_given *factor)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = factor->name};
    json_t *k = read_value(b, frame, factor, factor->row.shape);
    json_t *value = k ? read_value(b, frame, colour, PEN_XML_TRIPLE) : NULL;
    if (k && !json_is_null(k) && !is_factor(k))
        pen_xml_attribute_error(b, &ref,
                                "must be a number that is not negative, or 3 of them (red, green, "
                                "blue), found %s",
                                pen_text_quote(factor->text).text);
    for (size_t i = 0; is_factor(k) && i < json_array_size(value); i++) {
        const json_t *number = json_array_get(value, i);
        const double part = json_number_value(json_is_array(k) ? json_array_get(k, i) : k) *
                            json_number_value(number) / 255;
        if (json_is_number(number) && !b->stopped)
            pen_xml_require(b, json_array_set_new(value, i, json_real(part)) == 0);
    }
    json_decref(k);
    return value;
}

/* The value of an element whose attribute is its value; reports a missing one and returns JSON
 * null. */
static json_t *own_value(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const struct pen_xml_given_list *attributes)
{
    const struct pen_xml_given *value = pen_xml_given_at(attributes, "");
    const struct pen_xml_given *factor = pen_xml_given_at(attributes, "@factor");
    if (value && factor)
        return read_product(b, frame, value, factor);
    if (value)
        return read_value(b, frame, value, value->row.shape);
    pen_xml_missing_attribute(b, frame, frame->element->own->name);
    return json_null();
}

static json_t *new_list(struct pen_xml_builder *b)
{
    return pen_xml_reserve(b, ARRAY) ? json_array() : NULL;
}

/* A new object for a list; if `type` is NULL, it is empty. */
static json_t *new_item(struct pen_xml_builder *b, const char *type)
{
    if (!type)
        return new_object(b);
    size_t bytes = OBJECT + pen_xml_member_bytes("type") + PEN_JSON_STRING_BYTES + strlen(type);
    return pen_xml_reserve(b, bytes) ? json_pack("{s:s}", "type", type) : NULL;
}

/* Adds an object with a single member to a list and takes ownership of the value. */
static json_t *add_single_member_item(struct pen_xml_builder *b, json_t *list, json_t *value,
                                      const struct pen_xml_frame *frame)
{
    json_t *wrapper = add_item(b, list, new_object(b));
    if (wrapper)
        return add_member(b, wrapper, frame->element->key, value, frame);
    json_decref(value);
    return NULL;
}

/* Adds an object under the element's `name`. Reports a missing or repeated name and returns NULL.
 */
static json_t *add_named(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                         const struct pen_xml_frame *frame,
                         const struct pen_xml_given_list *attributes)
{
    const struct pen_xml_given *name = pen_xml_given_at(attributes, "@name");
    if (!name) {
        pen_xml_missing_attribute(b, frame, "name");
        return NULL;
    }
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = name->name};
    if (!json_object_get(up->object, name->text))
        return add_member(b, up->object, name->text, new_object(b), frame);
    pen_xml_attribute_error(b, &ref, "must be unique, there is one named %s already",
                            pen_text_quote(name->text).text);
    return NULL;
}

/* The list of the scene for this element; made if there is none. */
static json_t *list_of_scene(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                             const char *key)
{
    json_t *list = json_object_get(up->object, key);
    if (list || !pen_xml_reserve(b, pen_xml_member_bytes(key) + ARRAY))
        return list;
    list = pen_xml_check_value(b, json_array());
    pen_xml_require(b, list && json_object_set_new(up->object, key, list) == 0);
    return b->stopped ? NULL : list;
}

/* The list that is the element's value. Lights before it may have made the list. */
static json_t *add_list(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                        const struct pen_xml_frame *frame)
{
    json_t *old = json_object_get(up->object, frame->element->key);
    if (json_is_array(old) && !pen_xml_latest(b->xml, old, 0))
        return old;
    return add_member(b, up->object, frame->element->key, new_list(b), frame);
}

json_t *pen_xml_build(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                      struct pen_xml_frame *frame, const struct pen_xml_given_list *attributes)
{
    const struct pen_xml_element *e = frame->element;
    switch (e->build) {
    case PEN_XML_ROOT:
        return frame->object = b->document;
    case PEN_XML_MEMBER_OBJECT:
    case PEN_XML_MEMBER_MORE:
        return frame->object = add_object(b, up, frame);
    case PEN_XML_MEMBER_LIST:
        return frame->list = add_list(b, up, frame);
    case PEN_XML_MEMBER_VALUE:
        return add_member(b, up->object, e->key, own_value(b, frame, attributes), frame);
    case PEN_XML_ITEM:
        return frame->object = add_item(b, up->list ? up->list : list_of_scene(b, up, e->list),
                                        new_item(b, e->key));
    case PEN_XML_ITEM_MEMBER:
        return frame->object = add_single_member_item(b, up->list, new_object(b), frame);
    case PEN_XML_ITEM_VALUE:
        return add_single_member_item(b, up->list, own_value(b, frame, attributes), frame);
    case PEN_XML_NAMED:
        return frame->object = add_named(b, up, frame, attributes);
    case PEN_XML_UNSUPPORTED:
        pen_xml_error(b, frame->tag, PEN_UNSUPPORTED, "<%s>: known, not supported yet: %s", e->name,
                      e->key);
        return NULL;
    }
    return NULL;
}
