/* SPDX-License-Identifier: MIT */
/* Which effects a scene needs: those that some primitive, light or setting can make visible. The
 * kernel is chosen by this set, so a bit must be set whenever leaving the effect out could change
 * one bit of the picture. The values in the document alone decide, never a threshold. */
#include "scene/internal/effects.h"

#include "scene/internal/vec.h"

_Static_assert(PEN_FX_PATTERNS == 1 << (PEN_FX_COUNT - 1), "the last effect has the last bit");

const char *pen_effect_name(int bit)
{
    if (bit < 0 || bit >= PEN_FX_COUNT)
        return "unknown";
    switch ((enum pen_effect)(1 << bit)) {
    case PEN_FX_AMBIENT:
        return "ambient";
    case PEN_FX_HARD_SHADOWS:
        return "hard_shadows";
    case PEN_FX_SOFT_SHADOWS:
        return "soft_shadows";
    case PEN_FX_SHADOW_TRANSMITTANCE:
        return "shadow_transmittance";
    case PEN_FX_MIRROR:
        return "mirror";
    case PEN_FX_TRANSMISSION:
        return "transmission";
    case PEN_FX_ANTI_ALIASING:
        return "anti_aliasing";
    case PEN_FX_SPECULAR:
        return "specular";
    case PEN_FX_SKY:
        return "sky";
    case PEN_FX_DEPTH_OF_FIELD:
        return "depth_of_field";
    case PEN_FX_PATTERNS:
        return "patterns";
    }
    return "unknown";
}

/* What has been found in a scene while its primitives are visited. */
struct survey {
    bool ambient_light, lights; /* lights: one with intensity > 0 */
    unsigned shadows;           /* the kinds of shadows that such lights cast */
    bool see_through;           /* a primitive has kt > 0 */
    bool forks;                 /* a primitive has kt > 0 and kr > 0 */
    unsigned effects;
};

/* A sky of one colour is a plain background. */
static unsigned effect_of_sky(const struct pen_sky *sky, struct pen_vec3 horizon)
{
    bool plain = vec_equal(sky->zenith, horizon) && vec_equal(sky->nadir, horizon);
    return plain ? 0u : PEN_FX_SKY;
}

static unsigned shadow_kind(bool shadows, bool soft)
{
    return !shadows ? 0u : soft ? PEN_FX_SOFT_SHADOWS : PEN_FX_HARD_SHADOWS;
}

/* Adds the effects of one primitive's material. Materials that no primitive has do not count. */
static void add_material(struct survey *survey, const struct pen_material *m)
{
    if (survey->ambient_light && color_is_lit(m->ka))
        survey->effects |= PEN_FX_AMBIENT;
    if (color_is_lit(m->kr))
        survey->effects |= PEN_FX_MIRROR;
    if (color_is_lit(m->kt))
        survey->effects |= PEN_FX_TRANSMISSION;
    if (survey->lights && color_is_lit(m->ks))
        survey->effects |= PEN_FX_SPECULAR;
    if (color_is_lit(m->kd) || color_is_lit(m->ks))
        survey->effects |= survey->shadows;
    if (m->patterns)
        survey->effects |= PEN_FX_PATTERNS;
    survey->see_through = survey->see_through || color_is_lit(m->kt);
    survey->forks = survey->forks || (color_is_lit(m->kt) && color_is_lit(m->kr));
}

/* All effects found. Light through see-through primitives matters only where there are shadows. */
static unsigned survey_end(const struct survey *survey)
{
    bool colours = (survey->effects & survey->shadows) && survey->see_through;
    return survey->effects | (colours ? PEN_FX_SHADOW_TRANSMITTANCE : 0u);
}

unsigned pen_effects_of_scene(const struct pen_scene *scene)
{
    struct survey survey = {.ambient_light = color_is_lit(scene->ambient),
                            .lights = scene->light_count > 0,
                            .effects = effect_of_sky(&scene->sky, scene->background)};
    for (uint32_t i = 0; i < scene->light_count; i++)
        survey.shadows |= shadow_kind(scene->lights[i].shadows, scene->lights[i].soft);
    for (uint32_t i = 0; i < scene->prims.count; i++)
        add_material(&survey, &scene->materials[scene->prim_material[i]]);
    return survey_end(&survey);
}

static void survey_objects(struct survey *survey, const struct pen_scene_desc *desc,
                           const struct pen_object_desc *objects, uint32_t count)
{
    const struct pen_material none = pen_material_default();
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *o = &objects[i];
        if (o->kind == PEN_OBJECT_GROUP)
            survey_objects(survey, desc, o->u.group.objects, o->u.group.count);
        else
            add_material(survey, o->material < 0 ? &none : &desc->materials[o->material]);
    }
}

int pen_camera_samples(bool lens, const struct pen_settings *settings)
{
    const int pixel = settings->samples_per_pixel;
    return lens && settings->lens_samples > pixel ? settings->lens_samples : pixel;
}

static bool has_lens(const struct pen_camera_desc *camera)
{
    return camera->aperture_radius > 0;
}

bool pen_desc_has_lens(const struct pen_scene_desc *desc)
{
    bool lens = false;
    for (uint32_t i = 0; i < desc->view_count; i++)
        lens |= has_lens(&desc->views[i].camera);
    return lens;
}

static unsigned with_settings(unsigned effects, bool lens, const struct pen_settings *settings)
{
    if (settings->max_depth <= 1)
        effects &= ~(unsigned)(PEN_FX_MIRROR | PEN_FX_TRANSMISSION);
    if (lens)
        effects |= PEN_FX_DEPTH_OF_FIELD;
    if (pen_camera_samples(lens, settings) > 1)
        effects |= PEN_FX_ANTI_ALIASING;
    return effects;
}

unsigned pen_desc_effects(const struct pen_scene_desc *desc, const struct pen_settings *settings)
{
    struct survey survey = {.ambient_light = color_is_lit(desc->ambient)};
    if (desc->has_sky)
        survey.effects = effect_of_sky(&desc->sky, desc->background);
    for (uint32_t i = 0; i < desc->light_count; i++) {
        const struct pen_light_desc *light = &desc->lights[i];
        if (!color_is_lit(light->intensity))
            continue;
        survey.lights = true;
        survey.shadows |= shadow_kind(light->shadows, pen_light_desc_soft(light));
    }
    survey_objects(&survey, desc, desc->objects, desc->object_count);
    return with_settings(survey_end(&survey), pen_desc_has_lens(desc), settings);
}

bool pen_desc_forks(const struct pen_scene_desc *desc)
{
    struct survey survey = {0};
    survey_objects(&survey, desc, desc->objects, desc->object_count);
    return survey.forks;
}

unsigned pen_scene_effects(const struct pen_scene *scene, int view,
                           const struct pen_settings *settings)
{
    return with_settings(scene->effects, has_lens(&scene->views[view].camera), settings);
}
