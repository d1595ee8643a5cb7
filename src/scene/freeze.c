/* SPDX-License-Identifier: MIT */
/* Freezing: from the description to the scene that kernels read. Two passes over the primitives:
 * the first counts them and finds the local frame, the second (freeze_prims.c) fills the typed
 * arrays. All memory that the scene keeps is in its arena, whose cap is the job's memory limit. */
#include "scene/internal/freeze.h"

#include <fenv.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "math/fn.h"
#include "math/scale.h"
#include "scene/freeze_without_rays.h"
#include "scene/internal/effects.h"

/* Primitive numbers must fit into pen_prim_ref. */
enum { PRIMS_MAX = 1 << 28 };

static bool summarize_primitive(struct pen_freezer *f, const struct pen_scene_prim *scene_prim,
                                void *user)
{
    (void)user;
    if (f->summary.total + (scene_prim->mesh ? scene_prim->mesh->triangle_count : 1) > PRIMS_MAX)
        return pen_fail(f->st, PEN_INVALID, "is one primitive too many: %d are possible",
                        PRIMS_MAX);
    if (scene_prim->mesh)
        return pen_freeze_mesh_begin(f, scene_prim);
    pen_prim_summary_add(&f->summary, scene_prim);
    return true;
}

/* Copies the views: names, cameras as described, and their frames. */
static bool freeze_views(struct pen_freezer *f)
{
    struct pen_arena *arena = f->scene->arena;
    uint32_t count = f->desc->view_count;
    struct pen_scene_view *views = pen_arena_alloc(arena, count, sizeof *views);
    f->cameras = pen_arena_alloc(arena, count, sizeof *f->cameras);
    if (!views || !f->cameras)
        return pen_freeze_no_memory(f);
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_view_desc *view = &f->desc->views[i];
        views[i].name = pen_arena_strdup(arena, view->name);
        if (!views[i].name)
            return pen_freeze_no_memory(f);
        if (!pen_camera_frame_make(&view->camera, &views[i].frame, f->st))
            return false;
        views[i].camera = view->camera;
        views[i].camera.moves = NULL; /* already applied to the frame */
        views[i].camera.move_count = 0;
        f->cameras[i] = views[i].frame;
    }
    f->scene->views = f->views = views;
    f->scene->view_count = count;
    return true;
}

/* Whether the eye and the lens of a view are representable in the local frame. */
static bool freeze_view_in_range(struct pen_freezer *f, uint32_t i)
{
    const struct pen_camera_desc *camera = &f->desc->views[i].camera;
    const char *what = NULL;
    if (!pen_freeze_in_range(pen_local_point(&f->frame, f->cameras[i].eye)))
        what = "the eye is too far from the scene";
    else if (!(pen_local_length(&f->frame, camera->aperture_radius) <= FREEZE_LOCAL_MAX))
        what = "the aperture is too large for the scene";
    else if (!(pen_local_length(&f->frame, camera->focus_distance) <= FREEZE_LOCAL_MAX))
        what = "the plane in focus is too far from the scene";
    return !what || pen_fail(f->st, PEN_INVALID, "view \"%s\": %s", f->desc->views[i].name, what);
}

static bool freeze_frame(struct pen_freezer *f)
{
    f->summary = pen_prim_summary_empty();
    if (!pen_freeze_each(f, summarize_primitive, NULL))
        return false;
    if (!pen_local_frame_make(&f->summary, f->cameras, f->desc->view_count, &f->frame))
        return pen_fail(f->st, PEN_INVALID, "the scene is larger than a double can hold");
    f->scene->center = f->frame.center;
    f->scene->exponent = f->frame.exponent;
    for (uint32_t i = 0; i < f->desc->view_count; i++)
        if (!freeze_view_in_range(f, i))
            return false;
    return true;
}

/* Copies the patterns of a material into the scene's arena. A pattern of two equal colours becomes
 * that colour, so that it costs no more than a plain one. */
static bool keep_patterns(struct pen_freezer *f, struct pen_material *material)
{
    const struct pen_patterns *given = material->patterns;
    struct pen_patterns *kept = NULL;
    if (pen_material_is_patterned(material) &&
        !(kept = pen_arena_alloc(f->scene->arena, 1, sizeof *kept)))
        return false;
    for (int i = 0; i < PEN_MATERIAL_COLOURS; i++) {
        const struct pen_pattern *from = pen_material_pattern(material, i);
        struct pen_pattern *to = from ? pen_arena_alloc(f->scene->arena, 1, sizeof *to) : NULL;
        if (from && !to)
            return false;
        if (from)
            *to = *from;
        else if (given->of[i])
            *pen_material_colour(material, i) = given->of[i]->a;
        if (kept)
            kept->of[i] = to;
    }
    material->patterns = kept;
    return true;
}

/* The cone of blurred rays: 1 - cos a = 2 sin^2(a / 2). */
static double cone_of(double degrees)
{
    double sine, cosine;
    pen_sincos_deg(0.5 * degrees, &sine, &cosine);
    return 2 * sine * sine;
}

static bool freeze_blurs(struct pen_freezer *f)
{
    struct pen_scene *scene = f->scene;
    struct pen_blur *blurs = pen_arena_alloc(scene->arena, scene->material_count, sizeof *blurs);
    if (!blurs)
        return pen_freeze_no_memory(f);
    for (uint32_t i = 0; i < scene->material_count; i++) {
        blurs[i].reflection = cone_of(scene->materials[i].reflection_blur);
        blurs[i].transmission = cone_of(scene->materials[i].transmission_blur);
    }
    scene->blurs = blurs;
    return true;
}

/* Copies the materials and appends the default one, for primitives without a material. */
static bool freeze_materials(struct pen_freezer *f)
{
    uint32_t count = f->desc->material_count;
    struct pen_material *materials =
        pen_arena_alloc(f->scene->arena, (size_t)count + 1, sizeof *materials);
    if (!materials)
        return pen_freeze_no_memory(f);
    if (count > 0)
        memcpy(materials, f->desc->materials, count * sizeof *materials);
    materials[count] = pen_material_default();
    for (uint32_t i = 0; i < count; i++)
        if (materials[i].patterns && !keep_patterns(f, &materials[i]))
            return pen_freeze_no_memory(f);
    f->scene->materials = materials;
    f->scene->material_count = count + 1;
    return freeze_blurs(f);
}

/* A light in the local frame, where distances are multiplied by 2^-exponent. */
static struct pen_light light_in_local_frame(const struct pen_freezer *f,
                                             const struct pen_light_desc *desc)
{
    struct pen_light light = {
        .positional = pen_light_positional(desc->kind),
        .beam = pen_light_positional(desc->kind) && pen_light_directed(desc->kind),
        .shadows = desc->shadows,
        .intensity = desc->intensity,
        .kc = desc->attenuation[0],
        .kl = pen_scale2(desc->attenuation[1], f->frame.exponent),
        .kq = pen_scale2(desc->attenuation[2], 2 * f->frame.exponent),
        .beam_exponent = desc->beam_exponent,
    };
    if (pen_light_directed(desc->kind))
        light.direction = vec_normalize(desc->direction);
    if (light.positional) {
        light.position = pen_local_point(&f->frame, desc->position);
        light.radius = pen_local_length(&f->frame, desc->radius);
    } else {
        double sine, cosine;
        pen_sincos_deg(desc->angular_radius, &sine, &cosine);
        light.radius = sine / cosine;
    }
    light.soft = desc->shadows && pen_light_desc_soft(desc);
    return light;
}

/* Fails with an error at a key of a light. */
static bool fail_light(struct pen_freezer *f, uint32_t index, const char *key, const char *what)
{
    pen_fail(f->st, PEN_INVALID, "%s", what);
    snprintf(f->st->at, sizeof f->st->at, "/lights/%u/%s", index, key);
    return false;
}

/* Keeps the lights with intensity above 0 in some channel, in document order. */
static bool freeze_lights(struct pen_freezer *f)
{
    uint32_t count = f->desc->light_count, kept = 0;
    struct pen_light *lights = pen_arena_alloc(f->scene->arena, count, sizeof *lights);
    uint32_t *index = pen_arena_alloc(f->scene->arena, count, sizeof *index);
    if (!lights || !index)
        return pen_freeze_no_memory(f);
    for (uint32_t i = 0; i < count; i++) {
        if (!color_is_lit(f->desc->lights[i].intensity))
            continue;
        lights[kept] = light_in_local_frame(f, &f->desc->lights[i]);
        index[kept] = i;
        if (!pen_freeze_in_range(lights[kept].position))
            return fail_light(f, i, "position", "is too far from the scene");
        if (!(lights[kept].radius <= FREEZE_LOCAL_MAX))
            return fail_light(f, i, "radius", "is too large for the scene");
        kept++;
    }
    f->scene->lights = lights;
    f->scene->light_index = index;
    f->scene->light_count = kept;
    return true;
}

static void freeze_background(struct pen_freezer *f)
{
    const struct pen_vec3 horizon = f->desc->background;
    struct pen_sky *sky = &f->scene->sky;
    *sky = (struct pen_sky){.zenith = horizon, .nadir = horizon, .up = {0, 1, 0}};
    if (f->desc->has_sky)
        *sky = (struct pen_sky){f->desc->sky.zenith, f->desc->sky.nadir,
                                vec_normalize(f->desc->sky.up)};
    f->scene->background = horizon;
}

static bool freeze_all(struct pen_freezer *f)
{
    freeze_background(f);
    f->scene->ambient = f->desc->ambient;
    if (!freeze_views(f) || !freeze_frame(f) || !freeze_materials(f) || !freeze_lights(f) ||
        !pen_freeze_prims(f) || !pen_freeze_own_spaces(f) || (f->rays && !pen_freeze_layers(f)))
        return false;
    if (!pen_freeze_solids(f))
        return false;
    pen_effects_find(f->scene);
    return true;
}

static bool build_accel(struct pen_freezer *f, enum pen_accelerator accelerator)
{
    struct pen_scene *scene = f->scene;
    const int limit = f->desc->settings.threads, wanted = f->desc->build_threads;
    const int threads = limit > 0 && limit < wanted ? limit : wanted;
    scene->accel =
        accelerator == PEN_ACCEL_MANUAL
            ? pen_freeze_manual(f)
            : pen_accel_build_threads(&scene->prims, accelerator, threads, scene->arena, f->st);
    return scene->accel != NULL;
}

/* Freezes a scene. `accelerator`: NULL if no ray will be traced. */
static struct pen_scene *freeze(const struct pen_scene_desc *desc,
                                const enum pen_accelerator *accelerator, size_t cap_bytes,
                                struct pen_status *st)
{
    int64_t begun = pen_clock_ns();
    struct pen_arena *arena = pen_arena_new(cap_bytes);
    struct pen_scene *scene = arena ? pen_arena_alloc(arena, 1, sizeof *scene) : NULL;
    struct pen_freezer f = {.desc = desc,
                            .scene = scene,
                            .st = st,
                            .cap_bytes = cap_bytes,
                            .rays = accelerator != NULL};
    if (!scene) {
        pen_freeze_no_memory(&f);
        pen_arena_free(arena);
        return NULL;
    }
    scene->arena = arena;
    fenv_t caller; /* the scene must not depend on the caller's rounding mode */
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    bool ok = freeze_all(&f);
    free(f.buffer);
    free(f.mesh);
    scene->freeze_ms = (double)(pen_clock_ns() - begun) * 1e-6;
    ok = ok && (!f.rays || build_accel(&f, *accelerator));
    fesetenv(&caller);
    if (ok)
        return scene;
    pen_arena_free(arena);
    return NULL;
}

struct pen_scene *pen_scene_freeze(const struct pen_scene_desc *desc,
                                   enum pen_accelerator accelerator, size_t cap_bytes,
                                   struct pen_status *st)
{
    return freeze(desc, &accelerator, cap_bytes, st);
}

struct pen_scene *pen_scene_freeze_without_rays(const struct pen_scene_desc *desc,
                                                struct pen_status *st)
{
    return freeze(desc, NULL, 0, st);
}

void pen_scene_free(struct pen_scene *scene)
{
    if (!scene)
        return;
    pen_arena_free(scene->description);
    pen_arena_free(scene->arena);
}

void pen_scene_take_description(struct pen_scene *scene, struct pen_arena *arena)
{
    if (scene->prims.mesh_count > 0)
        scene->description = arena;
    else
        pen_arena_free(arena);
}

size_t pen_scene_bytes(const struct pen_scene *scene)
{
    return pen_arena_used(scene->arena) +
           (scene->description ? pen_arena_used(scene->description) : 0);
}

int pen_scene_find_view(const struct pen_scene *scene, const char *name)
{
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (strcmp(scene->views[i].name, name) == 0)
            return (int)i;
    return -1;
}
