/* SPDX-License-Identifier: MIT */
/* Notes about a valid scene: omissions and choices of the reader, and colours that are probably
 * errors. They are found without freezing the scene, so that every command can report them. There
 * is one note of each kind, which counts and names the first place. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "film/encode.h"
#include "io/scene/reader.h"

/* Whether a colour looks like three bytes. */
static bool looks_like_bytes(struct pen_vec3 c)
{
    const double v[3] = {c.x, c.y, c.z};
    bool whole = true, large = false;
    for (int i = 0; i < 3; i++) {
        whole = whole && v[i] == floor(v[i]) && v[i] <= 255;
        large = large || v[i] >= 2;
    }
    return whole && large;
}

/* A colour of the scene itself rather than of an object. */
struct scene_colour {
    const char *path[3]; /* keys */
    struct pen_vec3 value;
};

/* Notes a colour that looks like bytes. `shown`: the values are already a screen's (transfer
 * display). */
static void note_bytes(struct pen_reader *r, const struct scene_colour *first, const char *others,
                       bool shown)
{
    struct pen_place at[4] = {{0}};
    int depth = 0;
    for (; depth < 3 && first->path[depth]; depth++)
        at[depth + 1] = pen_place_key(&at[depth], first->path[depth]);
    const struct pen_vec3 c = first->value, part = pen_vec3(c.x / 255, c.y / 255, c.z / 255);
    const struct pen_vec3 light =
        shown ? part
              : pen_vec3(pen_decode_srgb(part.x), pen_decode_srgb(part.y), pen_decode_srgb(part.z));
    pen_reader_fail(r, &at[depth], PEN_OK,
                    "[%g, %g, %g] looks like a colour from 0 to 255, but 1 is display white here: "
                    "divided by 255 it is [%.3g, %.3g, %.3g]; to see just this colour in a "
                    "picture, write [%.3g, %.3g, %.3g]%s%s",
                    c.x, c.y, c.z, part.x, part.y, part.z, light.x, light.y, light.z,
                    *others ? "; the same holds for" : "", others);
}

/* Notes colours. In XML they are from 0 to 255. */
static void note_colours(struct pen_reader *r, const struct pen_scene_desc *desc)
{
    const bool sky = desc->has_sky;
    const struct scene_colour colours[] = {
        {{"background", sky ? "sky" : NULL, "horizon"}, desc->background},
        {{"background", "sky", "zenith"}, desc->sky.zenith},
        {{"background", "sky", "nadir"}, desc->sky.nadir},
        {{"ambient"}, desc->ambient}};
    const struct scene_colour *first = NULL;
    char others[64] = "";
    for (size_t i = 0; i < sizeof colours / sizeof colours[0]; i++) {
        const struct scene_colour *c = &colours[i];
        const bool copied = i == 2 && memcmp(&c->value, &desc->background, sizeof c->value) == 0;
        if (!looks_like_bytes(c->value) || copied) /* nadir: written, or the horizon's colour */
            continue;
        if (first)
            snprintf(others + strlen(others), sizeof others - strlen(others), "%s %s",
                     *others ? "," : "", c->path[2] ? c->path[2] : c->path[0]);
        else
            first = c;
    }
    if (first && !pen_reader_is_xml(r))
        note_bytes(r, first, others, desc->settings.transfer == PEN_SETTING_DISPLAY);
}

static void note_left_out(struct pen_reader *r, const struct pen_place *at)
{
    const uint32_t count = r->left_out_count;
    pen_reader_fail(r, at, PEN_OK,
                    "%u triangle%s or polygon%s without area (all vertices on one line) %s left "
                    "out%s",
                    (unsigned)count, count > 1 ? "s" : "", count > 1 ? "s" : "",
                    count > 1 ? "are" : "is", count > 1 ? "; this is the first" : "");
}

static void note_repeat(struct pen_reader *r, const struct pen_place *at)
{
    const uint32_t count = r->repeat_count;
    pen_reader_fail(r, at, PEN_OK,
                    "%u polygon%s a vertex at the end, which is left out: the first one, or the "
                    "one before%s",
                    (unsigned)count, count > 1 ? "s repeat" : " repeats",
                    count > 1 ? "; this is the first polygon" : "");
}

/* Notes the first object that is left out, or that repeats a vertex. Returns whether there is one.
 */
static bool note_first(struct pen_reader *r, const struct pen_object_desc *objects, uint32_t count,
                       const struct pen_place *up, bool left_out)
{
    const struct pen_place at = pen_place_key(up, "objects");
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *object = &objects[i];
        const struct pen_place place = pen_place_index(&at, i);
        if (object->kind == PEN_OBJECT_GROUP) {
            if (note_first(r, object->u.group.objects, object->u.group.count, &place, left_out))
                return true;
        } else if (left_out ? object->left_out : object->repeats_vertex) {
            if (left_out)
                note_left_out(r, &place);
            else
                note_repeat(r, &place);
            return true;
        }
    }
    return false;
}

/* Notes what the readers of model files have found, and meshes' own triangles without area. */
static void note_meshes(struct pen_reader *r)
{
    const struct pen_place root = {0}, at = pen_place_key(&root, "objects");
    for (size_t i = 0; i < r->model_notes->count; i++)
        pen_errors_add(r->errors, &r->model_notes->item[i]);
    if (r->mesh_flat_count > 0)
        pen_reader_fail(r, &at, PEN_OK, "%u triangles of meshes without area are left out",
                        (unsigned)r->mesh_flat_count);
}

static void note_up(struct pen_reader *r, const json_t *document, const struct pen_scene_desc *desc)
{
    const struct pen_place root = {0}, views = pen_place_key(&root, "views");
    struct pen_camera_frame frame = {.other_up = false};
    struct pen_status st;
    uint32_t count = 0, first = 0;
    for (uint32_t i = desc->view_count; i-- > 0;)
        if (pen_camera_frame_make(&desc->views[i].camera, &frame, &st) && frame.other_up) {
            count++;
            first = i;
        }
    if (count == 0)
        return;
    const struct pen_camera_desc *camera = &desc->views[first].camera;
    const double y =
        camera->has_look_at ? camera->look_at.y - camera->position.y : camera->direction.y;
    const json_t *view = json_array_get(json_object_get(document, "views"), first);
    const struct pen_place own = pen_place_index(&views, first);
    const struct pen_place at =
        pen_place_key(json_object_get(view, "camera") ? &own : &root, "camera");
    char more[48] = "";
    if (count > 1)
        snprintf(more, sizeof more, " (in %u views)", (unsigned)count);
    pen_reader_fail(r, &at, PEN_OK,
                    "looks straight %s without %s: [0, 0, %d] is taken as up%s; write %s to choose "
                    "another direction",
                    y < 0 ? "down" : "up", pen_reader_name(r, &at, "up").text, y < 0 ? -1 : 1, more,
                    pen_reader_name(r, &at, "up").text);
}

void pen_notes_read(struct pen_reader *r, const json_t *document, struct pen_scene_desc *desc)
{
    const struct pen_place root = {0};
    struct pen_errors found = {0}, *errors = r->errors;
    r->errors = &found;
    note_colours(r, desc);
    note_up(r, document, desc);
    note_meshes(r);
    if (r->left_out_count > 0)
        note_first(r, desc->objects, desc->object_count, &root, true);
    if (r->repeat_count > 0)
        note_first(r, desc->objects, desc->object_count, &root, false);
    r->errors = errors;
    if (found.count == 0)
        return;
    desc->notes = pen_reader_alloc(r, found.count, sizeof *desc->notes);
    if (!desc->notes)
        return;
    memcpy(desc->notes, found.item, found.count * sizeof *found.item);
    desc->note_count = (uint32_t)found.count;
}
