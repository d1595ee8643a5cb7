/* SPDX-License-Identifier: MIT */
/* Explanations: the effects that a scene needs, and the reasons. The expected numbers of rays agree
 * with a render, on the built-in scenes and on random ones. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "io/builtin.h"
#include "io/scene_json.h"
#include "study/explain.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

enum { KINDS = 4 };

/* Counts how often an interval contains the number that a render counts, and whether each kind that
 * makes up 5 % of all rays is within 15 % or its interval. */
struct tally {
    int intervals, covered, off;
};

static void judge(struct tally *tally, const struct pen_scene *scene, int view,
                  const struct pen_settings *settings, const char *name)
{
    struct pen_status st;
    struct pen_forecast f;
    struct pen_render_stats stats;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    float *rgb = malloc(3 * (size_t)settings->width * (size_t)settings->height * sizeof *rgb);
    const struct pen_render_task task = {
        .scene = scene, .view = view, .settings = settings, .tile_count = -1, .rgb = rgb};
    const struct pen_forecast_task sparse = {.scene = scene, .view = view, .settings = settings};
    ck_assert(pool && rgb && pen_forecast_make(pool, &sparse, &f, &st));
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    const struct pen_estimate e[KINDS] = {f.shadow, f.reflection, f.transmission, f.total};
    const double got[KINDS] = {(double)stats.rays.shadow, (double)stats.rays.reflection,
                               (double)stats.rays.transmission,
                               (double)(stats.rays.primary + stats.rays.shadow +
                                        stats.rays.reflection + stats.rays.transmission)};
    ck_assert(f.primary.expected == (double)stats.rays.primary);
    ck_assert_str_eq(f.kernel, stats.kernel);
    ck_assert(f.time_ms.low <= f.time_ms.expected && f.time_ms.expected <= f.time_ms.high);
    ck_assert(f.cpu_ms.low <= f.cpu_ms.expected && f.cpu_ms.expected <= f.cpu_ms.high);
    ck_assert(fabs(f.cpu_ms.expected - 2 * f.time_ms.expected) < 1e-9 * f.cpu_ms.expected);
    ck_assert(f.used > 0 && f.used <= 1);
    for (int i = 0; i < KINDS; i++) {
        if (got[i] == 0 && e[i].expected == 0)
            continue;
        const bool covers = e[i].low <= got[i] && got[i] <= e[i].high;
        tally->intervals++;
        tally->covered += covers;
        if (got[i] >= 0.05 * got[KINDS - 1] && !covers &&
            fabs(e[i].expected - got[i]) > 0.15 * got[i]) {
            tally->off++;
            printf("%s, kind %d: expected %g, got %g\n", name, i, e[i].expected, got[i]);
        }
    }
    pen_forecast_release(&f);
    free(rgb);
    pen_thread_pool_free(pool);
}

static void check(const struct tally *tally, const char *what)
{
    printf("%s: %d of %d intervals cover\n", what, tally->covered, tally->intervals);
    ck_assert_int_eq(tally->off, 0);
    ck_assert_int_gt(tally->intervals, 20);
    ck_assert(tally->covered >= 0.9 * tally->intervals);
}

/* The built-in scenes, all views, with 240 x 180 pixels and few samples. */
START_TEST(test_explain__expects_the_rays_of_built_in_scenes)
{
    struct tally tally = {0};
    for (size_t i = 0; i < pen_builtin_count(); i++) {
        struct pen_limits limits = pen_limits_default();
        struct pen_scene_desc desc;
        struct pen_errors errors = {0};
        struct pen_status st;
        struct pen_arena *arena = pen_arena_new(0);
        size_t bytes;
        const char *text = pen_builtin_find(pen_builtin_name(i), &bytes);
        ck_assert(pen_scene_load(text, bytes, &limits, arena, &desc, &errors));
        struct pen_settings *s = &desc.settings;
        s->width = 240;
        s->height = 180;
        s->light_samples = 4;
        s->blur_samples = s->lens_samples = 2;
        struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_AUTO, 0, &st);
        for (uint32_t v = 0; v < desc.view_count; v++)
            judge(&tally, scene, (int)v, s, pen_builtin_name(i));
        pen_scene_free(scene);
        pen_arena_free(arena);
    }
    check(&tally, "built-in scenes");
}
END_TEST

/* Balls of random materials on a floor. */
static void random_scene(struct random *r)
{
    kit_init(&kit);
    kit.settings.width = 200;
    kit.settings.height = 150;
    kit_plane(&kit, pen_vec3(0, -2, 0), pen_vec3(0, 1, 0), kit_material(&kit, kit_matte(0.5)));
    for (int i = 0; i < 12; i++) {
        struct pen_material m = kit_matte(random_unit(r));
        if (random_below(r, 2))
            m.kr = pen_vec3(0.5, 0.5, 0.5);
        if (random_below(r, 2))
            m.kt = pen_vec3(0.6, 0.6, 0.6);
        m.ior = random_below(r, 2) ? 1 : 1.5;
        const struct pen_vec3 at =
            pen_vec3(random_in(r, -5, 5), random_in(r, -2, 4), random_in(r, -6, 4));
        kit_sphere(&kit, at, random_in(r, 0.2, 2), kit_material(&kit, m));
    }
    kit_point(&kit, pen_vec3(random_in(r, -9, 9), 9, 9), pen_vec3(1, 1, 1))->radius =
        random_below(r, 2);
    kit.settings.light_samples = 4;
}

START_TEST(test_explain__expects_the_rays_of_random_scenes)
{
    struct random r = random_begin(640);
    struct tally tally = {0};
    for (int i = 0; i < 50; i++) {
        random_scene(&r);
        struct pen_scene *scene = kit_freeze(&kit);
        judge(&tally, scene, 0, &kit.settings, "random");
        pen_scene_free(scene);
    }
    check(&tally, "random scenes");
}
END_TEST

/* A forecast of the kit's scene. */
static struct pen_forecast forecast_by(int64_t deadline_ns)
{
    struct pen_status st;
    struct pen_forecast f;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    const struct pen_forecast_task task = {
        .scene = scene, .settings = &kit.settings, .deadline_ns = deadline_ns};
    ck_assert(pool && pen_forecast_make(pool, &task, &f, &st));
    ck_assert(f.total.low <= f.total.expected && f.total.expected <= f.total.high);
    ck_assert(f.time_ms.low <= f.time_ms.expected && f.time_ms.expected <= f.time_ms.high);
    ck_assert(f.time_ms.expected > 0);
    pen_forecast_release(&f);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    return f;
}

static bool same(const struct pen_estimate *a, const struct pen_estimate *b)
{
    return a->expected == b->expected && a->low == b->low && a->high == b->high;
}

static double width_of(const struct pen_estimate *e)
{
    return e->high - e->low;
}

START_TEST(test_explain__deadline_that_is_not_reached_changes_nothing)
{
    kit_medley(&kit);
    kit.settings.width = 90;
    kit.settings.height = 70;
    const struct pen_forecast free = forecast_by(0), bound = forecast_by(INT64_MAX);
    ck_assert_int_eq(free.pixels, bound.pixels);
    ck_assert(same(&free.primary, &bound.primary) && same(&free.shadow, &bound.shadow));
    ck_assert(same(&free.reflection, &bound.reflection) && same(&free.total, &bound.total));
}
END_TEST

START_TEST(test_explain__deadline_ends_the_pre_render)
{
    kit_medley(&kit);
    kit.settings.width = 90;
    kit.settings.height = 70;
    const struct pen_forecast all = forecast_by(0), some = forecast_by(pen_clock_ns() - 1);
    ck_assert_int_ge(some.pixels, 1);
    ck_assert_int_lt(some.pixels, all.pixels);
    ck_assert(width_of(&some.total) > width_of(&all.total));
    kit.settings.target_error = 0.001; /* the pre-render's rounds of small pictures also end */
    const struct pen_forecast rounds = forecast_by(pen_clock_ns() - 1);
    ck_assert(rounds.total.high > rounds.total.expected);
}
END_TEST

/* The number of samples is so large that not even one pixel would be finished. */
START_TEST(test_explain__deadline_bounds_the_samples_of_a_pixel)
{
    const int64_t ten_s_ns = INT64_C(10000000000);
    kit_medley(&kit);
    kit.settings.width = kit.settings.height = 10;
    kit.settings.samples_per_pixel = kit.settings.lens_samples = 1000;
    kit.settings.light_samples = 1000000000;
    const struct pen_forecast f = forecast_by(pen_clock_ns() + ten_s_ns);
    ck_assert(fabs(f.primary.expected - 100 * 1000.0) < 1e-6 * 100 * 1000);
    ck_assert(f.primary.low <= 100 * 1000.0 && f.primary.high >= 100 * 1000.0 * (1 - 1e-9));
    ck_assert(f.shadow.high > 100 * 1000 * 1e9 / 10);
}
END_TEST

static json_t *explanation(void)
{
    struct pen_status st;
    struct pen_forecast forecast;
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    const struct pen_forecast_task sparse = {.scene = scene, .settings = &kit.settings};
    ck_assert(pen_forecast_make(pool, &sparse, &forecast, &st));
    const struct pen_explain_task task = {
        .desc = &kit.desc, .settings = &kit.settings, .forecast = &forecast};
    json_t *json = pen_explain_json(&task);
    pen_forecast_release(&forecast);
    ck_assert_ptr_nonnull(json);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    return json;
}

/* The reason why an effect is in a list; NULL if it is not. */
static const char *why(const json_t *json, const char *list, const char *name)
{
    size_t i;
    json_t *item;
    json_array_foreach(json_object_get(json, list), i, item)
    {
        if (strcmp(json_string_value(json_object_get(item, "name")), name) == 0)
            return json_string_value(json_object_get(item, "because"));
    }
    return NULL;
}

/* A small mirror and a small lens in view. In a large picture no pixel of the pre-render hits them,
 * but some pixels of the picture do. */
START_TEST(test_explain__what_is_not_met_is_not_excluded)
{
    struct pen_status st;
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 1000;
    struct pen_material m = kit_matte(0.5);
    m.kr = pen_vec3(0.5, 0.5, 0.5);
    m.kt = pen_vec3(0.4, 0.4, 0.4);
    kit_sphere(&kit, pen_vec3(0.3, 0.2, 0), 0.01, kit_material(&kit, m));
    kit_point(&kit, pen_vec3(0, 9, 9), pen_vec3(1, 1, 1));
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_thread_pool *pool = pen_thread_pool_new(1, &st);
    const struct pen_forecast_task sparse = {.scene = scene, .settings = &kit.settings};
    struct pen_forecast f;
    struct pen_render_stats stats;
    float *rgb = malloc(3 * sizeof *rgb * 1000 * 1000);
    const struct pen_render_task task = {
        .scene = scene, .settings = &kit.settings, .tile_count = -1, .rgb = rgb};
    ck_assert(pen_forecast_make(pool, &sparse, &f, &st));
    ck_assert(pen_render_run(pool, &task, &stats, &st) && stats.rays.reflection > 0);
    const struct pen_estimate *const kinds[] = {&f.shadow, &f.reflection, &f.transmission};
    const uint64_t met[] = {stats.rays.shadow, stats.rays.reflection, stats.rays.transmission};
    for (int i = 0; i < 3; i++) {
        ck_assert(kinds[i]->expected == 0 && kinds[i]->low == 0);
        ck_assert_msg(kinds[i]->high >= (double)met[i] && kinds[i]->high < 0.05 * 1e6, "%d: %g", i,
                      kinds[i]->high);
    }
    ck_assert(f.total.high >= 1e6 + f.reflection.high);
    pen_forecast_release(&f);
    pen_scene_free(scene);
    kit.settings.width = kit.settings.height =
        20; /* all pixels are rendered, so nothing is missed */
    kit.objects[0].u.sphere.center = pen_vec3(0, 0, 1e5);
    scene = kit_freeze(&kit);
    const struct pen_forecast_task all = {.scene = scene, .settings = &kit.settings};
    ck_assert(pen_forecast_make(pool, &all, &f, &st) && f.reflection.high == 0);
    pen_forecast_release(&f);
    free(rgb);
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_explain__says_why)
{
    kit_init(&kit);
    struct pen_material m = kit_matte(0.5);
    m.kr = pen_vec3(0.5, 0, 0);
    const int mirror = kit_material(&kit, m);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, mirror)->name = "ball";
    for (int i = 0; i < 5; i++)
        kit_sphere(&kit, pen_vec3(0, 0, -3 - i), 0.1, mirror); /* behind the ball */
    kit_point(&kit, pen_vec3(0, 9, 9), pen_vec3(1, 1, 1));
    json_t *json = explanation();
    ck_assert_str_eq(why(json, "effects", "mirror"),
                     "objects ball, sphere 1, sphere 2, sphere 3 and 2 more have kr > 0, and 1 of "
                     "their 6 primitives is visible from view main");
    ck_assert_str_eq(why(json, "effects", "hard_shadows"),
                     "1 light without a radius casts shadows");
    ck_assert_str_eq(why(json, "absent", "refraction"),
                     "no object has kt > 0 and an ior other than 1");
    ck_assert_str_eq(why(json, "absent", "anti_aliasing"), "a pixel has 1 camera ray");
    ck_assert_ptr_null(why(json, "absent", "mirror"));
    ck_assert_uint_eq(json_array_size(json_object_get(json, "effects")) +
                          json_array_size(json_object_get(json, "absent")),
                      PEN_FX_COUNT);
    json_decref(json);
    kit.objects[0].material = -1;
    json = explanation();
    ck_assert_str_eq(
        why(json, "effects", "mirror"),
        "objects sphere 1, sphere 2, sphere 3, sphere 4 and 1 more have kr > 0, which no "
        "camera ray of the pre-render meets");
    json_decref(json);
    for (int i = 1; i < 6; i++)
        kit.objects[i].material = -1;
    kit.objects[0].material = mirror;
    json = explanation();
    ck_assert_str_eq(why(json, "effects", "mirror"),
                     "object ball has kr > 0 and is visible from view main");
    json_decref(json);
    kit.materials[mirror].kr.x = 1e-9;
    json = explanation();
    ck_assert_ptr_nonnull(strstr(why(json, "absent", "mirror"), "too little"));
    json_decref(json);
    kit.settings.max_depth = 1;
    json = explanation();
    ck_assert_str_eq(why(json, "absent", "mirror"), "max_depth is 1");
    json_decref(json);
}
END_TEST

PEN_SUITE("explain", test_explain__expects_the_rays_of_built_in_scenes,
          test_explain__expects_the_rays_of_random_scenes,
          test_explain__deadline_that_is_not_reached_changes_nothing,
          test_explain__deadline_ends_the_pre_render,
          test_explain__deadline_bounds_the_samples_of_a_pixel,
          test_explain__what_is_not_met_is_not_excluded, test_explain__says_why)
