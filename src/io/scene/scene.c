/* SPDX-License-Identifier: MIT */
/* The top level of a scene, and its views. */
#include "io/scene_json.h"

#include <string.h>

#include "io/scene/reader.h"
#include "io/scene/tables.h"

enum { FORMAT_1 = 1, VIEW_NAME_BYTES = 200 };
static const struct pen_word formats[] = {{"penumbra-scene/1", FORMAT_1, NULL}, {0}};

/* The target of pen_scene_fields. */
struct target {
    struct pen_scene_desc *desc;
    const char *name;
    struct pen_vec3 ambient;
    int format;
};

const struct pen_field pen_scene_fields[] = {
    {"$schema", .type = PEN_FIELD_NOTE},
    {"format", PEN_FIELD_WORD, .required = true, .offset = offsetof(struct target, format),
     .words = formats},
    {"name", PEN_FIELD_STRING, .offset = offsetof(struct target, name)},
    {"background", .type = PEN_FIELD_OTHER},
    {"ambient", PEN_FIELD_COLOUR, .offset = offsetof(struct target, ambient)},
    {"camera", PEN_FIELD_OTHER, .required = true},
    {"views", .type = PEN_FIELD_OTHER},
    {"materials", .type = PEN_FIELD_OTHER},
    {"lights", .type = PEN_FIELD_OTHER},
    {"objects", .type = PEN_FIELD_OTHER},
    {"definitions", .type = PEN_FIELD_OTHER},
    {"render", .type = PEN_FIELD_OTHER},
    {0}};

const struct pen_field pen_view_fields[] = {
    {"name", PEN_FIELD_STRING, .required = true, .offset = offsetof(struct pen_view_desc, name)},
    {"camera", .type = PEN_FIELD_OTHER},
    {0}};

static bool check_view_name(struct pen_reader *r, const struct pen_place *up,
                            const struct pen_view_desc *views, size_t i)
{
    static const char allowed[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
    const char *name = views[i].name;
    struct pen_place at = pen_place_key(up, "name");
    struct pen_text quoted = pen_text_quote(name);
    if (!name[0] || name[strspn(name, allowed)])
        return pen_reader_fail(r, &at, PEN_INVALID,
                               "must be made of one or more of A-Z, a-z, 0-9, _ and -, found %s",
                               quoted.text);
    if (strlen(name) > VIEW_NAME_BYTES)
        return pen_reader_fail(r, &at, PEN_INVALID,
                               "must be at most %d bytes long, found one of %zu",
                               (int)VIEW_NAME_BYTES, strlen(name));
    if (strcmp(name, "all") == 0)
        return pen_reader_fail(r, &at, PEN_INVALID,
                               "must not be \"all\": that stands for all views together");
    for (size_t k = 0; k < i; k++) {
        if (views[k].name && strcmp(views[k].name, name) == 0)
            return pen_reader_fail(r, &at, PEN_INVALID, "must be unique, found %s as in view %zu",
                                   quoted.text, k);
    }
    return true;
}

static bool read_view(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      bool camera_ok, struct pen_view_desc *views, size_t i)
{
    bool ok = pen_fields_read_whole(r, at, json, pen_view_fields, &views[i]);
    if (views[i].name)
        ok &= check_view_name(r, at, views, i);
    struct pen_place camera_at = pen_place_key(at, "camera");
    const json_t *camera = json_object_get(json, "camera");
    if (camera)
        ok &= pen_camera_override(r, &camera_at, camera, camera_ok, &views[i].camera);
    return ok;
}

static bool read_views(struct pen_reader *r, const json_t *json, bool camera_ok,
                       const struct pen_camera_desc *camera, struct pen_scene_desc *desc)
{
    const struct pen_place root = {0}, at = pen_place_key(&root, "views");
    if (json && !pen_read_array(r, &at, json, "views"))
        return false;
    size_t count = json ? json_array_size(json) : 1;
    if (count < 1 || count > r->limits->views)
        return pen_reader_fail(r, &at, PEN_INVALID, "must hold 1 to %u views, found %zu",
                               r->limits->views, count);
    struct pen_view_desc *views = pen_reader_alloc(r, count, sizeof *views);
    if (!views)
        return false;
    desc->views = views;
    desc->view_count = (uint32_t)count;
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        struct pen_place place = pen_place_index(&at, i);
        views[i] = (struct pen_view_desc){.name = json ? NULL : "main", .camera = *camera};
        if (json)
            ok &= read_view(r, &place, json_array_get(json, i), camera_ok, views, i);
    }
    return ok;
}

/* Refuses definitions. An empty object defines nothing, so it is accepted. */
static void refuse_definitions(struct pen_reader *r, const json_t *json)
{
    const struct pen_place root = {0}, at = pen_place_key(&root, "definitions");
    struct pen_text found = pen_text_value(json);
    if (!json_is_object(json))
        pen_reader_fail(r, &at, PEN_INVALID, "must be an object, found %s", found.text);
    else if (json_object_size(json) > 0)
        pen_reader_unsupported(r, &at, "definitions of groups for instances");
}

static void read_parts(struct pen_reader *r, const json_t *document, struct pen_scene_desc *desc)
{
    const struct pen_place root = {0};
    struct pen_place background_at = pen_place_key(&root, "background");
    struct pen_place camera_at = pen_place_key(&root, "camera");
    struct pen_place materials_at = pen_place_key(&root, "materials");
    struct pen_place lights_at = pen_place_key(&root, "lights");
    struct pen_place objects_at = pen_place_key(&root, "objects");
    struct pen_place render_at = pen_place_key(&root, "render");
    const json_t *json = json_object_get(document, "background");
    if (json)
        pen_background_read(r, &background_at, json, desc);
    json = json_object_get(document, "camera");
    struct pen_camera_desc camera = {0};
    bool camera_ok = json && pen_camera_read(r, &camera_at, json, &camera);
    read_views(r, json_object_get(document, "views"), camera_ok, &camera, desc);
    if ((json = json_object_get(document, "materials")))
        pen_materials_read(r, &materials_at, json);
    if ((json = json_object_get(document, "lights")))
        pen_lights_read(r, &lights_at, json, desc);
    if ((json = json_object_get(document, "objects")))
        pen_objects_read(r, &objects_at, json, desc);
    if ((json = json_object_get(document, "definitions")))
        refuse_definitions(r, json);
    if ((json = json_object_get(document, "render")))
        pen_settings_fields_read(r, &render_at, json, &desc->settings);
    desc->materials = r->materials;
    desc->material_count = r->material_count;
}

bool pen_scene_read_from(const json_t *document, const struct pen_source_map *source,
                         const char *at, const struct pen_limits *limits, struct pen_arena *arena,
                         struct pen_scene_desc *desc, struct pen_errors *errors)
{
    const struct pen_place root = {0};
    struct pen_errors model_notes = {0};
    struct pen_reader r = {.errors = errors,
                           .prefix = at,
                           .source = source,
                           .arena = arena,
                           .limits = limits,
                           .model_notes = &model_notes};
    struct target target = {.name = ""};
    size_t before = errors->total;
    *desc = (struct pen_scene_desc){.settings = pen_settings_default()};
    pen_fields_read_whole(&r, &root, document, pen_scene_fields, &target);
    if (!json_is_object(document))
        return false;
    desc->name = target.name;
    desc->ambient = target.ambient;
    read_parts(&r, document, desc);
    if (errors->total == before)
        pen_notes_read(&r, document, desc);
    return errors->total == before;
}

bool pen_scene_read(const json_t *document, const char *at, const struct pen_limits *limits,
                    struct pen_arena *arena, struct pen_scene_desc *desc, struct pen_errors *errors)
{
    return pen_scene_read_from(document, NULL, at, limits, arena, desc, errors);
}
