/* SPDX-License-Identifier: MIT */
#include "study/leave_out.h"

#include <string.h>

static const struct pen_vec3 black = {0, 0, 0};

/* A copy of an array; NULL if there is no memory. */
static void *copy_of(struct pen_arena *arena, const void *from, size_t count, size_t bytes)
{
    void *to = pen_arena_alloc(arena, count + 1, bytes);
    if (to && count > 0)
        memcpy(to, from, count * bytes);
    return to;
}

static void without_pattern(struct pen_arena *arena, struct pen_material *m, int colour)
{
    struct pen_patterns *patterns =
        m->patterns ? copy_of(arena, m->patterns, 1, sizeof *patterns) : NULL;
    if (patterns) {
        patterns->of[colour] = NULL;
        m->patterns = patterns;
    }
}

static void set_black(struct pen_arena *arena, struct pen_material *m, int colour)
{
    *pen_material_colour(m, colour) = black;
    without_pattern(arena, m, colour);
}

static void change_material(struct pen_arena *arena, struct pen_material *m, unsigned effect)
{
    switch ((enum pen_effect)effect) {
    case PEN_FX_MIRROR:
        set_black(arena, m, PEN_COLOUR_KR);
        break;
    case PEN_FX_TRANSMISSION:
        set_black(arena, m, PEN_COLOUR_KT);
        break;
    case PEN_FX_SPECULAR:
        set_black(arena, m, PEN_COLOUR_KS);
        break;
    case PEN_FX_PATTERNS:
        m->patterns = NULL;
        break;
    case PEN_FX_REFRACTION:
        m->ior = 1;
        m->ior_written = false;
        break;
    case PEN_FX_GLOSSY:
        m->reflection_blur = 0;
        break;
    case PEN_FX_FROSTED:
        m->transmission_blur = 0;
        break;
    case PEN_FX_AMBIENT:
    case PEN_FX_HARD_SHADOWS:
    case PEN_FX_SOFT_SHADOWS:
    case PEN_FX_SHADOW_TRANSMITTANCE:
    case PEN_FX_ANTI_ALIASING:
    case PEN_FX_SKY:
    case PEN_FX_DEPTH_OF_FIELD:
    case PEN_FX_SMOOTH_NORMALS:
        break;
    }
}

static void change_light(struct pen_light_desc *light, unsigned effect)
{
    if (effect == PEN_FX_HARD_SHADOWS && !pen_light_desc_soft(light))
        light->shadows = false;
    if (effect == PEN_FX_SOFT_SHADOWS)
        light->radius = light->angular_radius = 0;
}

/* A copy of objects in which meshes have no normals; NULL if there is no memory. */
static struct pen_object_desc *without_normals(struct pen_arena *arena,
                                               const struct pen_object_desc *from, uint32_t count)
{
    struct pen_object_desc *to = copy_of(arena, from, count, sizeof *to);
    bool ok = to != NULL;
    for (uint32_t i = 0; ok && i < count; i++) {
        if (to[i].kind == PEN_OBJECT_GROUP) {
            to[i].u.group.objects =
                without_normals(arena, from[i].u.group.objects, from[i].u.group.count);
            ok = to[i].u.group.objects != NULL;
        } else if (to[i].kind == PEN_OBJECT_MESH) {
            struct pen_mesh_desc *mesh = copy_of(arena, from[i].u.mesh, 1, sizeof *mesh);
            to[i].u.mesh = mesh;
            ok = mesh != NULL;
            if (ok)
                mesh->normal = NULL;
        }
    }
    return ok ? to : NULL;
}

bool pen_scene_leave_out(const struct pen_scene_desc *from, unsigned effect,
                         struct pen_arena *arena, struct pen_scene_desc *to,
                         struct pen_settings *settings)
{
    *to = *from;
    to->materials = copy_of(arena, from->materials, from->material_count, sizeof *to->materials);
    to->lights = copy_of(arena, from->lights, from->light_count, sizeof *to->lights);
    to->views = copy_of(arena, from->views, from->view_count, sizeof *to->views);
    if (effect == PEN_FX_SMOOTH_NORMALS)
        to->objects = without_normals(arena, from->objects, from->object_count);
    if (!to->materials || !to->lights || !to->views || !to->objects)
        return false;
    for (uint32_t i = 0; i < to->material_count; i++)
        change_material(arena, &to->materials[i], effect);
    for (uint32_t i = 0; i < to->light_count; i++)
        change_light(&to->lights[i], effect);
    for (uint32_t i = 0; i < to->view_count && effect == PEN_FX_DEPTH_OF_FIELD; i++)
        to->views[i].camera.aperture_radius = 0;
    if (effect == PEN_FX_AMBIENT)
        to->ambient = black;
    if (effect == PEN_FX_SKY)
        to->has_sky = false;
    if (effect == PEN_FX_SHADOW_TRANSMITTANCE)
        to->opaque_shadows = true;
    if (effect == PEN_FX_ANTI_ALIASING) {
        settings->samples_per_pixel = 1;
        settings->target_error = 0;
    }
    return true;
}
