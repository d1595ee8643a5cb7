/* SPDX-License-Identifier: MIT */
/* A description and the scene frozen from it need the same effects. */
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

/* A property that is often zero, in all channels or in two. */
static struct pen_vec3 sometimes(struct random *random)
{
    double value = random_below(random, 3) ? 0 : 0.5;
    return pen_vec3(random_below(random, 2) ? value : 0, value, 0);
}

/* A material with patterns, whichever colours they are of. */
static const struct pen_patterns no_colour;

static struct pen_material any_material(struct random *random)
{
    struct pen_material m = pen_material_default();
    m.ka = sometimes(random);
    m.kd = sometimes(random);
    m.ks = sometimes(random);
    m.kt = sometimes(random);
    m.kr = sometimes(random);
    m.patterns = random_below(random, 4) ? NULL : &no_colour;
    return m;
}

static void any_scene(struct random *random)
{
    kit_init(&kit);
    kit.desc.ambient = sometimes(random);
    kit.desc.background = sometimes(random);
    kit.desc.has_sky = random_below(random, 2);
    kit.desc.sky = (struct pen_sky){sometimes(random), sometimes(random), {0, 2, 0}};
    kit.settings.samples_per_pixel = 1 + (int)random_below(random, 2);
    kit.settings.lens_samples = 1 + (int)random_below(random, 2);
    kit.view.camera.aperture_radius = 0.5 * random_below(random, 2);
    kit.view.camera.focus_distance = 3;
    kit.settings.max_depth = 1 + (int)random_below(random, 2);
    uint32_t primitives = random_below(random, 4), lights = random_below(random, 3);
    for (uint32_t i = 0; i < primitives; i++) {
        int material = kit_material(&kit, any_material(random));
        kit_sphere(&kit, pen_vec3(3 * i, 0, 0), 1, random_below(random, 4) ? material : -1);
    }
    /* A material that no primitive has must not count. */
    kit_material(&kit, any_material(random));
    struct pen_transform identity = pen_transform_identity();
    if (primitives > 1 && random_below(random, 2))
        kit_group(&kit, 1, &identity);
    for (uint32_t i = 0; i < lights; i++) {
        struct pen_light_desc *light = kit_point(&kit, pen_vec3(0, 9, 0), sometimes(random));
        light->kind = random_below(random, 2) ? PEN_LIGHT_POINT : PEN_LIGHT_DIRECTIONAL;
        light->direction = pen_vec3(0, -1, 0);
        light->shadows = random_below(random, 2);
        light->radius = random_below(random, 2) * 0.5; /* which only one kind of light has */
        light->angular_radius = random_below(random, 2) * 0.5;
    }
}

START_TEST(test_effects__are_the_same_before_and_after_freezing)
{
    struct random random = random_begin(20);
    unsigned seen = 0;
    for (int i = 0; i < 3000; i++) {
        uint64_t seed = random.state;
        any_scene(&random);
        struct pen_scene *scene = kit_freeze(&kit);
        unsigned before = pen_desc_effects(&kit.desc, &kit.settings);
        unsigned after = pen_scene_effects(scene, 0, &kit.settings);
        ck_assert_msg(before == after, "seed %llu: %x before, %x after", (unsigned long long)seed,
                      before, after);
        seen |= after;
        pen_scene_free(scene);
    }
    ck_assert_uint_eq(seen, (1u << PEN_FX_COUNT) - 1);
}
END_TEST

PEN_SUITE("effects", test_effects__are_the_same_before_and_after_freezing)
