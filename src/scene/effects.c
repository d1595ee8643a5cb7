/* SPDX-License-Identifier: MIT */
/* Which effects a scene calls for: those that some body, light or setting can make visible. A
 * kernel is picked by this set, so a bit must be set whenever leaving the effect out could change
 * one bit of the picture; only what is written in the document decides, never a threshold. */
#include "effects.h"

#include "unit.h"

const char *pen_effect_name(int bit)
{
    static const char *const names[PEN_FX_COUNT] = {
        "ambient",       "hard_shadows", "shadow_transmittance", "mirror", "transmission",
        "anti_aliasing", "specular",
    };
    return bit >= 0 && bit < PEN_FX_COUNT ? names[bit] : "unknown";
}

/* The effects that materials call for; those that no body has do not count. */
static unsigned material_effects(const struct pen_scene *scene)
{
    unsigned effects = 0;
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        const struct pen_material *m = &scene->materials[scene->prim_material[i]];
        if (unit_lit(scene->ambient) && unit_lit(m->ka))
            effects |= PEN_FX_AMBIENT;
        if (unit_lit(m->kr))
            effects |= PEN_FX_MIRROR;
        if (unit_lit(m->kt))
            effects |= PEN_FX_TRANSMISSION;
        if (scene->light_count > 0 && unit_lit(m->ks))
            effects |= PEN_FX_SPECULAR;
        if (scene->light_count > 0 && (unit_lit(m->kd) || unit_lit(m->ks)))
            effects |= PEN_FX_HARD_SHADOWS;
    }
    return effects;
}

unsigned pen_effects_of_scene(const struct pen_scene *scene)
{
    unsigned effects = material_effects(scene);
    bool shadows = false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        shadows = shadows || scene->lights[i].shadows;
    if (!shadows)
        effects &= ~(unsigned)PEN_FX_HARD_SHADOWS;
    if ((effects & PEN_FX_HARD_SHADOWS) && scene->any_see_through)
        effects |= PEN_FX_SHADOW_TRANSMITTANCE;
    return effects;
}

unsigned pen_scene_effects(const struct pen_scene *scene, const struct pen_settings *settings)
{
    unsigned effects = scene->effects;
    if (settings->max_depth <= 1)
        effects &= ~(unsigned)(PEN_FX_MIRROR | PEN_FX_TRANSMISSION);
    if (settings->samples_per_pixel > 1)
        effects |= PEN_FX_ANTI_ALIASING;
    return effects;
}
