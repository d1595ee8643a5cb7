/* SPDX-License-Identifier: MIT */
/* Bright things that may be seen in surfaces at places that are not computed: through refraction or
 * frosted glass, in cones, and in mirrors that mirrors show. Also highlights of cones. Samples of
 * beams that meet such a surface look for nothing. The light that they may have missed counts while
 * they agree. */
#include "render/internal/beam_bounds.h"

/* The light that surfaces may show. */
struct hidden {
    struct pen_vec3 light; /* of the brightest thing, in each channel */
    uint32_t mirrors;
};

static struct pen_vec3 larger(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_vec3(pen_larger(a.x, b.x), pen_larger(a.y, b.y), pen_larger(a.z, b.z));
}

static struct hidden hidden_in(const struct pen_kernel_input *input)
{
    const struct pen_scene *scene = input->scene;
    struct hidden hidden = {.mirrors = 0};
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        const struct pen_material *m = pen_scene_material(scene, i);
        hidden.mirrors += pen_beam_largest(m->kr) > input->settings->min_contribution;
        if (!pen_prim_infinite(pen_prim_kind(&scene->prims, i)) && pen_beam_bright(scene, i))
            hidden.light = larger(hidden.light, pen_beam_light(scene, i));
    }
    return hidden;
}

/* The part of the light that a primitive may show at places that are not computed. */
static struct pen_vec3 shown_by(const struct pen_kernel_input *input, uint32_t prim,
                                const struct hidden *hidden)
{
    const struct pen_scene *scene = input->scene;
    const uint32_t material = pen_scene_material_of(scene, prim);
    const struct pen_material *m = &scene->materials[material];
    const double least = input->settings->min_contribution;
    struct pen_vec3 sum = {0, 0, 0};
    if (pen_beam_largest(m->kt) > least && (m->ior != 1 || scene->blurs[material].transmission > 0))
        sum = pen_add(sum, m->kt);
    if (pen_beam_largest(m->kr) > least && (pen_prim_kind(&scene->prims, prim) == PEN_PRIM_CONE ||
                                            hidden->mirrors > 1 || pen_beam_largest(sum) > 0))
        sum = pen_add(sum, m->kr);
    return m->patterns ? pen_scale(sum, 2) : sum;
}

/* The highlights of a cone. */
static struct pen_vec3 highlights_of(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_material *m = pen_scene_material(scene, prim);
    const struct pen_box box = pen_prim_bounds(&scene->prims, prim);
    struct pen_vec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < scene->light_count; i++)
        sum = pen_add(sum, pen_mul(m->ks, pen_beam_light_within(&scene->lights[i], box)));
    return m->shininess >= PEN_BEAM_NARROW ? sum : pen_vec3(0, 0, 0);
}

/* Adds a surface that may be anywhere in the picture. */
static void add_everywhere(struct pen_beams *beams, const struct bounds *b)
{
    const size_t pixels = (size_t)beams->width * (size_t)beams->height;
    for (size_t i = 0; i < pixels; i++)
        pen_beam_add_depth(&beams->met[i], b);
    beams->any = true;
}

bool pen_beam_add_depths(struct pen_beams *beams, const struct pen_kernel_input *input)
{
    const struct pen_scene *scene = input->scene;
    const struct hidden hidden = hidden_in(input);
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        struct pen_vec3 light = {0, 0, 0};
        if (pen_beam_largest(hidden.light) > 0)
            light = pen_mul(shown_by(input, i, &hidden), hidden.light);
        if (pen_prim_kind(&scene->prims, i) == PEN_PRIM_CONE)
            light = pen_add(light, highlights_of(scene, i));
        struct thing thing = {
            .bounds = {.light = {(float)light.x, (float)light.y, (float)light.z}, .deep = true}};
        if (!(pen_beam_largest(light) > 0))
            continue;
        if (pen_prim_infinite(pen_prim_kind(&scene->prims, i)) ||
            !pen_project(input, i, &thing.hull, &thing.shear))
            add_everywhere(beams, &thing.bounds);
        else if (thing.hull.count >= 3 && !pen_beam_add_thing(beams, &thing))
            return false;
    }
    return true;
}
