/* SPDX-License-Identifier: MIT */
/* Blocks of pixels that are rendered together have the films and ray counts of pixels rendered one
 * by one, bit for bit. */
#include <stdlib.h>
#include <string.h>

#include "support/isa.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

static size_t film_bytes(void)
{
    return 3 * (size_t)kit.settings.width * (size_t)kit.settings.height * sizeof(float);
}

static struct pen_ray_counts render(struct pen_thread_pool *pool, const struct pen_scene *scene,
                                    bool pixel_by_pixel, float *film)
{
    struct pen_status st;
    struct pen_render_stats stats;
    const struct pen_render_task task = {.scene = scene,
                                         .settings = &kit.settings,
                                         .tile_count = -1,
                                         .rgb = film,
                                         .pixel_by_pixel = pixel_by_pixel};
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    return stats.rays;
}

static void compare_counts(const struct pen_ray_counts *a, const struct pen_ray_counts *b,
                           const char *what)
{
    ck_assert_msg(a->primary == b->primary && a->shadow == b->shadow &&
                      a->reflection == b->reflection && a->transmission == b->transmission &&
                      a->dropped_samples == b->dropped_samples &&
                      a->truncated_paths == b->truncated_paths,
                  "%s: numbers of rays", what);
}

/* Renders the kit's scene as a whole, with each instruction set, and pixel by pixel. */
static void compare(const char *what)
{
    struct pen_status st;
    struct pen_scene *scene = kit_freeze(&kit);
    const struct pen_settings *settings = &kit.settings;
    float *film = malloc(film_bytes()), *singly = malloc(film_bytes());
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    ck_assert(film && singly && pool);
    const struct pen_ray_counts rays_singly = render(pool, scene, true, singly);
    for (int isa = 0; isa < isa_count(); isa++) {
        isa_force(isa);
        const struct pen_ray_counts rays = render(pool, scene, false, film);
        ck_assert_msg(memcmp(film, singly, film_bytes()) == 0, "%s: pixel by pixel, %s", what,
                      pen_isa_name((enum pen_isa)isa));
        compare_counts(&rays, &rays_singly, what);
    }
    isa_release();
    struct pen_ray_counts sum = {.primary = 0};
    for (int y = 0; y < settings->height; y++) {
        for (int x = 0; x < settings->width; x++) {
            const float *got = &film[3 * ((size_t)y * (size_t)settings->width + (size_t)x)];
            struct pen_ray_counts rays;
            double rgb[3];
            ck_assert(pen_render_pixel(scene, 0, settings, x, y, rgb, &rays, &st));
            pen_ray_counts_add(&sum, &rays);
            for (int c = 0; c < 3; c++)
                ck_assert_msg(got[c] == (float)rgb[c], "%s: pixel (%d, %d): %a, alone %a", what, x,
                              y, (double)got[c], rgb[c]);
        }
    }
    compare_counts(&sum, &rays_singly, what);
    pen_thread_pool_free(pool);
    free(film);
    free(singly);
    pen_scene_free(scene);
}

START_TEST(test_block__sizes_samples_and_accelerators)
{
    static const int size[][2] = {{1, 1}, {8, 8}, {7, 9}, {41, 23}, {16, 3}};
    for (int i = 0; i < 5; i++) {
        for (int accelerator = 0; accelerator < PEN_ACCEL_COUNT; accelerator++) {
            kit_medley(&kit);
            kit.settings.width = size[i][0];
            kit.settings.height = size[i][1];
            kit.settings.tile = 8 + 5 * i;
            kit.settings.samples_per_pixel = i & 1 ? 3 : 1;
            kit.settings.accelerator = accelerator;
            compare("medley");
        }
    }
}
END_TEST

/* Balls that reflect and transmit fork at each surface: trees larger than a block has room for. */
START_TEST(test_block__trees_without_room)
{
    static const int depth[] = {4, 8, 28, 28}, side[] = {9, 9, 9, 3};
    for (int i = 0; i < 4; i++) {
        kit_init(&kit);
        struct pen_material both = kit_matte(.1);
        both.kr = both.kt = pen_vec3(1, .9, 1);
        const int material = kit_material(&kit, both);
        for (int k = 0; k < 3; k++)
            kit_sphere(&kit, pen_vec3(k - 1, k & 1, -k), .9, material);
        kit_point(&kit, pen_vec3(3, 4, 5), pen_vec3(1, 1, 1));
        kit.settings.width = kit.settings.height = side[i];
        kit.settings.max_depth = depth[i];
        kit.settings.min_contribution = 0;
        compare("three balls");
    }
}
END_TEST

/* Sheets that coincide are met in document order, which a block leaves to the pixel kernel. */
START_TEST(test_block__coincident_sheets)
{
    kit_init(&kit);
    struct pen_material glass = kit_matte(.3);
    glass.kt = pen_vec3(.7, .8, .9);
    kit_sheet(&kit, 0, 1, kit_material(&kit, glass));
    kit_sheet(&kit, 0, 2, kit_material(&kit, kit_matte(.5)));
    kit_sheet(&kit, 0, .5, kit_material(&kit, kit_glow(.2, .1, 0)));
    kit_sphere(&kit, pen_vec3(0, 0, 2), .5, kit_material(&kit, glass));
    kit_point(&kit, pen_vec3(3, 4, 5), pen_vec3(1, 1, 1));
    kit_directional(&kit, pen_vec3(-1, 0, -1), pen_vec3(.5, .5, .5));
    kit.settings.width = kit.settings.height = 33;
    compare("sheets");
}
END_TEST

/* Light that a film cannot hold: samples are left out and counted. */
START_TEST(test_block__samples_that_do_not_fit)
{
    kit_init(&kit);
    kit_sphere(&kit, pen_vec3(-1, 0, 0), 1, kit_material(&kit, kit_glow(1e300, 1, 1)));
    kit_sphere(&kit, pen_vec3(1, 0, 0), 1, kit_material(&kit, kit_matte(1)));
    kit_point(&kit, pen_vec3(0, 0, 5), pen_vec3(1e39, 1, 1));
    kit_directional(&kit, pen_vec3(0, 0, -1), pen_vec3(.5, .5, .5));
    kit.settings.width = kit.settings.height = 20;
    kit.settings.samples_per_pixel = 4;
    compare("too bright");
}
END_TEST

/* Random scenes of all kinds, on a lattice so that things touch and coincide, and off it. */
START_TEST(test_block__random_scenes)
{
    struct random r = random_begin(304);
    for (int i = 0; i < random_cases(100); i++) {
        kit_init(&kit);
        const double snap = i & 1 ? 4 : 0x1p40;
        int material[4];
        for (int k = 0; k < 4; k++) {
            struct pen_material m = kit_matte(random_unit(&r));
            m.ks = pen_vec3(k & 1, .5, 0);
            m.shininess = random_in(&r, 0, 50);
            m.kr = random_below(&r, 2) ? random_vec(&r, 0) : pen_vec3(.5, .4, .3);
            m.kt = random_below(&r, 2) ? random_vec(&r, 0) : pen_vec3(.3, .4, .5);
            material[k] = kit_material(&kit, m);
        }
        for (int k = 0; k < 24; k++) {
            struct pen_vec3 a = random_vec(&r, 2), b = random_vec(&r, 2);
            a = pen_vec3(round(a.x * snap) / snap, round(a.y * snap) / snap,
                         round(a.z * snap) / snap);
            const int m = material[random_below(&r, 4)];
            const double size = random_below(&r, 3) ? .25 : .5;
            switch (random_below(&r, 6)) {
            case 0:
                kit_sphere(&kit, a, size, m);
                break;
            case 1:
                kit_cylinder(&kit, a, i & 1 ? pen_vec3(0, 1, 0) : b, size, 2 * size, m);
                break;
            case 2:
                kit_tube(&kit, a, i & 1 ? pen_vec3(1, 0, 0) : b, .125 * size, m);
                break;
            case 3:
                kit_triangle(&kit, a, pen_add(a, pen_vec3(size, 0, 0)),
                             pen_add(a, pen_vec3(0, size, i & 1 ? 0 : size)), m);
                break;
            case 4:
                kit_sheet(&kit, a.z, size, m);
                break;
            default:
                kit_plane(&kit, pen_vec3(0, -2, 0), i & 1 ? pen_vec3(0, 1, 0) : b, m);
            }
        }
        kit_point(&kit, random_vec(&r, 5), pen_vec3(1, 1, 1));
        kit_directional(&kit, random_direction(&r), pen_vec3(.5, .5, .5));
        if (i % 5 == 0)
            kit_point(&kit, random_vec(&r, 5), pen_vec3(1, 1, 1))->radius = .5;
        kit.settings.width = 24;
        kit.settings.height = 17;
        kit.settings.max_depth = 1 + (int)random_below(&r, 8);
        compare("random");
    }
}
END_TEST

PEN_SUITE("block", test_block__sizes_samples_and_accelerators, test_block__trees_without_room,
          test_block__coincident_sheets, test_block__samples_that_do_not_fit,
          test_block__random_scenes)
