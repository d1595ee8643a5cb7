/* SPDX-License-Identifier: MIT */
/* Scenes: from text to a description, its settings, and upper bounds on the cost of rendering. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "embed/internal/embed.h"
#include "io/builtin.h"
#include "io/models.h"
#include "io/settings_json.h"

const char *penumbra_version(void)
{
    return PEN_VERSION;
}

const char *penumbra_builtin_name(size_t index)
{
    return index < pen_builtin_count() ? pen_builtin_name(index) : NULL;
}

/* A scene that is being read. */
struct reading {
    struct penumbra_scene *scene;
    struct penumbra_models given;
    struct pen_models models;
    struct pen_embed_caller caller;
};

struct penumbra_file {
    struct pen_buf *bytes;
    bool full; /* memory has run out */
};

int penumbra_file_append(struct penumbra_file *file, const void *data, size_t bytes)
{
    file->full = file->full || !pen_buf_add(file->bytes, data, bytes);
    return !file->full;
}

/* Asks the program for a file, in the program's own locale and floating-point environment. */
static bool fetch(void *self, const char *name, struct pen_buf *out, struct pen_status *st)
{
    struct reading *reading = self;
    struct penumbra_file file = {.bytes = out};
    pen_embed_leave(&reading->caller);
    const int given = reading->given.read(reading->given.user, name, &file);
    pen_embed_enter(&reading->caller);
    if (file.full)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory for the file \"%.100s\"", name);
    return given || pen_fail(st, PEN_NOT_FOUND, "the program gave no file \"%.100s\"", name);
}

static bool take_models(const struct penumbra_models *given, struct reading *reading,
                        struct pen_status *st)
{
    const struct penumbra_models *m = &reading->given;
    if (given && !pen_embed_take(given, &reading->given, sizeof reading->given))
        return pen_fail(st, PEN_USAGE,
                        "struct penumbra_models: size is too small, or a member that version "
                        "%s does not know is not zero",
                        PEN_VERSION);
    if (m->up != 0 && m->up != 'y' && m->up != 'z')
        return pen_fail(st, PEN_USAGE, "up: found %d, allowed is 'y', 'z' or 0", m->up);
    reading->models =
        (struct pen_models){.fetch = fetch, .self = reading, .max_triangles = m->max_triangles};
    return true;
}

static bool read_text(struct reading *reading, const char *text, size_t bytes,
                      struct pen_errors *list)
{
    struct penumbra_scene *scene = reading->scene;
    struct pen_limits limits = pen_limits_default();
    bool xml = pen_text_is_xml(text, bytes);
    struct pen_status st;
    limits.models = reading->given.read ? &reading->models : NULL;
    scene->arena = pen_arena_new(0);
    if (!scene->arena ||
        (xml && bytes <= limits.body_bytes && !pen_buf_add(&scene->xml, text, bytes))) {
        pen_fail(&st, PEN_NO_MEMORY, "out of memory for a scene of %zu bytes", bytes);
        pen_errors_add(list, &st);
        return false;
    }
    return pen_document_load(text, bytes, xml, &limits, scene->arena, &scene->desc, list);
}

static bool read_model(struct reading *reading, const char *name, struct pen_errors *list)
{
    struct pen_buf text = {0};
    struct pen_status st;
    bool ok = reading->given.read
                  ? pen_models_scene(&reading->models, name, (char)reading->given.up, &text, &st)
                  : pen_fail(&st, PEN_USAGE, "read: a model needs this callback");
    if (!ok)
        pen_errors_add(list, &st);
    ok = ok && read_text(reading, (const char *)text.data, text.bytes, list);
    pen_buf_release(&text);
    return ok;
}

/* Reads a scene from text, or from the model `name` if that is not NULL. */
static struct penumbra_scene *read_scene(const char *name, const char *text, size_t bytes,
                                         const struct penumbra_models *models,
                                         struct penumbra_errors **errors)
{
    struct reading reading = {.scene = calloc(1, sizeof *reading.scene)};
    struct pen_errors list = {0};
    struct pen_status st;
    bool ok = reading.scene || pen_fail(&st, PEN_NO_MEMORY, "out of memory for a scene");
    ok = ok && take_models(models, &reading, &st);
    if (!ok) {
        pen_errors_add(&list, &st);
    } else {
        pen_embed_enter(&reading.caller);
        const int64_t begun = pen_clock_ns();
        ok = name ? read_model(&reading, name, &list) : read_text(&reading, text, bytes, &list);
        reading.scene->parse_ms = (double)(pen_clock_ns() - begun) * 1e-6;
        pen_models_release(&reading.models);
        pen_embed_leave(&reading.caller);
    }
    if (ok)
        return reading.scene;
    pen_embed_fail_list(errors, &list);
    penumbra_scene_free(reading.scene);
    return NULL;
}

struct penumbra_scene *penumbra_scene_load(const char *text, size_t bytes,
                                           struct penumbra_errors **errors)
{
    return read_scene(NULL, text, bytes, NULL, errors);
}

struct penumbra_scene *penumbra_scene_read(const char *text, size_t bytes,
                                           const struct penumbra_models *models,
                                           struct penumbra_errors **errors)
{
    return read_scene(NULL, text, bytes, models, errors);
}

struct penumbra_scene *penumbra_scene_model(const char *name, const struct penumbra_models *models,
                                            struct penumbra_errors **errors)
{
    return read_scene(name, NULL, 0, models, errors);
}

struct penumbra_scene *penumbra_scene_builtin(const char *name, struct penumbra_errors **errors)
{
    size_t bytes;
    const char *text = pen_builtin_find(name, &bytes);
    if (text)
        return penumbra_scene_load(text, bytes, errors);
    const char *near = pen_builtin_nearest(name);
    struct pen_status st;
    pen_fail(&st, PEN_NOT_FOUND, "no built-in scene \"%s\"%s%s%s", name,
             near ? ", nearest is \"" : "", near ? near : "", near ? "\"" : "");
    pen_embed_fail(errors, &st);
    return NULL;
}

void penumbra_scene_free(struct penumbra_scene *scene)
{
    if (!scene)
        return;
    pen_scene_free(scene->frozen);
    pen_arena_free(scene->arena);
    pen_buf_release(&scene->xml);
    free(scene);
}

const char *penumbra_scene_view(const struct penumbra_scene *scene, size_t index)
{
    return index < scene->desc.view_count ? scene->desc.views[index].name : NULL;
}

int penumbra_scene_set(struct penumbra_scene *scene, const char *assignment,
                       struct penumbra_errors **errors)
{
    struct pen_status st;
    struct pen_embed_caller caller;
    pen_embed_enter(&caller);
    bool ok = pen_settings_set(&scene->desc.settings, assignment, &st);
    pen_embed_leave(&caller);
    return ok || pen_embed_fail(errors, &st);
}

char *penumbra_scene_settings(const struct penumbra_scene *scene, struct penumbra_errors **errors)
{
    struct pen_buf text = {0};
    struct pen_status st;
    struct pen_embed_caller caller;
    pen_embed_enter(&caller);
    json_t *json = pen_settings_json(&scene->desc.settings);
    bool ok = json && pen_json_write(json, &text);
    json_decref(json);
    pen_embed_leave(&caller);
    if (ok)
        return pen_embed_detach(&text);
    pen_buf_release(&text);
    pen_fail(&st, PEN_NO_MEMORY, "out of memory for the settings");
    pen_embed_fail(errors, &st);
    return NULL;
}

/* An upper bound of the bytes of the description, the frozen scene and its acceleration structure.
 * Per primitive the structures take less than 1 KiB: at most a block of four lanes, of which up to
 * three may be empty, and a share of nodes. For a triangle of a mesh, such a block takes 160 bytes,
 * the share of nodes 126 (a node of 224 bytes has fewer than eight children only if all are
 * leaves), solids and layers 13; the ranges, 64 while the tree is built, are freed. Lights,
 * materials, views and vertices take at most 8 times their size in the description. Each arena
 * begins with its own chunk. tests/embed compares the bound with the bytes that scenes take. */
static uint64_t scene_bytes(const struct pen_scene_desc *desc, const struct pen_arena *arena)
{
    const uint64_t triangles = pen_desc_meshes(desc).triangles;
    return ((uint64_t)256 << 10) + 9 * (uint64_t)pen_arena_used(arena) +
           1024 * (desc->primitive_count - triangles) + 320 * triangles;
}

int penumbra_scene_estimate(const struct penumbra_scene *scene, struct penumbra_estimate *estimate,
                            struct penumbra_errors **errors)
{
    enum { SECONDARY = PEN_FX_MIRROR | PEN_FX_TRANSMISSION };
    const struct pen_scene_desc *desc = &scene->desc;
    const struct pen_settings *s = &desc->settings;
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    struct pen_embed_caller caller;
    pen_embed_enter(&caller);
    bool ok = pen_limits_check(&limits, desc, s, 1, "", &st);
    pen_embed_leave(&caller);
    if (!ok)
        return pen_embed_fail(errors, &st);
    double pixels = (double)s->width * s->height;
    struct penumbra_estimate full = {
        .width = s->width,
        .height = s->height,
        .primitives = desc->primitive_count,
        .rays = pixels * pen_work_per_pixel(desc, s),
        .secondary = (pen_desc_effects(desc, s) & SECONDARY) != 0,
        .image_bytes = (uint64_t)s->width * (uint64_t)s->height * 3 * sizeof(float),
        .scene_bytes = scene_bytes(desc, scene->arena),
    };
    if (pen_embed_give(&full, sizeof full, estimate))
        return 1;
    pen_fail(&st, PEN_USAGE, "struct penumbra_estimate: size is too small; set it to sizeof");
    return pen_embed_fail(errors, &st);
}
