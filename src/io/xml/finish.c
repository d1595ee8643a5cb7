/* SPDX-License-Identifier: MIT */
/* Completes elements after their attributes, and the document after all elements: missing parts,
 * planes by three points, and the defaults that only the XML format has. */
#include <math.h>
#include <stdio.h>

#include "io/scene/object.h"
#include "io/xml/build.h"
#include "math/exact_sum.h"

/* Reports the missing points among p0, p1, … of the list at `key`, up to the last given one and at
 * least to p2. Returns whether all of them are given. */
static bool has_points(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                       const struct pen_xml_given_list *attributes, const char *key)
{
    const size_t given = json_array_size(json_object_get(frame->object, key));
    bool all = true;
    for (size_t i = 0; i < given || i < 3; i++) {
        char path[PEN_XML_PATH_BYTES], name[24];
        snprintf(path, sizeof path, "%s/%zu", key, i);
        snprintf(name, sizeof name, "p%zu", i);
        if (pen_xml_given_at(attributes, path))
            continue;
        pen_xml_missing_attribute(b, frame, name);
        all = false;
    }
    return all;
}

static void finish_triangle(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                            const struct pen_xml_given_list *attributes)
{
    if (!has_points(b, frame, attributes, "vertices"))
        pen_xml_require(b, json_object_set_new(frame->object, "vertices", json_null()) == 0);
}

/* A polygon whose points are given one by one must have all of them from p0 on. */
static void finish_polygon(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                           const struct pen_xml_given_list *attributes)
{
    const json_t *vertices = json_object_get(frame->object, "vertices");
    if (json_is_array(vertices) && !pen_xml_given_at(attributes, "vertices"))
        finish_triangle(b, frame, attributes);
}

/* Missing parts of the attenuation get the values of [1, 0, 0]. */
static void finish_light(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const struct pen_xml_given_list *attributes)
{
    json_t *attenuation = json_object_get(frame->object, "attenuation");
    bool all_zero = json_is_array(attenuation) && !pen_xml_given_at(attributes, "attenuation");
    for (size_t i = 0; i < json_array_size(attenuation); i++) {
        if (json_is_null(json_array_get(attenuation, i)) &&
            pen_xml_reserve(b, PEN_JSON_NUMBER_BYTES))
            pen_xml_require(b, json_array_set_new(attenuation, i, json_integer(i == 0)) == 0);
        const json_t *part = json_array_get(attenuation, i);
        all_zero = all_zero && json_is_number(part) && json_number_value(part) == 0;
    }
    if (!all_zero)
        return;
    pen_xml_error(b, frame->tag, PEN_INVALID,
                  "<%s>: kc, kl and kq must not be all 0; kl and kq are 0 where they are left out",
                  pen_xml_tag_name(b->xml->text, b->xml->bytes, frame->tag).text);
    pen_xml_require(b, json_object_set_new(frame->object, "attenuation", json_null()) == 0);
}

/* Reads a point as a vector; reports values that are not numbers of a scene. */
static bool read_corner(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                        const json_t *triple, const struct pen_xml_given *given,
                        struct pen_vec3 *out)
{
    const struct pen_xml_attribute_ref ref = {.frame = frame, .name = given->name};
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

/* Reads the three points of a plane. The first is its point, whose other name is p0. */
static bool read_corners(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const struct pen_xml_given_list *attributes, struct pen_vec3 p[3])
{
    static const char *const paths[] = {"point", "corners/1", "corners/2"}, *const names[] = {
                                                                                "p0", "p1", "p2"};
    const json_t *corners = json_object_get(frame->object, "corners");
    if (pen_xml_given_at(attributes, "normal")) {
        pen_xml_error(b, frame->tag, PEN_INVALID,
                      "<plane>: \"p0\", \"p1\", \"p2\" and \"point\", \"normal\" exclude each "
                      "other, found both");
        return false;
    }
    bool ok = true;
    for (size_t i = 0; i < 3; i++) {
        if (pen_xml_given_at(attributes, paths[i]))
            continue;
        pen_xml_missing_attribute(b, frame, names[i]);
        ok = false;
    }
    for (size_t i = 0; i < 3 && ok; i++)
        ok = read_corner(
            b, frame, i == 0 ? json_object_get(frame->object, "point") : json_array_get(corners, i),
            pen_xml_given_at(attributes, paths[i]), &p[i]);
    if (!ok || pen_points_have_area(p))
        return ok;
    pen_xml_error(b, frame->tag, PEN_INVALID,
                  "<plane>: \"p0\", \"p1\" and \"p2\" must be three points that are not on one "
                  "line");
    return false;
}

/* Makes the normal. It is on the side from which p0, p1, p2 run counter-clockwise. */
static void finish_plane(struct pen_xml_builder *b, const struct pen_xml_frame *frame,
                         const struct pen_xml_given_list *attributes)
{
    enum { CORNERS = PEN_XML_TRIPLE_BYTES + 2 * PEN_XML_NUMBERS_BYTES };
    struct pen_vec3 p[3];
    if (!json_object_get(frame->object, "corners"))
        return;
    bool ok = read_corners(b, frame, attributes, p);
    if (ok) /* the corners are deleted */
        b->bytes_left += pen_xml_member_bytes("corners") + CORNERS;
    if (!pen_xml_reserve(b, pen_xml_member_bytes("normal") + PEN_XML_NUMBERS_BYTES))
        return;
    json_t *normal = json_null();
    if (ok) {
        struct pen_vec3 n = pen_exact_normal(p, 3);
        normal = json_pack("[f, f, f]", n.x, n.y, n.z);
    }
    pen_xml_require(b, json_object_set_new(frame->object, "normal", normal) == 0);
    if (!ok)
        pen_xml_require(b, json_object_set_new(frame->object, "point", json_null()) == 0);
    json_object_del(frame->object, "corners");
}

static void finish_group(struct pen_xml_builder *b, struct pen_xml_frame *frame)
{
    if (!pen_xml_reserve(b, pen_xml_member_bytes("objects") + PEN_JSON_ARRAY_BYTES))
        return;
    json_t *list = json_array();
    pen_xml_require(b, list && json_object_set_new(frame->object, "objects", list) == 0);
    if (!b->stopped)
        pen_xml_require(b, pen_xml_record(b->xml, list, frame->element, frame->tag));
    frame->list = list;
}

void pen_xml_finish(struct pen_xml_builder *b, struct pen_xml_frame *frame,
                    const struct pen_xml_given_list *attributes)
{
    switch (frame->element->finish) {
    case PEN_XML_FINISH_NONE:
        break;
    case PEN_XML_TRIANGLE:
        finish_triangle(b, frame, attributes);
        break;
    case PEN_XML_POLYGON:
        finish_polygon(b, frame, attributes);
        break;
    case PEN_XML_PLANE:
        finish_plane(b, frame, attributes);
        break;
    case PEN_XML_GROUP:
        finish_group(b, frame);
        break;
    case PEN_XML_LIGHT:
        finish_light(b, frame, attributes);
        break;
    }
}

/* Adds a member unless the object has it; takes ownership of the value. */
static void add_default(struct pen_xml_builder *b, json_t *object, const char *key, json_t *value)
{
    pen_xml_require(b, value != NULL);
    if (!b->stopped && !json_object_get(object, key))
        pen_xml_require(b, json_object_set(object, key, value) == 0);
    json_decref(value);
}

/* Applies the camera's `image` as the render settings width and height. Reports it if these are
 * also given. */
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
    pen_xml_list_lines(b);
    add_defaults(b);
    if (!b->stopped)
        put_in_order(b);
}
