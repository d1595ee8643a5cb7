/* SPDX-License-Identifier: MIT */
/* Warnings about valid scenes whose author probably meant something else. A warning is a status
 * with code PEN_OK, a JSON Pointer and a sentence. */
#include <stdio.h>
#include <stdlib.h>

#include "io/scene/reader.h"
#include "scene/empty_view.h"
#include "scene/freeze_without_rays.h"
#include "scene/precision.h"
#include "scene/tjunction.h"

/* The most steps, of some 30 ns, of each check that only produces warnings. It is a count, not a
 * time, so a scene gets the same warnings everywhere. */
enum { STEPS_MAX = 8 << 20 };

static void warn(struct pen_reader *r, const struct pen_place *at, const char *what)
{
    pen_reader_fail(r, at, PEN_OK, "%s", what);
}

static void mark_used(const struct pen_object_desc *objects, uint32_t count, bool *used)
{
    for (uint32_t i = 0; i < count; i++) {
        if (objects[i].kind == PEN_OBJECT_GROUP)
            mark_used(objects[i].u.group.objects, objects[i].u.group.count, used);
        else if (objects[i].material >= 0)
            used[objects[i].material] = true;
    }
}

/* The named materials are the first of the description, in document order. */
static void warn_unused_materials(struct pen_reader *r, const json_t *document,
                                  const struct pen_scene_desc *desc)
{
    const struct pen_place root = {0}, materials = pen_place_key(&root, "materials");
    json_t *named = json_object_get(document, "materials");
    bool *used = calloc((size_t)desc->material_count + 1, sizeof *used);
    if (!used)
        return;
    mark_used(desc->objects, desc->object_count, used);
    uint32_t i = 0;
    for (void *m = json_object_iter(named); m; m = json_object_iter_next(named, m)) {
        struct pen_place at = pen_place_key(&materials, json_object_iter_key(m));
        if (!used[i++])
            warn(r, &at, "no object uses this material");
    }
    free(used);
}

static bool is_black(struct pen_vec3 colour)
{
    return colour.x == 0 && colour.y == 0 && colour.z == 0;
}

static void warn_dark_lights(struct pen_reader *r, const struct pen_scene_desc *desc)
{
    const struct pen_place root = {0}, lights = pen_place_key(&root, "lights");
    for (uint32_t i = 0; i < desc->light_count; i++) {
        struct pen_place light = pen_place_index(&lights, i);
        struct pen_place at = pen_place_key(&light, "intensity");
        if (is_black(desc->lights[i].intensity))
            warn(r, &at, "this light gives no light");
    }
}

static void warn_empty_or_black(struct pen_reader *r, const struct pen_scene_desc *desc)
{
    const struct pen_place root = {0};
    bool lit = !is_black(desc->ambient) || !is_black(desc->background) ||
               !is_black(desc->sky.zenith) || !is_black(desc->sky.nadir);
    for (uint32_t i = 0; i < desc->light_count; i++)
        lit |= !is_black(desc->lights[i].intensity);
    for (uint32_t i = 0; i < desc->material_count; i++)
        lit |= !is_black(desc->materials[i].emission);
    if (desc->primitive_count == 0)
        warn(r, &root, "there are no objects: the picture will show the background alone");
    else if (!lit)
        warn(r, &root,
             "there is no light, ambient light, emission or background: the picture will be black");
}

static struct pen_place view_place(const struct pen_place up[2], const json_t *document, int view)
{
    return json_object_get(document, "views") ? pen_place_index(&up[1], (size_t)view)
                                              : pen_place_key(&up[0], "camera");
}

/* Writes the JSON Pointer of the object with *left others before it, groups not counted; with
 * `loops`, only triangles and polygons count. Counts *left down. Returns whether there is one. */
static bool find_object(const struct pen_object_desc *objects, uint32_t count, bool loops,
                        const struct pen_place *up, uint32_t *left, char out[PEN_AT_BYTES])
{
    struct pen_place at = pen_place_key(up, "objects");
    for (uint32_t i = 0; i < count; i++) {
        struct pen_place place = pen_place_index(&at, i);
        const struct pen_object_desc *object = &objects[i];
        bool loop = object->kind == PEN_OBJECT_TRIANGLE || object->kind == PEN_OBJECT_POLYGON;
        if (object->kind == PEN_OBJECT_GROUP) {
            if (find_object(object->u.group.objects, object->u.group.count, loops, &place, left,
                            out))
                return true;
        } else if (!object->left_out && (loop || !loops) && (*left)-- == 0) {
            pen_place_pointer(&place, "", out, PEN_AT_BYTES);
            return true;
        }
    }
    return false;
}

static void warn_thin(struct pen_reader *r, const struct pen_scene_desc *desc,
                      const struct pen_scene_precision *precision)
{
    const struct pen_place root = {0};
    struct pen_status st = {.code = PEN_OK};
    char text[PEN_MSG_BYTES], object[PEN_AT_BYTES], pointer[3 * PEN_AT_BYTES];
    uint32_t left = precision->thin_prim;
    if (!pen_thinness_warning(precision, text, sizeof text) ||
        !find_object(desc->objects, desc->object_count, false, &root, &left, object))
        return;
    snprintf(pointer, sizeof pointer, "%.255s%s", r->prefix, object);
    pen_fail_at(&st, PEN_OK, pointer, "%s", text);
    pen_errors_add(r->errors, &st);
}

/* Adds warnings about the first view for which double precision is too coarse, and about the
 * narrowest primitive. */
static void warn_precision(struct pen_reader *r, const json_t *document,
                           const struct pen_scene_desc *desc, const struct pen_scene *scene)
{
    struct pen_scene_precision precision;
    char text[PEN_MSG_BYTES];
    bool warned = false, measured = false;
    struct pen_place up[2] = {{0}};
    up[1] = pen_place_key(&up[0], "views");
    for (int i = 0; i < (int)scene->view_count && !warned; i++) {
        const struct pen_settings *s = &desc->settings;
        struct pen_place at = view_place(up, document, i);
        measured = pen_scene_precision(scene, i, s->width, s->height, &precision);
        warned = measured && pen_precision_warning(&precision, text, sizeof text);
        if (warned)
            warn(r, &at, text);
    }
    if (measured)
        warn_thin(r, desc, &precision);
}

/* Adds a warning about each view in which nothing is visible. */
static void warn_empty_views(struct pen_reader *r, const json_t *document,
                             const struct pen_scene_desc *desc, const struct pen_scene *scene)
{
    const struct pen_settings *s = &desc->settings;
    char text[PEN_MSG_BYTES];
    struct pen_place up[2] = {{0}};
    up[1] = pen_place_key(&up[0], "views");
    for (int i = 0; i < (int)scene->view_count; i++) {
        struct pen_place at = view_place(up, document, i);
        if (pen_view_empty_warning(scene, i, s->width, s->height, text, sizeof text))
            warn(r, &at, text);
    }
}

/* Adds warnings about flat primitives that refract and do not close. */
static void warn_open_solids(struct pen_reader *r, const struct pen_scene_desc *desc,
                             const struct pen_scene *scene)
{
    const struct pen_place root = {0};
    char object[PEN_AT_BYTES], pointer[3 * PEN_AT_BYTES];
    const struct pen_solids *solids = &scene->solids;
    for (uint32_t i = 0; solids->count > 0 && i < scene->prims.count; i++) {
        const uint32_t number = solids->of_prim[i];
        const struct pen_solid *solid = &solids->at[number == PEN_NO_SOLID ? 0 : number];
        struct pen_status st = {.code = PEN_OK};
        uint32_t left = i;
        if (number == PEN_NO_SOLID || solid->closed || solids->prim[solid->first] != i)
            continue;
        if (pen_reader_wants_message(r) &&
            find_object(desc->objects, desc->object_count, false, &root, &left, object)) {
            snprintf(pointer, sizeof pointer, "%.255s%s", r->prefix, object);
            pen_fail_at(
                &st, PEN_OK, pointer,
                "refracts (ior %g), and %s: not every edge is shared, bit for bit, by two "
                "of one material. Rays enter where they come from the side from which the "
                "vertices run counter-clockwise, and leave from the other",
                solid->ior,
                solid->count == 1
                    ? "is no closed surface"
                    : "is not part of a closed surface with the others that it is joined to");
        }
        pen_errors_add(r->errors, &st);
    }
}

/* The number of primitives, plus the vertices of loops. */
static uint64_t count_parts(const struct pen_object_desc *objects, uint32_t count)
{
    uint64_t parts = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (objects[i].kind == PEN_OBJECT_GROUP)
            parts += count_parts(objects[i].u.group.objects, objects[i].u.group.count);
        else if (objects[i].kind == PEN_OBJECT_TRIANGLE || objects[i].kind == PEN_OBJECT_POLYGON)
            parts += 1 + objects[i].u.polygon.count;
        else
            parts++;
    }
    return parts;
}

/* Adds warnings about the frozen scene. A scene that cannot be frozen gets none here; rendering
 * refuses it. Every view tests every primitive. Returns false if that takes too long. */
static bool warn_frozen(struct pen_reader *r, const json_t *document,
                        const struct pen_scene_desc *desc)
{
    struct pen_status st;
    if (count_parts(desc->objects, desc->object_count) * desc->view_count > STEPS_MAX)
        return false;
    struct pen_scene *scene = pen_scene_freeze_without_rays(desc, &st);
    if (!scene)
        return true;
    warn_empty_views(r, document, desc, scene);
    warn_precision(r, document, desc, scene);
    warn_open_solids(r, desc, scene);
    pen_scene_free(scene);
    return true;
}

struct tjunction_warnings {
    struct pen_reader *reader;
    const struct pen_scene_desc *desc;
};

static void warn_tjunction(void *user, const struct pen_tjunction *found)
{
    const struct tjunction_warnings *w = user;
    const struct pen_scene_desc *desc = w->desc;
    const struct pen_place root = {0};
    const char *prefix = w->reader->prefix;
    char vertex_loop[PEN_AT_BYTES], edge_loop[PEN_AT_BYTES], pointer[3 * PEN_AT_BYTES];
    struct pen_status st = {.code = PEN_OK};
    uint32_t loop = found->loop, other = found->edge_loop;
    if (pen_reader_wants_message(w->reader) &&
        find_object(desc->objects, desc->object_count, true, &root, &loop, vertex_loop) &&
        find_object(desc->objects, desc->object_count, true, &root, &other, edge_loop)) {
        snprintf(pointer, sizeof pointer, "%.255s%s/vertices/%u", prefix, vertex_loop,
                 found->vertex);
        pen_fail_at(&st, PEN_OK, pointer,
                    "this vertex lies inside an edge of %.255s%s, along which both run: light may "
                    "leak between them unless the edge has a vertex there too",
                    prefix, edge_loop);
    }
    pen_errors_add(w->reader->errors, &st);
}

/* The last warnings. They replace others if there are too many. */
static void warn_unchecked(struct pen_reader *r, bool frozen, bool tjunctions)
{
    const struct pen_place root = {0};
    const size_t room = (size_t)(PEN_ERRORS_MAX - !frozen - !tjunctions);
    if (r->errors->count > room)
        r->errors->count = room;
    if (!frozen)
        warn(r, &root,
             "empty views, precision, narrow primitives and surfaces that refract were not "
             "checked: there are "
             "too many primitives for so many views");
    if (!tjunctions)
        warn(r, &root,
             "not all edges were searched for T-junctions (vertices of other primitives inside "
             "them): there are too many, or too many lie along one another");
}

void pen_scene_warnings(const json_t *document, const char *at, const struct pen_scene_desc *desc,
                        struct pen_errors *warnings)
{
    struct pen_reader r = {.errors = warnings, .prefix = at};
    for (uint32_t i = 0; i < desc->note_count; i++)
        pen_errors_add(warnings, &desc->notes[i]);
    warn_empty_or_black(&r, desc);
    warn_unused_materials(&r, document, desc);
    warn_dark_lights(&r, desc);
    const bool frozen = warn_frozen(&r, document, desc);
    const bool tjunctions = pen_tjunctions_find(desc, STEPS_MAX, warn_tjunction,
                                                &(struct tjunction_warnings){&r, desc});
    warn_unchecked(&r, frozen, tjunctions);
}
