/* SPDX-License-Identifier: MIT */
/* Patterns: the colour of a place in an object's own coordinates, under any transform of its
 * groups. Tests choose a place there, which determines the colour, and look at where the group's
 * transform puts it. */
#include <math.h>
#include <string.h>

#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;
static struct pen_patterns patterns;
static struct pen_pattern pattern;

static const vec3 colour_a = {1, 0.5, 0.25}, colour_b = {0.125, 2, 4};

/* A material whose emission is the pattern. */
static int patterned(void)
{
    patterns = (struct pen_patterns){.of = {&pattern}};
    struct pen_material m = kit_glow(0.5, 0.5, 0.5);
    m.patterns = &patterns;
    return kit_material(&kit, m);
}

static struct pen_transform any_similarity(struct random *r, double far)
{
    return pen_transform_make(exp2(random_in(r, -3, 3)), random_direction(r),
                              random_in(r, -180, 180), random_vec(r, far));
}

/* The colour seen at `at` from somewhere on the same side as `from`, at some distance. */
static vec3 look_at(vec3 at, vec3 from)
{
    struct pen_ray_counts rays;
    kit.view.camera.position = from;
    kit.view.camera.direction = pen_sub(at, from);
    kit.view.camera.up = fabs(kit.view.camera.direction.y) > 0.9 * pen_length(pen_sub(at, from))
                             ? pen_vec3(1, 0, 0)
                             : pen_vec3(0, 1, 0);
    return kit_pixel(&kit, 0, 0, &rays);
}

static void assert_near(vec3 got, vec3 want, double off, int i)
{
    ck_assert_msg(pen_length(pen_sub(got, want)) <= off, "case %d: (%g %g %g), want (%g %g %g)", i,
                  got.x, got.y, got.z, want.x, want.y, want.z);
}

static vec3 checker_colour(vec3 own)
{
    const double cell =
        floor(own.x / pattern.size) + floor(own.y / pattern.size) + floor(own.z / pattern.size);
    return fmod(cell, 2) != 0 ? colour_b : colour_a;
}

/* A coordinate in a random cell, not near its boundary. */
static double in_cell(struct random *r)
{
    return pattern.size * (floor(random_in(r, -20, 20)) + random_in(r, 0.01, 0.99));
}

START_TEST(test_patterns__checker_in_moved_groups)
{
    static const double offsets[] = {0, 1e3, 1e6};
    struct random r = random_begin(421);
    for (int i = 0; i < random_cases(3000); i++) {
        kit_init(&kit);
        const struct pen_transform f = any_similarity(&r, offsets[i % 3]);
        pattern = (struct pen_pattern){.checker = true, .a = colour_a, .b = colour_b};
        pattern.size = exp2(random_in(&r, -2, 2));
        const vec3 own = pen_vec3(in_cell(&r), in_cell(&r), in_cell(&r));
        vec3 out = random_direction(&r);
        if (i & 1) { /* a sphere, at the end of a radius */
            const double radius = random_in(&r, 1, 3);
            kit_sphere(&kit, pen_along(own, out, -radius), radius, patterned());
        } else {
            kit_plane(&kit, own, out, patterned());
        }
        kit_group(&kit, 0, &f);
        const vec3 eye = pen_along(own, pen_add(out, random_vec(&r, 0.3)), random_in(&r, 1, 9));
        assert_near(look_at(pen_transform_point(&f, own), pen_transform_point(&f, eye)),
                    checker_colour(own), 0, i);
    }
}
END_TEST

/* Triangles take any map, also one that is no similarity. */
START_TEST(test_patterns__checker_in_sheared_groups)
{
    struct random r = random_begin(422);
    for (int i = 0; i < random_cases(3000); i++) {
        kit_init(&kit);
        struct pen_transform f;
        for (int k = 0; k < 12; k++)
            f.m[k / 4][k % 4] = random_in(&r, -2, 2) + 3 * (k / 4 == k % 4);
        pattern = (struct pen_pattern){.checker = true, .a = colour_a, .b = colour_b};
        pattern.size = exp2(random_in(&r, -2, 2));
        const vec3 own = pen_vec3(in_cell(&r), in_cell(&r), in_cell(&r));
        const vec3 u = random_direction(&r), v = pen_normalize(pen_cross(u, random_direction(&r)));
        const vec3 out = pen_cross(u, v);
        kit_triangle(&kit, pen_along(own, u, 2), pen_along(own, pen_add(u, v), -1.5),
                     pen_along(pen_along(own, v, 2), u, -0.25), patterned());
        kit_group(&kit, 0, &f);
        const vec3 eye = pen_along(own, out, random_in(&r, 1, 9));
        assert_near(look_at(pen_transform_point(&f, own), pen_transform_point(&f, eye)),
                    checker_colour(own), 0, i);
    }
}
END_TEST

/* A face along a boundary of the cells has one colour: that of the upper cells. */
START_TEST(test_patterns__faces_on_boundaries_are_in_the_upper_cell)
{
    static const double offsets[] = {0, 1e3, 1e6};
    struct random r = random_begin(423);
    for (int i = 0; i < random_cases(3000); i++) {
        kit_init(&kit);
        const struct pen_transform f = any_similarity(&r, offsets[i % 3]);
        pattern = (struct pen_pattern){.checker = true, .a = colour_a, .b = colour_b};
        pattern.size = i & 1 ? 0.1 : 0.25; /* one that rounds, and one that does not */
        const double boundary = floor(random_in(&r, -20, 20));
        const vec3 own = pen_vec3(in_cell(&r), boundary * pattern.size, in_cell(&r));
        kit_plane(&kit, own, pen_vec3(0, 1, 0), patterned());
        kit_group(&kit, 0, &f);
        const vec3 eye = pen_vec3(own.x + random_in(&r, -2, 2), own.y + (i & 2 ? 3 : -3),
                                  own.z + random_in(&r, -2, 2));
        const vec3 upper = pen_vec3(own.x, (boundary + 0.5) * pattern.size, own.z);
        assert_near(look_at(pen_transform_point(&f, own), pen_transform_point(&f, eye)),
                    checker_colour(upper), 0, i);
    }
}
END_TEST

START_TEST(test_patterns__gradient)
{
    struct random r = random_begin(424);
    for (int i = 0; i < random_cases(3000); i++) {
        kit_init(&kit);
        const struct pen_transform f = any_similarity(&r, i & 1 ? 100 : 0);
        pattern = (struct pen_pattern){.a = colour_a, .b = colour_b};
        pattern.from = random_vec(&r, 2);
        pattern.to = pen_along(pattern.from, random_direction(&r), random_in(&r, 0.5, 2));
        const vec3 own = random_vec(&r, 3), out = random_direction(&r);
        const vec3 way = pen_sub(pattern.to, pattern.from);
        const double share = pen_dot(pen_sub(own, pattern.from), way) / pen_dot(way, way);
        const double t = fmin(1, fmax(0, share));
        kit_plane(&kit, own, out, patterned());
        kit_group(&kit, 0, &f);
        assert_near(
            look_at(pen_transform_point(&f, own), pen_transform_point(&f, pen_along(own, out, 3))),
            pen_add(pen_scale(colour_a, 1 - t), pen_scale(colour_b, t)), 1e-9, i);
        if (share > 1.001)
            assert_near(look_at(pen_transform_point(&f, own),
                                pen_transform_point(&f, pen_along(own, out, 3))),
                        colour_b, 0, i);
    }
}
END_TEST

/* kt as a pattern: what a ray sees through a pane, and the light that falls through it, hard or
 * soft. kr as a pattern: what a mirror shows. */
START_TEST(test_patterns__panes_and_mirrors)
{
    struct random r = random_begin(425);
    for (int i = 0; i < random_cases(600); i++) {
        const vec3 clear = {1, 0.5, 0.25}, black = {0, 0, 0};
        kit_init(&kit);
        pattern = (struct pen_pattern){.checker = true, .a = clear, .b = black, .size = 1};
        struct pen_material m = kit_glow(0, 0, 0);
        patterns = (struct pen_patterns){0};
        patterns.of[i % 3 == 2 ? PEN_COLOUR_KR : PEN_COLOUR_KT] = &pattern;
        *pen_material_colour(&m, i % 3 == 2 ? PEN_COLOUR_KR : PEN_COLOUR_KT) =
            pen_scale(clear, 0.5);
        m.patterns = &patterns;
        kit_sheet(&kit, 0, 100, kit_material(&kit, m));
        const vec3 at = pen_vec3(in_cell(&r), in_cell(&r), 0);
        const bool odd = fmod(floor(at.x) + floor(at.y), 2) != 0;
        kit.settings.light_samples = 4;
        struct pen_light_desc *light;
        switch (i % 3) {
        case 0: /* seen through the pane */
            kit.desc.background = pen_vec3(1, 2, 3);
            assert_near(look_at(at, pen_vec3(at.x + 1, at.y, 5)),
                        odd ? black : pen_mul(clear, kit.desc.background), 0, i);
            break;
        case 1: /* lit through it: light straight down, seen from under the pane */
            kit_plane(&kit, pen_vec3(0, 0, -1), pen_vec3(0, 0, 1),
                      kit_material(&kit, kit_matte(1)));
            light = kit_directional(&kit, pen_vec3(0, 0, -1), pen_vec3(1, 1, 1));
            light->angular_radius = i & 1 ? 1e-3 : 0;
            assert_near(look_at(pen_vec3(at.x, at.y, -1), pen_vec3(at.x + 0.5, at.y, -0.5)),
                        odd ? black : clear, 1e-9, i);
            break;
        default: /* the background above a mirror */
            kit.desc.background = pen_vec3(1, 2, 3);
            assert_near(look_at(at, pen_vec3(at.x + 1, at.y, 5)),
                        odd ? black : pen_mul(clear, kit.desc.background), 0, i);
        }
    }
}
END_TEST

START_TEST(test_patterns__are_an_effect_where_a_primitive_has_one)
{
    kit_init(&kit);
    pattern = (struct pen_pattern){.checker = true, .a = colour_a, .b = colour_b, .size = 1};
    const int number = patterned();
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), 0);
    kit.objects[0].material = number;
    ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), PEN_FX_PATTERNS);
}
END_TEST

/* One of two equal colours is a plain colour, wherever it is seen from; of two that differ in the
 * last bit of one channel, it is not. */
START_TEST(test_patterns__of_equal_colours_are_plain)
{
    static const vec3 odd = {0x1p-1074 * 3, 0.25, 1}; /* whose half is not exact */
    for (int i = 0; i < 2 * PEN_MATERIAL_COLOURS; i++) {
        kit_init(&kit);
        kit.desc.ambient = pen_vec3(1, 1, 1);
        pattern = (struct pen_pattern){.checker = i & 1, .a = odd, .b = odd, .size = 1};
        pattern.to = pen_vec3(1, 0, 0);
        struct pen_material m = kit_glow(0, 0, 0);
        *pen_material_colour(&m, i / 2) = odd;
        const int plain = kit_material(&kit, m);
        patterns = (struct pen_patterns){0};
        patterns.of[i / 2] = &pattern;
        m.patterns = &patterns;
        *pen_material_colour(&m, i / 2) = pen_vec3(0, 0.25, 1); /* near the mean */
        const int equal = kit_material(&kit, m);
        kit_sphere(&kit, pen_vec3(0, 0, 0), 1, plain);
        const unsigned effects = pen_desc_effects(&kit.desc, &kit.settings);
        kit.objects[0].material = equal;
        ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), effects);
        struct pen_scene *scene = kit_freeze(&kit);
        ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings), effects);
        ck_assert_ptr_null(scene->materials[equal].patterns);
        ck_assert_int_eq(memcmp(&scene->materials[equal], &scene->materials[plain],
                                offsetof(struct pen_material, patterns)),
                         0);
        pen_scene_free(scene);
        pattern.b.y = 0.25 + 0x1p-54;
        ck_assert_uint_eq(pen_desc_effects(&kit.desc, &kit.settings), effects | PEN_FX_PATTERNS);
    }
}
END_TEST

PEN_SUITE("patterns", test_patterns__checker_in_moved_groups,
          test_patterns__checker_in_sheared_groups,
          test_patterns__faces_on_boundaries_are_in_the_upper_cell, test_patterns__gradient,
          test_patterns__panes_and_mirrors, test_patterns__are_an_effect_where_a_primitive_has_one,
          test_patterns__of_equal_colours_are_plain)
