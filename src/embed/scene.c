/* SPDX-License-Identifier: MIT */
/* Scenes: from text to a description, its settings, and upper bounds on the cost of rendering. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "embed/internal/embed.h"
#include "io/builtin.h"
#include "io/settings_json.h"

const char *penumbra_version(void)
{
    return PEN_VERSION;
}

const char *penumbra_builtin_name(size_t index)
{
    return index < pen_builtin_count() ? pen_builtin_name(index) : NULL;
}

static bool read_text(struct penumbra_scene *scene, const char *text, size_t bytes,
                      struct pen_errors *list)
{
    struct pen_limits limits = pen_limits_default();
    bool xml = pen_text_is_xml(text, bytes);
    struct pen_status st;
    scene->arena = pen_arena_new(0);
    if (!scene->arena ||
        (xml && bytes <= limits.body_bytes && !pen_buf_add(&scene->xml, text, bytes))) {
        pen_fail(&st, PEN_NO_MEMORY, "out of memory for a scene of %zu bytes", bytes);
        pen_errors_add(list, &st);
        return false;
    }
    struct pen_embed_caller caller;
    pen_embed_enter(&caller);
    int64_t begun = pen_clock_ns();
    bool ok = pen_document_load(text, bytes, xml, &limits, scene->arena, &scene->desc, list);
    scene->parse_ms = (double)(pen_clock_ns() - begun) * 1e-6;
    pen_embed_leave(&caller);
    return ok;
}

struct penumbra_scene *penumbra_scene_load(const char *text, size_t bytes,
                                           struct penumbra_errors **errors)
{
    struct pen_errors list = {0};
    struct pen_status st;
    struct penumbra_scene *scene = calloc(1, sizeof *scene);
    if (!scene) {
        pen_fail(&st, PEN_NO_MEMORY, "out of memory for a scene");
        pen_embed_fail(errors, &st);
        return NULL;
    }
    if (read_text(scene, text, bytes, &list))
        return scene;
    pen_embed_fail_list(errors, &list);
    penumbra_scene_free(scene);
    return NULL;
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
 * three may be empty, and a share of nodes. Lights, materials, views and vertices take at most 8
 * times their size in the description. Each arena begins with its own chunk. tests/embed compares
 * the bound with the bytes that scenes take. */
static uint64_t scene_bytes(const struct pen_scene_desc *desc, const struct pen_arena *arena)
{
    return ((uint64_t)256 << 10) + 9 * (uint64_t)pen_arena_used(arena) +
           1024 * desc->primitive_count;
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
