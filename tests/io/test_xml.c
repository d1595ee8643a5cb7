/* SPDX-License-Identifier: MIT */
/* The meaning of scenes in XML, and their limits. */
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "scene/scene.h"
#include "support/suite.h"

static struct pen_scene_desc desc;
static struct pen_errors errors;
static struct pen_arena *arena;

static bool load(const char *text, size_t bytes)
{
    struct pen_limits limits = pen_limits_default();
    errors = (struct pen_errors){0};
    pen_arena_free(arena);
    arena = pen_arena_new(0);
    return pen_scene_load(text, bytes, &limits, arena, &desc, &errors);
}

static void must_load(const char *text)
{
    ck_assert_msg(load(text, strlen(text)), "%d:%d: %s", errors.item[0].line, errors.item[0].column,
                  errors.item[0].msg);
}

static void check_vector(struct pen_vec3 v, double x, double y, double z)
{
    ck_assert_msg(v.x == x && v.y == y && v.z == z, "%g %g %g, not %g %g %g", v.x, v.y, v.z, x, y,
                  z);
}

START_TEST(test_xml__without_a_camera_the_classrooms_is_used)
{
    must_load("<scene background-color='75 127 190'><ambient-light color='255 191 51'/>"
              "<geometries><sphere center='0 0 -100' radius='50'/></geometries></scene>");
    const struct pen_camera_desc *camera = &desc.views[0].camera;
    ck_assert_uint_eq(desc.view_count, 1);
    ck_assert_str_eq(desc.views[0].name, "main");
    check_vector(camera->position, 0, 0, 0);
    check_vector(camera->direction, 0, 0, -1);
    check_vector(camera->up, 0, 1, 0);
    ck_assert(!camera->has_look_at && camera->has_view_plane);
    ck_assert(camera->plane_distance == 100);
    ck_assert(camera->plane_width == 500 && camera->plane_height == 500);
    ck_assert_int_eq(desc.settings.width, 1000);
    ck_assert_int_eq(desc.settings.height, 1000);
    ck_assert_int_eq(desc.settings.transfer, PEN_SETTING_DISPLAY);
    check_vector(desc.background, 75.0 / 255, 127.0 / 255, 190.0 / 255);
    check_vector(desc.ambient, 1, 191.0 / 255, 0.2);
    ck_assert_int_eq(desc.objects[0].material, -1);
}
END_TEST

START_TEST(test_xml__a_camera_element_has_the_defaults_of_the_format)
{
    must_load("<scene><camera position='0 0 9' look-at='1 2 3'/></scene>");
    ck_assert(desc.views[0].camera.has_look_at && !desc.views[0].camera.has_view_plane);
    ck_assert(desc.views[0].camera.fov_degrees == 50);
    ck_assert_int_eq(desc.settings.width, 800);
    ck_assert_int_eq(desc.settings.height, 600);
    ck_assert_int_eq(desc.settings.transfer, PEN_SETTING_DISPLAY);
    must_load("<scene><render height='7' transfer='srgb'/></scene>");
    ck_assert_int_eq(desc.settings.width, 1000);
    ck_assert_int_eq(desc.settings.height, 7);
    ck_assert_int_eq(desc.settings.transfer, PEN_SETTING_SRGB);
    must_load("<scene><camera position='0 0 9' direction='0 0 -1' image='12 34'/>"
              "<render threads='3'/></scene>");
    ck_assert_int_eq(desc.settings.width, 12);
    ck_assert_int_eq(desc.settings.height, 34);
    ck_assert_int_eq(desc.settings.threads, 3);
}
END_TEST

START_TEST(test_xml__lights_and_materials_mean_what_json_means)
{
    must_load("<scene><lights>"
              "<spot color='1000 700 500' position='0 30 0' direction='0 -2 0' radius='0'"
              " attenuation='1 0 0.0006' beam-exponent='7'/>"
              "<directional color='51 0 0' direction='1 0 0' shadows='false'/></lights>"
              "<geometries><sphere center='0 0 -9' radius='2' emission='255 160 30' kd='0.1' "
              "ks='0.8 0.7 0.6' shininess='150' kt='1' kr='0' ka='0.5'/></geometries></scene>");
    const struct pen_light_desc *spot = &desc.lights[0], *sun = &desc.lights[1];
    ck_assert_int_eq(spot->kind, PEN_LIGHT_SPOT);
    check_vector(spot->intensity, 1000.0 / 255, 700.0 / 255, 500.0 / 255);
    check_vector(spot->direction, 0, -2, 0);
    ck_assert(spot->attenuation[0] == 1 && spot->attenuation[1] == 0);
    ck_assert(spot->attenuation[2] == 0.0006 && spot->beam_exponent == 7 && spot->shadows);
    ck_assert_int_eq(sun->kind, PEN_LIGHT_DIRECTIONAL);
    check_vector(sun->intensity, 0.2, 0, 0);
    ck_assert(!sun->shadows);
    const struct pen_material *m = &desc.materials[desc.objects[0].material];
    check_vector(m->emission, 1, 160.0 / 255, 30.0 / 255);
    check_vector(m->kd, 0.1, 0.1, 0.1);
    check_vector(m->ks, 0.8, 0.7, 0.6);
    check_vector(m->ka, 0.5, 0.5, 0.5);
    check_vector(m->kt, 1, 1, 1);
    ck_assert(m->shininess == 150 && m->ior == 1);
}
END_TEST

/* The normal is on the side from which the points run counter-clockwise, at any scale. */
START_TEST(test_xml__three_points_make_a_plane_at_any_scale)
{
    static const char *const sizes[] = {"1", "1e-160", "1e99", "-3e-300"};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "<scene><geometries><plane p0='0 0 0' p1='%s 0 0' p2='0 %s 0'/></geometries>"
                 "</scene>",
                 sizes[i], sizes[i]);
        must_load(text);
        struct pen_vec3 n = desc.objects[0].u.plane.normal;
        check_vector(desc.objects[0].u.plane.point, 0, 0, 0);
        ck_assert_msg(n.x == 0 && n.y == 0 && n.z > 0.1 && n.z <= 2, "%s: %g %g %g", sizes[i], n.x,
                      n.y, n.z);
    }
    must_load("<scene><geometries><plane p0='1 2 3' p1='1 2 4' p2='2 2 3'/></geometries></scene>");
    struct pen_vec3 n = desc.objects[0].u.plane.normal;
    check_vector(desc.objects[0].u.plane.point, 1, 2, 3);
    ck_assert(n.x == 0 && n.y > 0 && n.z == 0);
}
END_TEST

START_TEST(test_xml__groups_nest_and_are_transformed)
{
    must_load("<scene><geometries><group name='outer'><sphere center='0 0 0' radius='1'/>"
              "<transform scale='2' translate='1 2 3'><rotate axis='0 0 1' degrees='90'/>"
              "</transform><group/></group></geometries></scene>");
    const struct pen_object_desc *group = &desc.objects[0];
    ck_assert_str_eq(group->name, "outer");
    ck_assert_uint_eq(group->u.group.count, 2);
    ck_assert(group->u.group.has_transform);
    const struct pen_transform *f = &group->u.group.transform;
    ck_assert(f->m[0][0] == 0 && f->m[0][1] == -2 && f->m[1][0] == 2 && f->m[2][2] == 2);
    ck_assert(f->m[0][3] == 1 && f->m[1][3] == 2 && f->m[2][3] == 3);
    ck_assert_int_eq(group->u.group.objects[1].kind, PEN_OBJECT_GROUP);
    ck_assert_uint_eq(group->u.group.objects[1].u.group.count, 0);
}
END_TEST

/* The published schema has every key. Each that is not an object or a list must be an attribute. */
static void check_attributes(const json_t *schema, const char *definition, const char *head,
                             const char *tail, const char *const *other)
{
    json_t *defs = json_object_get(schema, "$defs");
    json_t *keys = json_object_get(json_object_get(defs, definition), "properties");
    const char *key;
    json_t *ignored;
    ck_assert_msg(json_object_size(keys) > 3, "%s", definition);
    json_object_foreach(keys, key, ignored)
    {
        char text[512], name[64];
        bool skip = false;
        for (size_t i = 0; other[i]; i++)
            skip = skip || strcmp(other[i], key) == 0;
        if (skip)
            continue;
        snprintf(name, sizeof name, "%s", key);
        for (char *c = name; *c; c++)
            *c = *c == '_' ? '-' : *c;
        snprintf(text, sizeof text, "%s %s='?'%s", head, name, tail);
        load(text, strlen(text));
        for (size_t i = 0; i < errors.count; i++)
            ck_assert_msg(!strstr(errors.item[i].msg, "unknown attribute"), "%s: %s", text,
                          errors.item[i].msg);
    }
}

START_TEST(test_xml__every_key_of_the_schema_is_an_attribute)
{
    static const char *const none[] = {NULL};
    static const char *const camera[] = {"view_plane", "transforms", NULL};
    json_t *schema = json_load_file("api/scene.schema.json", 0, NULL);
    ck_assert_ptr_nonnull(schema);
    check_attributes(schema, "render", "<scene><render", "/></scene>", none);
    check_attributes(schema, "material", "<scene><materials><material name='m'",
                     "/></materials></scene>", none);
    check_attributes(schema, "material", "<scene><geometries><sphere center='0 0 0' radius='1'",
                     "/></geometries></scene>", none);
    check_attributes(schema, "camera_keys", "<scene><camera", "/></scene>", camera);
    json_decref(schema);
}
END_TEST

/* `item` repeated between `head` and `tail`. */
static char *repeat(const char *head, const char *item, size_t count, const char *tail,
                    size_t *bytes)
{
    size_t h = strlen(head), p = strlen(item), t = strlen(tail);
    char *text = malloc(h + count * p + t);
    memcpy(text, head, h);
    for (size_t i = 0; i < count; i++)
        memcpy(text + h + i * p, item, p);
    memcpy(text + h + count * p, tail, t);
    *bytes = h + count * p + t;
    return text;
}

static void refused(const char *head, const char *item, size_t count, const char *tail,
                    enum pen_code code, const char *part)
{
    size_t bytes;
    char *text = repeat(head, item, count, tail, &bytes);
    ck_assert(!load(text, bytes));
    ck_assert_int_eq(errors.item[0].code, code);
    ck_assert_msg(strstr(errors.item[0].msg, part) != NULL, "%s", errors.item[0].msg);
    free(text);
}

START_TEST(test_xml__size_depth_and_counts_are_bounded)
{
    refused("<scene>", " ", (size_t)16 << 20, "</scene>", PEN_TOO_LARGE, "at most 16777216");
    refused("<scene>", "<a>", 5000000, "", PEN_INVALID, "64 elements");
    refused("<scene><geometries>", "<group>", 2000000, "", PEN_INVALID, "64 levels");
    refused("<scene ", "a='' ", 3000000, "/>", PEN_SYNTAX, "64 attributes");
    refused("<scene><geometries>", "<triangle/>", 1200000, "</geometries></scene>", PEN_INVALID,
            "missing attribute");
    refused("<scene><geometries>", "<group/>", 900000, "</geometries></scene>", PEN_TOO_LARGE,
            "402653184 bytes of memory");
    refused("<scene><geometries><polygon points='0 0 0", ";0 0 0", 2700000,
            "'/></geometries></scene>", PEN_TOO_LARGE, "402653184 bytes of memory");
    refused("<scene name='", "x", 16000000, "<'/>", PEN_SYNTAX, "&lt;");
    refused("<scene><geometries>", "<a b='c'/>", 1000000, "</geometries></scene>", PEN_INVALID,
            "unknown element");
}
END_TEST

START_TEST(test_xml__a_huge_attribute_is_read)
{
    size_t bytes;
    char *text = repeat("<scene name='", "0123456789abcdef", 1000000, "'/>", &bytes);
    ck_assert(load(text, bytes));
    ck_assert_uint_eq(strlen(desc.name), 16000000);
    free(text);
}
END_TEST

START_TEST(test_xml__limits_of_the_caller_apply)
{
    static const char text[] = "<scene><geometries><group><sphere center='0 0 0' radius='1'/>"
                               "</group><sphere center='0 0 0' radius='1'/></geometries></scene>";
    struct pen_limits limits = pen_limits_default();
    limits.objects = 2;
    errors = (struct pen_errors){0};
    arena = pen_arena_new(0);
    ck_assert(!pen_scene_load(text, sizeof text - 1, &limits, arena, &desc, &errors));
    ck_assert_msg(strstr(errors.item[0].msg, "more than 2 objects"), "%s", errors.item[0].msg);
    ck_assert_int_eq(errors.item[0].line, 1);
    limits.objects = 3;
    limits.nesting = 7;
    ck_assert(pen_scene_load(text, sizeof text - 1, &limits, arena, &desc, &errors));
    limits.nesting = 6;
    ck_assert(!pen_scene_load(text, sizeof text - 1, &limits, arena, &desc, &errors));
}
END_TEST

START_TEST(test_xml__a_pointer_becomes_line_and_column)
{
    static const char text[] =
        "<scene>\n <geometries>\n  <group><polygon\n   points='0 0 0; 1 0 0; "
        "1 1 0'/>\n  </group>\n </geometries>\n</scene>";
    static const struct {
        const char *at;
        int line, column;
    } rows[] = {{"", 1, 1},
                {"/objects", 2, 2},
                {"/objects/0", 3, 3},
                {"/objects/0/objects/0", 3, 10},
                {"/objects/0/objects/0/vertices", 4, 4},
                {"/objects/0/objects/0/vertices/2", 4, 26},
                {"/objects/0/objects/0/vertices/2/1", 4, 28},
                {"/objects/0/objects/7/radius", 3, 3},
                {"/camera", 1, 1},
                {"/render/width", 1, 1},
                {"/no~1such~0", 1, 1},
                {"/objects/0/objects/0/vertices/2/…", 4, 26}};
    struct pen_limits limits = pen_limits_default();
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pen_status st;
        pen_fail_at(&st, PEN_INVALID, rows[i].at, "is wrong");
        pen_text_locate(text, sizeof text - 1, &limits, &st);
        ck_assert_msg(st.line == rows[i].line && st.column == rows[i].column, "%s: %d:%d",
                      rows[i].at, st.line, st.column);
        ck_assert(strstr(st.msg, "is wrong") != NULL && st.at[0] == '\0');
    }
    struct pen_status st;
    pen_fail_at(&st, PEN_INVALID, "/objects", "is wrong");
    pen_text_locate("{}", 2, &limits, &st);
    ck_assert_str_eq(st.at, "/objects");
}
END_TEST

START_TEST(test_xml__written_json_reads_back_as_the_same)
{
    static const char text[] =
        "{\"a\": [1, 2.5, 0.1, 1e100, -0.0, 12345678901234567], \"b\": {\"c\": [[0.3], []], "
        "\"d\": {}}, \"e\": \"x\\\"\\n\\u00e9\\u0001\", \"f\": true, \"g\": null, "
        "\"h/~\": 0.29411764705882354}";
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    struct pen_buf out = {0};
    json_t *json = pen_json_parse(text, sizeof text - 1, &limits, &st);
    ck_assert_ptr_nonnull(json);
    ck_assert(pen_json_write(json, &out));
    json_t *again = pen_json_parse((char *)out.data, out.bytes, &limits, &st);
    ck_assert_msg(again != NULL, "%s: %s", st.msg, (char *)out.data);
    char *a = json_dumps(json, JSON_REAL_PRECISION(17) | JSON_SORT_KEYS);
    ck_assert(strstr((char *)out.data, "[1, 2.5, 0.1, 1e+100, -0.0, 12345678901234567]") != NULL);
    ck_assert(strstr((char *)out.data, "0.29411764705882354") != NULL);
    free(a);
    json_decref(json);
    json_decref(again);
    pen_buf_release(&out);
}
END_TEST

/* The least limit on the memory of values with which the text is accepted. */
static size_t least_limit(const char *text, size_t bytes, bool xml)
{
    struct pen_limits limits = pen_limits_default();
    size_t below = 0, above = limits.parsed_bytes;
    while (above - below > 1) {
        struct pen_document document;
        struct pen_status st;
        limits.parsed_bytes = below + (above - below) / 2;
        bool ok = pen_document_parse(text, bytes, xml, &limits, &document, &st);
        ck_assert(ok || st.code == PEN_TOO_LARGE);
        pen_document_release(&document);
        *(ok ? &above : &below) = limits.parsed_bytes;
    }
    return above;
}

/* A scene in XML needs nearly the same limit as the same scene in JSON. The XML parser adds the
 * defaults of the XML format (a camera, the format) without counting them, and needs memory for a
 * list while it parses. */
static void check_memory(const char *xml_path, const char *text, size_t bytes)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_document document;
    struct pen_status st;
    ck_assert_msg(pen_document_parse(text, bytes, true, &limits, &document, &st), "%s", st.msg);
    ck_assert_msg(load(text, bytes), "%s: %s", xml_path, errors.item[0].msg);
    char *json = json_dumps(document.json, JSON_COMPACT);
    size_t xml_bytes = least_limit(text, bytes, true);
    size_t json_bytes = least_limit(json, strlen(json), false);
    ck_assert_msg(xml_bytes <= json_bytes + 1024 && json_bytes <= xml_bytes + 4096,
                  "%s: %zu bytes, in JSON %zu", xml_path, xml_bytes, json_bytes);
    free(json);
    pen_document_release(&document);
}

START_TEST(test_xml__values_take_as_much_memory_as_in_json)
{
    static const char *const primitives[] = {
        "<sphere center='0 0 0' radius='1'/>",
        "<sphere center='0 0 0' radius='1' kd='0.1 0.2 0.3' kt='0.5' emission='1 2 3'/>",
        "<plane p0='0 0 0' p1='1 0 0' p2='0 1 0'/>",
        "<triangle p0='0 0 0' p1='1 0 0' p2='0 1 0' name='a &lt; b'/>",
        "<polygon points='0 0 0; 1 0 0; 1 1 0; 0 1 0'/>",
        "<polygon p0='0 0 0' p1='1 0 0' p2='1 1 0' p3='0 1 0'/>",
        "<plane p0='0 0 0' normal='0 1 0' kd='0.5'><material ks='0.25'/></plane>",
        ("<group><transform translate='1 2 3' scale='2'><rotate axis='1 0 0' degrees='9'/>"
         "</transform></group>"),
        "<group><transform matrix='1 0 0 0 0 1 0 0 0 0 1 0'/></group>"};
    for (size_t i = 0; i < sizeof primitives / sizeof primitives[0]; i++) {
        size_t bytes;
        char *text =
            repeat("<scene><geometries>", primitives[i], 1000, "</geometries></scene>", &bytes);
        check_memory(primitives[i], text, bytes);
        free(text);
    }
    glob_t found;
    ck_assert_int_eq(glob("tests/io/corpus/xml-good/*.xml", 0, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        static char text[1 << 16];
        FILE *file = fopen(found.gl_pathv[i], "rb");
        ck_assert_ptr_nonnull(file);
        check_memory(found.gl_pathv[i], text, fread(text, 1, sizeof text, file));
        fclose(file);
    }
    globfree(&found);
}
END_TEST

PEN_SUITE("io/xml", test_xml__without_a_camera_the_classrooms_is_used,
          test_xml__a_camera_element_has_the_defaults_of_the_format,
          test_xml__lights_and_materials_mean_what_json_means,
          test_xml__three_points_make_a_plane_at_any_scale,
          test_xml__groups_nest_and_are_transformed,
          test_xml__every_key_of_the_schema_is_an_attribute,
          test_xml__size_depth_and_counts_are_bounded, test_xml__a_huge_attribute_is_read,
          test_xml__limits_of_the_caller_apply, test_xml__a_pointer_becomes_line_and_column,
          test_xml__written_json_reads_back_as_the_same,
          test_xml__values_take_as_much_memory_as_in_json)
