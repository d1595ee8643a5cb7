/* SPDX-License-Identifier: MIT */
/* Every scene of tests/golden/scenes, and the built-in ones small, against the oracle: a renderer
 * written apart (tests/support/oracle.h). Pixels may differ in the last digits; whole different
 * pixels are allowed only where a ray grazes an edge closer than rounding can tell. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "render/render.h"
#include "scene/scene.h"
#include "support/oracle.h"
#include "support/suite.h"

struct picture {
    int width, height;
    float *rgb;
};

static char *file_text(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    ck_assert_msg(f != NULL, "cannot open %s", path);
    size_t capacity = 1 << 20;
    char *text = malloc(capacity);
    ck_assert_ptr_nonnull(text);
    *bytes = fread(text, 1, capacity, f);
    ck_assert_uint_lt(*bytes, capacity);
    fclose(f);
    return text;
}

/* Penumbra's picture of a view, of the given width and the scene's aspect ratio, one sample per
 * pixel. */
static struct picture rendered(const char *path, const char *view, int width)
{
    struct pen_status st;
    static struct pen_errors errors;
    struct pen_scene_desc desc;
    struct pen_limits limits = pen_limits_default();
    size_t bytes;
    char *text = file_text(path, &bytes);
    struct pen_arena *arena = pen_arena_new(0);
    memset(&errors, 0, sizeof errors);
    ck_assert_msg(pen_scene_load(text, bytes, &limits, arena, &desc, &errors), "%s: %s: %s", path,
                  errors.item[0].at, errors.item[0].msg);
    struct pen_settings settings = desc.settings;
    settings.height = settings.height * width / settings.width;
    settings.width = width;
    settings.samples_per_pixel = 1;
    settings.light_samples = 1024; /* of soft lights, because the oracle takes other points */
    settings.light_pattern = PEN_PATTERN_SOBOL;
    struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_AUTO, 0, &st);
    ck_assert_msg(scene != NULL, "%s: %s", path, st.msg);
    struct picture p = {width, settings.height, NULL};
    p.rgb = calloc((size_t)p.width * (size_t)p.height * 3, sizeof *p.rgb);
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    ck_assert(p.rgb && pool);
    struct pen_render_task task = {.scene = scene, .settings = &settings, .tile_count = -1};
    struct pen_render_stats stats;
    task.view = pen_scene_find_view(scene, view);
    task.rgb = p.rgb;
    ck_assert_int_ge(task.view, 0);
    ck_assert(pen_render_run(pool, &task, &stats, &st));
    pen_thread_pool_free(pool);
    pen_scene_free(scene);
    pen_arena_free(arena);
    free(text);
    return p;
}

/* Relative where colours are bright. Mirrors that face each other multiply rounding, hence not
 * nearer to the last digit of a float. */
static bool alike(const float *ours, const double *theirs)
{
    for (int c = 0; c < 3; c++) {
        double size = theirs[c] > 1 ? theirs[c] : 1;
        if (!(ours[c] - theirs[c] < 2e-6 * size && theirs[c] - ours[c] < 2e-6 * size))
            return false;
    }
    return true;
}

/* How many pixels differ; the first few are printed. */
static int differences(const char *name, const char *view, int width)
{
    char path[256];
    snprintf(path, sizeof path, "%s.json", name);
    struct picture p = rendered(path, view ? view : "main", width);
    struct oracle_scene *oracle = oracle_load(path, view);
    ck_assert_msg(oracle != NULL, "the oracle cannot read %s", path);
    int different = 0;
    for (int i = 0; i < p.width * p.height; i++) {
        int x = i % p.width, y = i / p.width;
        const float *ours = p.rgb + 3 * (size_t)i;
        double theirs[3];
        oracle_pixel(oracle, p.width, p.height, x, y, theirs);
        if (!alike(ours, theirs) && ++different <= 8)
            printf("%s %dx%d pixel %d,%d: %.9g %.9g %.9g, oracle %.9g %.9g %.9g\n", path, p.width,
                   p.height, x, y, (double)ours[0], (double)ours[1], (double)ours[2], theirs[0],
                   theirs[1], theirs[2]);
    }
    if (different)
        printf("%s: %d of %d pixels differ\n", path, different, p.width * p.height);
    oracle_free(oracle);
    free(p.rgb);
    return different;
}

START_TEST(test_oracle__agrees_on_primitives)
{
    static const char *const names[] = {
        "primitives", "transforms", "polygons-concave", "crowd", "infinite", "far-from-origin",
        "empty",      "cones",      "inside-cone",      "sky"};
    int different = 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char name[128];
        snprintf(name, sizeof name, "tests/golden/scenes/%s", names[i]);
        different += differences(name, NULL, 128);
    }
    ck_assert_int_eq(different, 0);
}
END_TEST

/* Where two sheets overlap in one plane, rounding decides which of them a ray meets first;
 * elsewhere, and where primitives are equal, it decides nothing. */
START_TEST(test_oracle__agrees_on_ties_except_in_overlapping_sheets)
{
    int different = differences("tests/golden/scenes/ties", NULL, 128);
    ck_assert_int_lt(different, 128 * 64 / 50);
}
END_TEST

START_TEST(test_oracle__agrees_on_light)
{
    static const char *const names[] = {
        "light-directional", "light-point",     "light-spot",      "glass-stacked",
        "inside-sphere",     "inside-cylinder", "mirrors-facing",  "max-depth",
        "shadowless",        "samples",         "emission-linear",
    };
    int different = 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char name[128];
        snprintf(name, sizeof name, "tests/golden/scenes/%s", names[i]);
        different += differences(name, NULL, 128);
    }
    ck_assert_int_eq(different, 0);
}
END_TEST

START_TEST(test_oracle__agrees_on_every_view)
{
    int different = differences("tests/golden/scenes/views", "front", 128);
    different += differences("tests/golden/scenes/views", "orbit", 128);
    different += differences("tests/golden/scenes/views", "above", 128);
    ck_assert_int_eq(different, 0);
}
END_TEST

START_TEST(test_oracle__agrees_on_the_built_in_scenes)
{
    int different = differences("scenes/spheres", NULL, 160);
    static const char *const forest[] = {"front", "left", "right", "tilted"};
    for (int i = 0; i < 4; i++)
        different += differences("scenes/forest", forest[i], 60);
    different += differences("scenes/room", NULL, 50);
    different += differences("scenes/teapot", NULL, 40);
    ck_assert_int_eq(different, 0);
}
END_TEST

/* Soft shadows are means over different points of the disk: each pixel is within their errors, and
 * those have no bias. */
static void compare_soft(const char *name, int width)
{
    char path[256];
    snprintf(path, sizeof path, "tests/golden/scenes/%s.json", name);
    struct picture p = rendered(path, "main", width);
    struct oracle_scene *oracle = oracle_load(path, NULL);
    ck_assert_msg(oracle != NULL, "the oracle cannot read %s", path);
    double worst = 0, sum = 0, brightness = 0;
    for (int i = 0; i < p.width * p.height; i++) {
        double theirs[3];
        oracle_pixel(oracle, p.width, p.height, i % p.width, i / p.width, theirs);
        for (int c = 0; c < 3; c++) {
            double off = p.rgb[3 * i + c] - theirs[c];
            worst = fmax(worst, fabs(off));
            sum += off;
            brightness += theirs[c];
        }
    }
    double values = 3. * p.width * p.height;
    printf("%s: largest difference %.5f, mean %.2g of %.3f\n", name, worst, sum / values,
           brightness / values);
    ck_assert_msg(worst < 0.01, "%s: %g", name, worst);
    ck_assert_msg(fabs(sum / values) < 1.5e-4, "%s: mean %g", name, sum / values);
    oracle_free(oracle);
    free(p.rgb);
}

START_TEST(test_oracle__agrees_on_soft_shadows)
{
    compare_soft("soft-point", 48);
    compare_soft("soft-spot-grid", 48);
    compare_soft("soft-directional", 48);
    compare_soft("soft-horizon", 48);
    compare_soft("soft-cones", 48);
}
END_TEST

PEN_SUITE("oracle", test_oracle__agrees_on_primitives,
          test_oracle__agrees_on_ties_except_in_overlapping_sheets, test_oracle__agrees_on_light,
          test_oracle__agrees_on_soft_shadows, test_oracle__agrees_on_every_view,
          test_oracle__agrees_on_the_built_in_scenes)
