/* SPDX-License-Identifier: MIT */
/* The effects that a scene needs: those that some primitive, light or setting can make visible. The
 * kernel is chosen by this set, so a bit must be set if leaving the effect out could change one bit
 * of the picture. The values in the document decide, never a threshold. The exception is
 * min_contribution, below which no secondary ray is traced: effects that need weaker rays are left
 * out. */
#include "scene/internal/effects.h"

#include "scene/internal/vec.h"

_Static_assert(PEN_FX_SMOOTH_NORMALS == 1 << (PEN_FX_COUNT - 1),
               "the last effect has the last bit");

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
    case PEN_FX_REFRACTION:
        return "refraction";
    case PEN_FX_GLOSSY:
        return "glossy";
    case PEN_FX_FROSTED:
        return "frosted";
    case PEN_FX_SMOOTH_NORMALS:
        return "smooth_normals";
    }
    return "unknown";
}

/* Findings about a scene while its primitives are visited. */
struct survey {
    struct pen_secondary_factors factors;
    bool ambient_light, lights; /* lights: one with intensity > 0 */
    unsigned shadows;           /* the kinds of shadows that such lights cast */
    bool see_through;           /* a primitive has kt > 0, */
    bool opaque_shadows;        /* it lets no light pass */
    bool forks;                 /* a primitive has kt > 0, and has kr > 0 or refracts */
    bool weights_grow;          /* some factor of a weight is above 1 */
    bool ones_are_solids;       /* of a description: primitives with a written index of 1 */
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

static double largest_channel(struct pen_vec3 c)
{
    return pen_larger(c.x, pen_larger(c.y, c.z));
}

/* A bound of a material's colour, in each channel. The colour of a gradient is a + share (b - a),
 * which rounding may move beyond b. */
static struct pen_vec3 colour_bound(const struct pen_material *m, enum pen_material_colours colour,
                                    struct pen_vec3 plain)
{
    const struct pen_pattern *pattern = pen_material_pattern(m, (int)colour);
    if (!pattern)
        return plain;
    const struct pen_vec3 a = pattern->a, b = pattern->b;
    const struct pen_vec3 end = pen_add(a, pen_sub(b, a));
    return pen_vec3(pen_larger(a.x, pen_larger(b.x, end.x)),
                    pen_larger(a.y, pen_larger(b.y, end.y)),
                    pen_larger(a.z, pen_larger(b.z, end.z)));
}

/* Records secondary rays that have at most this factor. */
static void add_factor(struct survey *survey, double *largest, double factor)
{
    *largest = pen_larger(*largest, factor);
    survey->weights_grow = survey->weights_grow || factor > 1;
}

/* Adds the effects of the secondary rays of a material, which may belong to a solid. If it
 * refracts, Fresnel's share of kt is reflected with kr. */
static void add_secondary(struct survey *survey, const struct pen_material *m, bool solid)
{
    struct pen_secondary_factors *largest = &survey->factors;
    const bool mirrors = color_is_lit(m->kr), transmits = color_is_lit(m->kt);
    const bool refracts = transmits && solid;
    const struct pen_vec3 kr = colour_bound(m, PEN_COLOUR_KR, m->kr);
    const struct pen_vec3 kt = colour_bound(m, PEN_COLOUR_KT, m->kt);
    const double reflected = largest_channel(refracts ? pen_add(kr, kt) : kr);
    const double transmitted = largest_channel(kt);
    if (mirrors) {
        survey->effects |= PEN_FX_MIRROR;
        add_factor(survey, &largest->mirror, reflected);
    }
    if (transmits) {
        survey->effects |= PEN_FX_TRANSMISSION;
        add_factor(survey, &largest->transmission, transmitted);
    }
    if (refracts) {
        survey->effects |= PEN_FX_REFRACTION;
        add_factor(survey, &largest->refraction, reflected);
    }
    if ((mirrors || refracts) && m->reflection_blur > 0) {
        survey->effects |= PEN_FX_GLOSSY;
        add_factor(survey, &largest->glossy, reflected);
    }
    if (transmits && m->transmission_blur > 0) {
        survey->effects |= PEN_FX_FROSTED;
        add_factor(survey, &largest->frosted, transmitted);
    }
}

/* Adds the effects of one primitive's material; `solid`: it is of a solid. Materials without a
 * primitive do not count. */
static void add_material(struct survey *survey, const struct pen_material *m, bool solid)
{
    if (survey->ambient_light && color_is_lit(m->ka))
        survey->effects |= PEN_FX_AMBIENT;
    add_secondary(survey, m, solid);
    if (survey->lights && color_is_lit(m->ks))
        survey->effects |= PEN_FX_SPECULAR;
    if (color_is_lit(m->kd) || color_is_lit(m->ks))
        survey->effects |= survey->shadows;
    if (pen_material_is_patterned(m))
        survey->effects |= PEN_FX_PATTERNS;
    survey->see_through = survey->see_through || color_is_lit(m->kt);
    survey->forks = survey->forks || (color_is_lit(m->kt) && (color_is_lit(m->kr) || solid));
}

/* Adds the effect of a mesh's normals, if this material of the mesh reflects light. */
static void add_normals(struct survey *survey, const struct pen_material *m)
{
    if (survey->lights && (color_is_lit(m->kd) || color_is_lit(m->ks)))
        survey->effects |= PEN_FX_SMOOTH_NORMALS;
}

/* The factors. If a weight may grow along its path, no single factor bounds it. */
static struct pen_secondary_factors survey_factors(const struct survey *survey)
{
    if (survey->weights_grow)
        return (struct pen_secondary_factors){INFINITY, INFINITY, INFINITY, INFINITY, INFINITY};
    return survey->factors;
}

/* All effects found. Light through transmissive primitives matters only if there are shadows. */
static unsigned survey_end(const struct survey *survey)
{
    bool colours =
        (survey->effects & survey->shadows) && survey->see_through && !survey->opaque_shadows;
    return survey->effects | (colours ? PEN_FX_SHADOW_TRANSMITTANCE : 0u);
}

void pen_effects_find(struct pen_scene *scene)
{
    struct survey survey = {.ambient_light = color_is_lit(scene->ambient),
                            .lights = scene->light_count > 0,
                            .opaque_shadows = !scene->any_see_through,
                            .effects = effect_of_sky(&scene->sky, scene->background)};
    for (uint32_t i = 0; i < scene->light_count; i++)
        survey.shadows |= shadow_kind(scene->lights[i].shadows, scene->lights[i].soft);
    for (uint32_t i = 0; i < pen_prim_slots(&scene->prims); i++) {
        const struct pen_material *m = &scene->materials[scene->prim_material[i]];
        const bool in_solid = scene->solids.count > 0 && scene->solids.of_prim[i] != PEN_NO_SOLID;
        add_material(&survey, m, m->ior != 1 || in_solid);
    }
    for (uint32_t i = 0; i < scene->prims.mesh_count; i++) {
        const struct pen_mesh *mesh = &scene->prims.mesh[i];
        for (uint32_t k = 0; mesh->normal && k < mesh->slots; k++)
            add_normals(&survey, &scene->materials[scene->prim_material[mesh->slot + k]]);
    }
    scene->effects = survey_end(&survey);
    scene->factors = survey_factors(&survey);
}

static void survey_objects(struct survey *survey, const struct pen_scene_desc *desc,
                           const struct pen_object_desc *objects, uint32_t count)
{
    const struct pen_material none = pen_material_default();
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *o = &objects[i];
        const bool mesh = o->kind == PEN_OBJECT_MESH;
        if (o->kind == PEN_OBJECT_GROUP) {
            survey_objects(survey, desc, o->u.group.objects, o->u.group.count);
            continue;
        }
        for (uint32_t k = 0; !o->left_out && k < (mesh ? o->u.mesh->material_count : 1); k++) {
            const int at = mesh ? o->u.mesh->material[k] : o->material;
            const struct pen_material *m = at < 0 ? &none : &desc->materials[at];
            add_material(survey, m, m->ior != 1 || (survey->ones_are_solids && m->ior_written));
            if (mesh && o->u.mesh->normal)
                add_normals(survey, m);
        }
    }
}

/* Whether a used material refracts, so that solids with an index of 1 may lie in its solids. Boxes
 * are not known here, so all solids with index 1 are assumed to. */
static bool ones_are_solids(const struct pen_scene_desc *desc)
{
    struct survey survey = {0};
    bool ones = false;
    for (uint32_t i = 0; i < desc->material_count; i++)
        ones |= desc->materials[i].ior == 1 && desc->materials[i].ior_written;
    if (ones)
        survey_objects(&survey, desc, desc->objects, desc->object_count);
    return survey.effects & PEN_FX_REFRACTION;
}

int pen_camera_samples(bool lens, const struct pen_settings *settings)
{
    const int pixel = settings->samples_per_pixel;
    if (pen_settings_adaptive(settings))
        return settings->max_samples;
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

/* The effects of secondary rays that cannot be traced, because no weight reaches min_contribution.
 * A weight begins with 1 and does not grow, so it is at most its last factor. If paths fork, blur
 * remains, because it determines how large their trees may be. */
static unsigned too_weak(unsigned effects, const struct pen_secondary_factors *factors,
                         double least)
{
    const unsigned rays = (factors->mirror < least ? PEN_FX_MIRROR : 0u) |
                          (factors->transmission < least ? PEN_FX_TRANSMISSION : 0u) |
                          (factors->refraction < least ? PEN_FX_REFRACTION : 0u);
    const unsigned blur = (factors->glossy < least ? PEN_FX_GLOSSY : 0u) |
                          (factors->frosted < least ? PEN_FX_FROSTED : 0u);
    const unsigned both = PEN_FX_MIRROR | PEN_FX_TRANSMISSION, left = effects & ~rays;
    const bool forks = (left & both) == both || (left & PEN_FX_REFRACTION);
    return forks ? rays : rays | blur;
}

static unsigned with_settings(unsigned effects, const struct pen_secondary_factors *factors,
                              bool lens, const struct pen_settings *settings)
{
    effects &= ~too_weak(effects, factors, settings->min_contribution);
    if (settings->max_depth <= 1)
        effects &= ~(unsigned)(PEN_FX_MIRROR | PEN_FX_TRANSMISSION | PEN_FX_REFRACTION |
                               PEN_FX_GLOSSY | PEN_FX_FROSTED);
    if (lens)
        effects |= PEN_FX_DEPTH_OF_FIELD;
    if (pen_camera_samples(lens, settings) > 1)
        effects |= PEN_FX_ANTI_ALIASING;
    return effects;
}

unsigned pen_desc_effects(const struct pen_scene_desc *desc, const struct pen_settings *settings)
{
    struct survey survey = {.ambient_light = color_is_lit(desc->ambient),
                            .opaque_shadows = desc->opaque_shadows};
    if (desc->has_sky)
        survey.effects = effect_of_sky(&desc->sky, desc->background);
    for (uint32_t i = 0; i < desc->light_count; i++) {
        const struct pen_light_desc *light = &desc->lights[i];
        if (!color_is_lit(light->intensity))
            continue;
        survey.lights = true;
        survey.shadows |= shadow_kind(light->shadows, pen_light_desc_soft(light));
    }
    survey.ones_are_solids = ones_are_solids(desc);
    survey_objects(&survey, desc, desc->objects, desc->object_count);
    const struct pen_secondary_factors factors = survey_factors(&survey);
    return with_settings(survey_end(&survey), &factors, pen_desc_has_lens(desc), settings);
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
    return with_settings(scene->effects, &scene->factors, has_lens(&scene->views[view].camera),
                         settings);
}
