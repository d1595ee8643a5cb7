/* SPDX-License-Identifier: MIT */
/* A description and the scene frozen from it need the same effects. */
#include <math.h>

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

/* A pattern, and one of two equal colours, which is none. */
static const struct pen_pattern two = {.checker = true, .b = {1, 0, 0}, .size = 1};
static const struct pen_pattern equal = {.checker = true, .size = 1};
static const struct pen_patterns some_patterns[2] = {{.of = {&two, NULL, &equal}},
                                                     {.of = {&equal}}};

/* Factors below, at and above the min_contribution of any_scene. */
static struct pen_vec3 sometimes_weak(struct random *random)
{
    static const double weak[] = {1e-9, 0.0009, 0.001, 0.002};
    const struct pen_vec3 c = sometimes(random);
    return random_below(random, 2) ? c : pen_scale(c, 2 * weak[random_below(random, 4)]);
}

static struct pen_material any_material(struct random *random)
{
    struct pen_material m = pen_material_default();
    m.ka = sometimes(random);
    m.kd = sometimes(random);
    m.ks = sometimes(random);
    m.kt = sometimes_weak(random);
    m.kr = sometimes_weak(random);
    m.ior = random_below(random, 2) ? 1 : 1.5;
    m.reflection_blur = random_below(random, 2) ? 0 : 5;
    m.transmission_blur = random_below(random, 2) ? 0 : 5;
    m.patterns = random_below(random, 4) ? NULL : &some_patterns[random_below(random, 2)];
    if (m.patterns)
        m.kd = pen_vec3(0, 0, 0);
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
    kit.settings.min_contribution = random_below(random, 2) ? 0 : 0.001;
    uint32_t primitives = random_below(random, 4), lights = random_below(random, 3);
    for (uint32_t i = 0; i < primitives; i++) {
        int material = kit_material(&kit, any_material(random));
        kit_sphere(&kit, pen_vec3(3 * i, 0, 0), 1, random_below(random, 4) ? material : -1);
    }
    if (random_below(random, 2))
        kit_smooth(&kit, pen_vec3(0, 5, 0), kit_material(&kit, any_material(random)));
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

/* The effects of secondary rays that a sphere of the material calls for. */
static unsigned effects_of(struct pen_material m, double min_contribution)
{
    kit_init(&kit);
    kit.settings.min_contribution = min_contribution;
    m.ka = pen_vec3(0, 0, 0);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, kit_material(&kit, m));
    struct pen_scene *scene = kit_freeze(&kit);
    const unsigned effects = pen_scene_effects(scene, 0, &kit.settings);
    ck_assert_uint_eq(effects, pen_desc_effects(&kit.desc, &kit.settings));
    pen_scene_free(scene);
    return effects & ~(unsigned)PEN_FX_PATTERNS;
}

/* One channel that reaches min_contribution is enough, and what is equal to it reaches it. */
START_TEST(test_effects__rays_that_are_never_traced_call_for_nothing)
{
    const double least = pen_settings_default().min_contribution;
    struct pen_material m = pen_material_default();
    ck_assert(least == 0.001);
    m.kr = pen_vec3(0, 1e-9, 0);
    m.reflection_blur = 5;
    ck_assert_uint_eq(effects_of(m, least), 0);
    ck_assert_uint_eq(effects_of(m, 1e-9), PEN_FX_MIRROR | PEN_FX_GLOSSY);
    ck_assert_uint_eq(effects_of(m, 0), PEN_FX_MIRROR | PEN_FX_GLOSSY);
    m.kr = pen_vec3(0, 0, nextafter(least, 0));
    ck_assert_uint_eq(effects_of(m, least), 0);
    m.kr = pen_vec3(0, 0, least);
    ck_assert_uint_eq(effects_of(m, least), PEN_FX_MIRROR | PEN_FX_GLOSSY);
    m = pen_material_default();
    m.kt = pen_vec3(1e-9, 0, 0);
    m.transmission_blur = 5;
    ck_assert_uint_eq(effects_of(m, least), 0);
    ck_assert_uint_eq(effects_of(m, 0), PEN_FX_TRANSMISSION | PEN_FX_FROSTED);
    m.ior = 1.5;
    ck_assert_uint_eq(effects_of(m, least), 0);
    ck_assert_uint_eq(effects_of(m, 0), PEN_FX_TRANSMISSION | PEN_FX_FROSTED | PEN_FX_REFRACTION);
}
END_TEST

/* A written index of 1 calls for nothing where nothing refracts; within glass it does what any
 * index does: it reflects, and blurs what it reflects. */
START_TEST(test_effects__a_written_index_of_one)
{
    struct pen_material one = pen_material_default(), glass = one;
    one.kt = glass.kt = pen_vec3(0.5, 0.5, 0.5);
    one.reflection_blur = 5;
    one.ior_written = glass.ior_written = true;
    glass.ior = 1.5;
    ck_assert_uint_eq(effects_of(one, 0.001), PEN_FX_TRANSMISSION);
    for (int apart = 0; apart <= 1; apart++) {
        kit_init(&kit);
        kit_sphere(&kit, pen_vec3(0, 0, 0), 1, kit_material(&kit, glass));
        kit_sphere(&kit, pen_vec3(3 * apart, 0, 0), 0.5, kit_material(&kit, one));
        struct pen_scene *scene = kit_freeze(&kit);
        const unsigned effects = pen_scene_effects(scene, 0, &kit.settings);
        ck_assert_int_eq((effects & PEN_FX_GLOSSY) != 0, !apart);
        ck_assert_uint_eq(scene->solids.count, apart ? 1 : 2);
        pen_scene_free(scene);
    }
}
END_TEST

/* Fresnel's share of kt adds to kr; and blur remains where paths fork, since it says where their
 * trees are cut. */
START_TEST(test_effects__a_refracting_surface_reflects_kr_and_kt)
{
    struct pen_material m = pen_material_default();
    m.ior = 1.5;
    m.kr = m.kt = pen_vec3(0, 0.0006, 0);
    m.transmission_blur = 5;
    ck_assert_uint_eq(effects_of(m, 0.001), PEN_FX_MIRROR | PEN_FX_REFRACTION | PEN_FX_FROSTED);
    m.ior = 1;
    ck_assert_uint_eq(effects_of(m, 0.001), 0);
    m.kr = pen_vec3(0.0006, 0, 0); /* in another channel */
    m.ior = 1.5;
    ck_assert_uint_eq(effects_of(m, 0.001), 0);
}
END_TEST

/* Of a pattern both colours count, not their mean, and what rounding adds to a gradient. */
START_TEST(test_effects__the_larger_colour_of_a_pattern_counts)
{
    struct pen_pattern pattern = {.checker = true, .b = {0.0015, 0, 0}, .size = 1, .to = {1, 0, 0}};
    const struct pen_patterns patterns = {.of = {[PEN_COLOUR_KR] = &pattern}};
    struct pen_material m = pen_material_default();
    m.patterns = &patterns;
    for (int checker = 0; checker < 2; checker++) {
        pattern.checker = checker;
        m.kr = pen_vec3(0.00075, 0, 0);
        ck_assert_uint_eq(effects_of(m, 0.001), PEN_FX_MIRROR);
        ck_assert_uint_eq(effects_of(m, 0.0015), PEN_FX_MIRROR);
        ck_assert_uint_eq(effects_of(m, 0.0016), 0);
    }
    /* a + (b - a) is above b. */
    pattern.checker = false;
    pattern.a.x = 0x1p-54;
    pattern.b.x = 1 - 0x1p-53;
    for (; pattern.a.x + (pattern.b.x - pattern.a.x) <= pattern.b.x; pattern.a.x *= 1.0625)
        ck_assert(pattern.a.x < 1);
    ck_assert_uint_eq(effects_of(m, pattern.a.x + (pattern.b.x - pattern.a.x)), PEN_FX_MIRROR);
}
END_TEST

/* Weights grow where kr + kt is above 1 in a channel: then a factor below min_contribution may be
 * enough. */
START_TEST(test_effects__weights_that_grow_call_for_all)
{
    struct pen_material m = pen_material_default();
    m.ior = 1.5;
    m.kt = pen_vec3(0, 0, 0.0009);
    m.kr = pen_vec3(0, 0, 0.999);
    ck_assert_uint_eq(effects_of(m, 0.001), PEN_FX_MIRROR | PEN_FX_REFRACTION);
    m.kr = pen_vec3(0, 0, 1);
    ck_assert_uint_eq(effects_of(m, 0.001),
                      PEN_FX_MIRROR | PEN_FX_REFRACTION | PEN_FX_TRANSMISSION);
}
END_TEST

PEN_SUITE("effects", test_effects__are_the_same_before_and_after_freezing,
          test_effects__rays_that_are_never_traced_call_for_nothing,
          test_effects__a_written_index_of_one,
          test_effects__a_refracting_surface_reflects_kr_and_kt,
          test_effects__the_larger_colour_of_a_pattern_counts,
          test_effects__weights_that_grow_call_for_all)
