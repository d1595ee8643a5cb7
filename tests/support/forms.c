/* SPDX-License-Identifier: MIT */
#include "support/forms.h"

#include <string.h>

static const struct pen_vec3 black = {0, 0, 0}, white = {1, 1, 1};

/* Gives every material a pattern of one colour: the one that it has. */
static void pattern_all(struct pen_scene_desc *desc, int colour, bool checker)
{
    enum { MOST = 16 };
    static struct pen_pattern pattern[MOST];
    static struct pen_patterns patterns[MOST];
    for (uint32_t i = 0; i < desc->material_count && i < MOST; i++) {
        struct pen_material *m = &desc->materials[i];
        const struct pen_vec3 c = *pen_material_colour(m, colour);
        pattern[i] = (struct pen_pattern){checker, c, c, 1, {0, 0, 0}, {1, 2, 3}};
        patterns[i] = (struct pen_patterns){{0}};
        patterns[i].of[colour] = &pattern[i];
        m->patterns = &patterns[i];
    }
}

/* The second light shines no more, so it does not matter what else it does. */
static struct pen_light_desc *dark_light(struct pen_scene_desc *desc)
{
    desc->lights[1].intensity = black;
    return &desc->lights[1];
}

static void make_ambient(struct pen_scene_desc *desc, bool idle)
{
    desc->ambient = idle ? white : black;
    for (uint32_t i = 0; i < desc->material_count; i++)
        desc->materials[i].ka = black;
}

static void make_hard_shadows(struct pen_scene_desc *desc, bool idle)
{
    desc->lights[0].shadows = false;
    dark_light(desc)->shadows = idle;
}

static void make_soft_shadows(struct pen_scene_desc *desc, bool idle)
{
    dark_light(desc)->radius = idle;
}

static void make_kt_pattern(struct pen_scene_desc *desc, bool idle)
{
    if (idle)
        pattern_all(desc, PEN_COLOUR_KT, true);
}

static void make_kr_pattern(struct pen_scene_desc *desc, bool idle)
{
    if (idle)
        pattern_all(desc, PEN_COLOUR_KR, false);
}

static void make_weak_kr(struct pen_scene_desc *desc, bool idle)
{
    desc->settings.min_contribution = 0.01;
    for (uint32_t i = 0; i < desc->material_count && idle; i++)
        desc->materials[i].kr = pen_vec3(0.005, 0, 0);
}

static void make_lens_samples(struct pen_scene_desc *desc, bool idle)
{
    desc->settings.lens_samples = idle ? 16 : 1;
}

static void make_ks_pattern(struct pen_scene_desc *desc, bool idle)
{
    for (uint32_t i = 0; i < desc->material_count; i++)
        desc->materials[i].ks = black;
    if (idle)
        pattern_all(desc, PEN_COLOUR_KS, true);
}

static void make_plain_sky(struct pen_scene_desc *desc, bool idle)
{
    desc->has_sky = idle;
    desc->sky = (struct pen_sky){desc->background, desc->background, {1, 2, 3}};
}

static void make_unseen_sky(struct pen_scene_desc *desc, bool idle)
{
    desc->has_sky = idle;
    desc->sky = (struct pen_sky){white, black, {0, 1, 0}};
}

static void make_focus(struct pen_scene_desc *desc, bool idle)
{
    desc->views[0].camera.focus_distance = idle ? 3 : 1;
}

static void make_checkers(struct pen_scene_desc *desc, bool idle)
{
    if (idle)
        pattern_all(desc, PEN_COLOUR_KD, true);
}

static void make_gradients(struct pen_scene_desc *desc, bool idle)
{
    if (idle)
        pattern_all(desc, PEN_COLOUR_KD, false);
}

static void make_ior(struct pen_scene_desc *desc, bool idle)
{
    for (uint32_t i = 0; i < desc->material_count && idle; i++)
        desc->materials[i].ior = 1.5;
}

static void make_blur(struct pen_scene_desc *desc, bool idle)
{
    for (uint32_t i = 0; i < desc->material_count && idle; i++)
        desc->materials[i].reflection_blur = desc->materials[i].transmission_blur = 10;
}

/* Adds a black tetrahedron, in the idle form with normals. */
static void make_normals(struct pen_scene_desc *desc, bool idle)
{
    enum { MOST = 16 };
    static struct pen_object_desc objects[MOST];
    static struct pen_material materials[MOST];
    static const float vertex[] = {1, 1, 3, 2, 1, 3, 1, 2, 3, 1, 1, 4};
    static const uint32_t corner[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    static int material;
    static struct pen_mesh_desc mesh;
    const uint32_t count = desc->object_count < MOST ? desc->object_count : MOST - 1;
    material = (int)(desc->material_count < MOST ? desc->material_count : MOST - 1);
    memcpy(objects, desc->objects, count * sizeof *objects);
    memcpy(materials, desc->materials, (size_t)material * sizeof *materials);
    materials[material] = pen_material_default();
    materials[material].ka = materials[material].kd = black;
    mesh = (struct pen_mesh_desc){.vertex_count = 4,
                                  .triangle_count = 4,
                                  .vertex = vertex,
                                  .corner = corner,
                                  .normal = idle ? vertex : NULL,
                                  .normal_count = 4,
                                  .material = &material,
                                  .material_count = 1};
    objects[count] = (struct pen_object_desc){.kind = PEN_OBJECT_MESH, .u.mesh = &mesh};
    desc->objects = objects;
    desc->object_count = count + 1;
    desc->materials = materials;
    desc->material_count = (uint32_t)material + 1;
    desc->primitive_count += mesh.triangle_count;
}

const struct form forms[] = {
    {"ambient-no-ka", PEN_FX_AMBIENT, make_ambient, false},
    {"shadows-of-a-dark-light", PEN_FX_HARD_SHADOWS, make_hard_shadows, false},
    {"radius-of-a-dark-light", PEN_FX_SOFT_SHADOWS, make_soft_shadows, false},
    {"kt-pattern-of-0", PEN_FX_TRANSMISSION | PEN_FX_SHADOW_TRANSMITTANCE, make_kt_pattern, false},
    {"kr-pattern-of-0", PEN_FX_MIRROR, make_kr_pattern, false},
    {"weak-kr", PEN_FX_MIRROR, make_weak_kr, false},
    {"lens-samples-no-lens", PEN_FX_ANTI_ALIASING, make_lens_samples, false},
    {"ks-pattern-of-0", PEN_FX_SPECULAR, make_ks_pattern, false},
    {"sky-of-one-colour", PEN_FX_SKY, make_plain_sky, false},
    {"unseen-sky", PEN_FX_SKY, make_unseen_sky, true},
    {"focus-no-lens", PEN_FX_DEPTH_OF_FIELD, make_focus, false},
    {"equal-checkers", PEN_FX_PATTERNS, make_checkers, false},
    {"equal-gradients", PEN_FX_PATTERNS, make_gradients, false},
    {"ior-no-kt", PEN_FX_REFRACTION, make_ior, false},
    {"blur-no-rays", PEN_FX_GLOSSY | PEN_FX_FROSTED, make_blur, false},
    {"normals-of-black", PEN_FX_SMOOTH_NORMALS, make_normals, false},
    {NULL, 0, NULL, false}};

const struct form *form_find(const char *name)
{
    for (const struct form *form = forms; form->name; form++)
        if (strcmp(form->name, name) == 0)
            return form;
    return NULL;
}
