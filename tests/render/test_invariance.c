/* SPDX-License-Identifier: MIT */
/* Pictures that must not change when the scene is transformed: scaled by a power of two (H074),
 * moved by a distance that adds without rounding (H076), mirrored (H078). The numbers are those of
 * the catalogue in tests/property. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/kit.h"
#include "support/suite.h"

static struct kit kit;

static size_t film_floats(void)
{
    return 3 * (size_t)kit.settings.width * (size_t)kit.settings.height;
}

static float *film_of_kit(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, 2);
    pen_scene_free(scene);
    return film;
}

START_TEST(test_invariance__h074_scaled_by_powers_of_two)
{
    static const int exponents[] = {-498, -200, -40, -20, -1, 1, 20, 40, 200, 498};
    kit_medley(&kit);
    float *want = film_of_kit();
    for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
        double s = ldexp(1, exponents[i]);
        kit_medley(&kit);
        kit_map_points(&kit, kit_times, s);
        kit_scale_lengths(&kit, s);
        float *got = film_of_kit();
        ck_assert_msg(memcmp(got, want, film_floats() * sizeof *got) == 0, "2^%d", exponents[i]);
        free(got);
    }
    free(want);
}
END_TEST

START_TEST(test_invariance__h076_moved_by_exact_distances)
{
    static const double distances[] = {0x1p20, -0x1p30, 0x1p30 + 1024, 0x1.8p35};
    kit_medley(&kit);
    float *want = film_of_kit();
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; i++) {
        kit_medley(&kit);
        kit_map_points(&kit, kit_moved, distances[i]);
        float *got = film_of_kit();
        ck_assert_msg(memcmp(got, want, film_floats() * sizeof *got) == 0, "%a", distances[i]);
        free(got);
    }
    free(want);
}
END_TEST

START_TEST(test_invariance__h078_seen_in_a_mirror)
{
    kit_medley(&kit);
    for (uint32_t i = 0; i < kit.desc.light_count;
         i++) /* the sample points on a light's disk are not mirrored */
        kit.lights[i].radius = kit.lights[i].angular_radius = 0;
    kit.settings.width = 120;
    kit.settings.height = 90;
    float *want = film_of_kit();
    kit_map_points(&kit, kit_mirrored, -1);
    kit_mirror_directions(&kit);
    float *got = film_of_kit();
    int different = 0;
    for (int y = 0; y < 90; y++)
        for (int x = 0; x < 120; x++)
            different += memcmp(&got[3 * (y * 120 + x)], &want[3 * (y * 120 + 119 - x)],
                                3 * sizeof *got) != 0;
    ck_assert_int_le(different, 2); /* an edge that a ray meets exactly belongs to one side */
    free(want);
    free(got);
}
END_TEST

PEN_SUITE("invariance", test_invariance__h074_scaled_by_powers_of_two,
          test_invariance__h076_moved_by_exact_distances, test_invariance__h078_seen_in_a_mirror)
