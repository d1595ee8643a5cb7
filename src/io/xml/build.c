/* SPDX-License-Identifier: MIT */
/* Makes the JSON value of one element or attribute at a time, and adds the defaults that the XML
 * format has beyond those of the JSON format. */
#include "io/xml/build.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/json/memory.h"
#include "io/scene/object.h"
#include "io/xml/values.h"
#include "math/exact_sum.h"

/* The memory of containers, as estimated by io/json/memory.h. */
enum {
    OBJECT = PEN_JSON_OBJECT_BYTES,
    ARRAY = PEN_JSON_ARRAY_BYTES,
    TRIPLE = ARRAY + 3 * PEN_JSON_ELEMENT_BYTES, /* without its elements' values */
    NUMBERS = TRIPLE + 3 * PEN_JSON_NUMBER_BYTES,
    CORNERS = TRIPLE + 3 * NUMBERS
};

static size_t member_bytes(const char *key)
{
    return PEN_JSON_MEMBER_BYTES + strlen(key);
}

/* Follows all steps of *path except the last from `object`, and makes containers that are missing.
 * Returns the last container, and *path becomes the last step. NULL if a value on the path is not a
 * container, or after an error. */
static json_t *descend(struct pen_xml_builder *b, json_t *object, const char **path)
{
    for (const char *slash; object && (slash = strchr(*path, '/')); *path = slash + 1) {
        char key[PEN_XML_PATH_BYTES];
        snprintf(key, sizeof key, "%.*s", (int)(slash - *path), *path);
        bool list = slash[1] >= '0' && slash[1] <= '9';
        json_t *inner = json_object_get(object, key);
        if (!inner && pen_xml_reserve(b, member_bytes(key) + (list ? TRIPLE : OBJECT))) {
            inner = pen_xml_check_value(b, list ? json_pack("[n, n, n]") : json_object());
            pen_xml_require(b, inner && json_object_set_new(object, key, inner) == 0);
        }
        object =
            !b->stopped && (list ? json_is_array(inner) : json_is_object(inner)) ? inner : NULL;
    }
    return object;
}

/* A primitive's attribute `material` and the attributes of its own material have the same key in
 * JSON. */
static void refuse_both(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                        const char *name)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = name};
    pen_xml_attribute_error(
        b, &ref,
        "\"material\" and the attributes of a material exclude each other, found "
        "both");
}

/* Stores the value at the row's path; takes ownership of it. */
static void store(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                  const struct pen_xml_row *row, json_t *value)
{
    const char *step = row->path;
    json_t *at = descend(b, frame->object, &step);
    bool taken = !at || (json_is_object(at) && json_object_get(at, step));
    if (!taken && json_is_object(at))
        pen_xml_reserve(b, member_bytes(step));
    if (b->stopped || taken)
        json_decref(value);
    if (b->stopped)
        return;
    if (taken)
        refuse_both(b, frame, row->name);
    else if (json_is_array(at))
        pen_xml_require(b, json_array_set_new(at, strtoul(step, NULL, 10), value) == 0);
    else
        pen_xml_require(b, json_object_set_new(at, step, value) == 0);
}

/* The attribute's value; JSON null after an error has been reported. NULL only when parsing has
 * stopped. */
static json_t *read_value(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                          const struct pen_xml_row *row, const char *text)
{
    struct pen_xml_value_error error;
    json_t *value = pen_xml_value(row->shape, text, &b->numbers, &b->bytes_left, &error);
    if (error.over_limit && !pen_xml_reserve(b, SIZE_MAX))
        return NULL;
    if (value || error.no_memory)
        return pen_xml_check_value(b, value);
    const struct pen_xml_attribute_ref ref = {
        .frame = frame, .name = row->name, .value = text, .offset = error.offset};
    pen_xml_attribute_error(b, &ref, "%s", error.msg.text);
    return json_null();
}

void pen_xml_attribute_read(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const char *name, const char *text)
{
    struct pen_xml_row row;
    if (!pen_xml_row_find(frame->element, name, &row)) {
        pen_xml_unknown_attribute(b, frame, name);
        return;
    }
    if (row.path[0] == '\0' || strcmp(row.path, "@name") == 0)
        return; /* the element's value, or its name: pen_xml_build has read it */
    json_t *value = read_value(b, frame, &row, text);
    if (value && strcmp(row.path, "@image") == 0) {
        b->image = value;
        b->xml->image = frame->tag;
    } else if (value) {
        store(b, frame, &row, value);
    }
}

static const char *attribute(const char *const *attributes, const char *name)
{
    for (; *attributes; attributes += 2) {
        if (strcmp(attributes[0], name) == 0)
            return attributes[1];
    }
    return NULL;
}

static const char *const corner_names[] = {"p0", "p1", "p2"};

/* Reports which of p0, p1, p2 are missing. Returns whether all are there. */
static bool has_corners(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                        const char *const *attributes)
{
    bool all = true;
    for (int i = 0; i < 3; i++) {
        if (attribute(attributes, corner_names[i]))
            continue;
        pen_xml_missing_attribute(b, frame, corner_names[i]);
        all = false;
    }
    return all;
}

static void finish_triangle(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const char *const *attributes)
{
    if (!has_corners(b, frame, attributes))
        pen_xml_require(b, json_object_set_new(frame->object, "vertices", json_null()) == 0);
}

/* Reads a corner as a vector; reports values that are not numbers of a scene. */
static bool read_corner(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                        const json_t *triple, const char *name, struct pen_vec3 *out)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = name};
    double v[3];
    for (size_t k = 0; k < 3; k++) {
        const json_t *value = json_array_get(triple, k);
        v[k] = json_is_number(value) ? json_number_value(value) : NAN;
        if (fabs(v[k]) <= PEN_NUMBER_MAX)
            continue;
        if (value) /* NULL: the whole attribute has been reported */
            pen_xml_attribute_error(b, &ref, "must be 3 numbers up to 1e100 in magnitude, found %s",
                                    json_is_string(value)
                                        ? pen_text_quote(json_string_value(value)).text
                                        : pen_text_value(value).text);
        return false;
    }
    *out = pen_vec3(v[0], v[1], v[2]);
    return true;
}

static bool read_corners(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const char *const *attributes, struct pen_vec3 p[3])
{
    const json_t *corners = json_object_get(frame->object, "corners");
    if (attribute(attributes, "point") || attribute(attributes, "normal")) {
        pen_xml_error(b, frame->tag, PEN_INVALID,
                      "<plane>: \"p0\", \"p1\", \"p2\" and \"point\", \"normal\" exclude each "
                      "other, found both");
        return false;
    }
    bool ok = has_corners(b, frame, attributes);
    for (size_t i = 0; i < 3 && ok; i++)
        ok = read_corner(b, frame, json_array_get(corners, i), corner_names[i], &p[i]);
    if (!ok || pen_points_have_area(p))
        return ok;
    pen_xml_error(b, frame->tag, PEN_INVALID,
                  "<plane>: \"p0\", \"p1\" and \"p2\" must be three points that are not on one "
                  "line");
    return false;
}

static json_t *vector(struct pen_vec3 v)
{
    return json_pack("[f, f, f]", v.x, v.y, v.z);
}

/* Converts p0, p1, p2 to a point and the normal on the side from which they run counter-clockwise.
 */
static void finish_plane(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const char *const *attributes)
{
    struct pen_vec3 p[3];
    if (!json_object_get(frame->object, "corners"))
        return;
    bool ok = read_corners(b, frame, attributes, p);
    if (ok) /* the corners are deleted */
        b->bytes_left += member_bytes("corners") + CORNERS;
    if (!pen_xml_reserve(b, member_bytes("point") + member_bytes("normal") + 2 * NUMBERS))
        return;
    json_t *point = ok ? vector(p[0]) : json_null();
    json_t *normal = ok ? vector(pen_exact_normal(p, 3)) : json_null();
    pen_xml_require(b, json_object_set_new(frame->object, "point", point) == 0);
    pen_xml_require(b, json_object_set_new(frame->object, "normal", normal) == 0);
    json_object_del(frame->object, "corners");
}

static void finish_group(struct pen_xml_builder *b, struct pen_xml_frame *frame)
{
    if (!pen_xml_reserve(b, member_bytes("objects") + ARRAY))
        return;
    json_t *list = json_array();
    pen_xml_require(b, list && json_object_set_new(frame->object, "objects", list) == 0);
    if (!b->stopped)
        pen_xml_require(b, pen_xml_record(b->xml, list, frame->element, frame->tag));
    frame->list = list;
}

void pen_xml_finish(struct pen_xml_builder *b, struct pen_xml_frame *frame,
                    const char *const *attributes)
{
    switch (frame->element->finish) {
    case PEN_XML_FINISH_NONE:
        break;
    case PEN_XML_TRIANGLE:
        finish_triangle(b, frame, attributes);
        break;
    case PEN_XML_PLANE:
        finish_plane(b, frame, attributes);
        break;
    case PEN_XML_GROUP:
        finish_group(b, frame);
        break;
    }
}

/* Adds a member and takes ownership of the value. Reports a second element with the same key.
 * Returns the value, or NULL. */
static json_t *add_member(struct pen_xml_builder *b, json_t *object, const char *key, json_t *value,
                          const struct pen_xml_frame *frame)
{
    if (value && json_object_get(object, key)) {
        json_decref(value);
        pen_xml_error(b, frame->tag, PEN_INVALID, "duplicate element <%s>: there is one already",
                      frame->element->name);
        return NULL;
    }
    if (value && !pen_xml_reserve(b, member_bytes(key))) {
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

/* The attribute of the parent's element whose value is where the element's object would be. */
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

/* Adds an object at the path that is the element's key. Reports an attribute that has the same
 * place, or one on the way, which is `material`. Returns the object, or NULL. */
static json_t *add_object(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                          const struct pen_xml_frame *frame)
{
    struct pen_xml_row rows[PEN_XML_NAMES_MAX];
    const char *step = frame->element->key;
    json_t *at = descend(b, up->object, &step), *old = at ? json_object_get(at, step) : NULL;
    if (b->stopped)
        return NULL;
    if (at && (!old || json_is_object(old)))
        return add_member(b, at, step, new_object(b), frame);
    pen_xml_error(b, frame->tag, PEN_INVALID, "<%s> excludes the attribute \"%s\", found both",
                  frame->element->name, at ? attribute_in_place(up, frame, rows) : "material");
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

/* The value of an element whose only attribute is its value; reports a missing one and returns JSON
 * null. */
static json_t *own_value(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const char *const *attributes)
{
    struct pen_xml_row row;
    const char *name = frame->element->own->name, *text = attribute(attributes, name);
    if (text && pen_xml_row_find(frame->element, name, &row))
        return read_value(b, frame, &row, text);
    pen_xml_missing_attribute(b, frame, name);
    return json_null();
}

static json_t *new_list(struct pen_xml_builder *b)
{
    return pen_xml_reserve(b, ARRAY) ? json_array() : NULL;
}

/* A new object for a list; NULL as `type` makes an empty one. */
static json_t *new_item(struct pen_xml_builder *b, const char *type)
{
    if (!type)
        return new_object(b);
    size_t bytes = OBJECT + member_bytes("type") + PEN_JSON_STRING_BYTES + strlen(type);
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
                         const struct pen_xml_frame *frame, const char *const *attributes)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = "name"};
    const char *name = attribute(attributes, "name");
    if (!name)
        pen_xml_missing_attribute(b, frame, "name");
    else if (json_object_get(up->object, name))
        pen_xml_attribute_error(b, &ref, "must be unique, there is one named %s already",
                                pen_text_quote(name).text);
    else
        return add_member(b, up->object, name, new_object(b), frame);
    return NULL;
}

json_t *pen_xml_build(struct pen_xml_builder *b, const struct pen_xml_frame *up,
                      struct pen_xml_frame *frame, const char *const *attributes)
{
    const struct pen_xml_element *e = frame->element;
    switch (e->build) {
    case PEN_XML_ROOT:
        return frame->object = b->document;
    case PEN_XML_MEMBER_OBJECT:
        return frame->object = add_object(b, up, frame);
    case PEN_XML_MEMBER_LIST:
        return frame->list = add_member(b, up->object, e->key, new_list(b), frame);
    case PEN_XML_MEMBER_VALUE:
        return add_member(b, up->object, e->key, own_value(b, frame, attributes), frame);
    case PEN_XML_ITEM:
        return frame->object = add_item(b, up->list, new_item(b, e->key));
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

/* Adds a member unless the object has it; takes ownership of the value. */
static void add_default(struct pen_xml_builder *b, json_t *object, const char *key, json_t *value)
{
    pen_xml_require(b, value != NULL);
    if (!b->stopped && !json_object_get(object, key))
        pen_xml_require(b, json_object_set(object, key, value) == 0);
    json_decref(value);
}

/* Applies the camera's `image` as the render settings width and height; reports it beside those. */
static void apply_image(struct pen_xml_builder *b, const struct pen_xml_frame *camera,
                        json_t *render)
{
    static const char *const keys[] = {"width", "height"};
    const struct pen_xml_attribute_ref ref = {.frame = camera, .name = "image"};
    bool pair = json_is_array(b->image);
    for (size_t i = 0; i < 2 && b->image && !b->stopped; i++) {
        json_t *value = pair ? json_array_get(b->image, i) : b->image;
        if (json_object_get(render, keys[i]))
            pen_xml_attribute_error(b, &ref, "excludes \"%s\" of <render>, found both", keys[i]);
        else
            pen_xml_require(b, json_object_set(render, keys[i], value) == 0);
    }
}

/* The scene's `render` object. If there is no element, it is recorded as made from *from, so that
 * errors have a position. */
static json_t *render_settings(struct pen_xml_builder *b, const struct pen_xml_frame *from)
{
    json_t *render = json_object_get(b->document, "render");
    if (render)
        return render;
    render = json_object();
    pen_xml_require(b, render && json_object_set_new(b->document, "render", render) == 0);
    if (!b->stopped)
        pen_xml_require(b, pen_xml_record(b->xml, render, from->element, from->tag));
    return render;
}

static void add_defaults(struct pen_xml_builder *b)
{
    const struct pen_xml_frame camera = {.element = pen_xml_child_find(&pen_xml_scene, "camera"),
                                         .tag = b->xml->image};
    json_t *render = render_settings(b, b->image ? &camera : &b->frame[0]);
    if (b->stopped)
        return;
    apply_image(b, &camera, render);
    if (!json_object_get(b->document, "camera")) {
        add_default(b, render, "width", json_integer(1000));
        add_default(b, render, "height", json_integer(1000));
        add_default(b, b->document, "camera",
                    json_pack("{s:[i,i,i], s:[i,i,i], s:{s:i, s:i, s:i}}", "position", 0, 0, 0,
                              "direction", 0, 0, -1, "view_plane", "distance", 100, "width", 500,
                              "height", 500));
    }
    add_default(b, render, "transfer", json_string("display"));
    add_default(b, b->document, "format", json_string("penumbra-scene/1"));
}

static void put_in_order(struct pen_xml_builder *b)
{
    static const char *const keys[] = {"format",  PEN_COMMENT_KEY, "name",  "background",
                                       "ambient", "camera",        "views", "materials",
                                       "lights",  "objects",       "render"};
    json_t *document = json_object();
    pen_xml_require(b, document != NULL);
    for (size_t i = 0; i < sizeof keys / sizeof keys[0] && !b->stopped; i++) {
        json_t *value = json_object_get(b->document, keys[i]);
        pen_xml_require(b, !value || json_object_set(document, keys[i], value) == 0);
    }
    if (!b->stopped)
        pen_xml_require(b, pen_xml_record(b->xml, document, &pen_xml_scene, b->frame[0].tag));
    json_decref(b->document);
    b->document = document;
}

void pen_xml_document_end(struct pen_xml_builder *b)
{
    add_defaults(b);
    if (!b->stopped)
        put_in_order(b);
}
