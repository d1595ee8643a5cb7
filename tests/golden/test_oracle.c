/* SPDX-License-Identifier: MIT */
/* Every scene of tests/golden/scenes, and the built-in scenes in small, against the oracle, an
 * independent renderer (tests/support/oracle.h). Pixels may differ in the last digits. Larger
 * differences are allowed only if a ray grazes an edge closer than rounding can decide. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/scene_json.h"
#include "render/render.h"
#include "scene/scene.h"
#include "support/oracle.h"
#include "support/random.h"
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

START_TEST(test_oracle__agrees_on_refraction)
{
    static const char *const views[] = {"front", "inside", "drink"};
    int different = differences("tests/golden/scenes/refraction-touching", NULL, 96);
    different += differences("tests/golden/scenes/bubble", NULL, 96);
    for (int i = 0; i < 3; i++)
        different += differences("tests/golden/scenes/refraction", views[i], 96);
    ck_assert_int_eq(different, 0);
}
END_TEST

/* Writes a material of glass, or of something that is not. */
static void write_material(FILE *out, struct random *r)
{
    static const double ior[] = {1, 1.33, 1.5, 2.4, 0.75};
    fprintf(out, "{\"kd\": %.3f, \"kt\": %.3f, \"kr\": %.3f, \"ior\": %.3f, \"shininess\": %u,",
            random_in(r, 0, 0.4), random_below(r, 4) ? random_in(r, 0.5, 1) : 0,
            random_below(r, 3) ? 0 : random_in(r, 0, 0.3), ior[random_below(r, 5)],
            (unsigned)random_below(r, 1000));
    fprintf(out, " \"emission\": [%.3f, %.3f, 0.05]}", random_in(r, 0, 0.2), random_in(r, 0, 0.2));
}

/* A turned box, as six polygons whose vertices run in any order. */
static void write_box(FILE *out, struct random *r, const char *material)
{
    static const int face[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                   {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    const double half[3] = {random_in(r, 0.2, 1), random_in(r, 0.2, 1), random_in(r, 0.2, 1)};
    fprintf(out,
            "{\"type\": \"group\", \"transform\": {\"rotate\": {\"axis\": [%.3f, 1, %.3f], "
            "\"degrees\": %.3f}, \"translate\": [%.3f, %.3f, %.3f]}, \"objects\": [",
            random_in(r, -1, 1), random_in(r, -1, 1), random_in(r, 0, 180), random_in(r, -2, 2),
            random_in(r, -1.5, 1.5), random_in(r, -2, 2));
    for (int i = 0; i < 6; i++) {
        const bool back = random_below(r, 2);
        fprintf(out, "%s{\"type\": \"polygon\", \"material\": \"%s\", \"vertices\": [",
                i ? ", " : "", material);
        for (int k = 0; k < 4; k++) {
            const int corner = face[i][back ? 3 - k : k];
            fprintf(out, "%s[%.3f, %.3f, %.3f]", k ? ", " : "", corner & 4 ? half[0] : -half[0],
                    corner & 2 ? half[1] : -half[1], corner & 1 ? half[2] : -half[2]);
        }
        fputs("]}", out);
    }
    fputs("]}", out);
}

static void write_object(FILE *out, struct random *r, const char *material)
{
    static const char *const kinds[] = {"sphere", "cylinder", "cone", "box"};
    const char *kind = kinds[random_below(r, 4)];
    if (strcmp(kind, "box") == 0) {
        write_box(out, r, material);
        return;
    }
    fprintf(out,
            "{\"type\": \"%s\", \"material\": \"%s\", \"radius\": %.3f, \"%s\": [%.3f, %.3f, %.3f]",
            kind, material, random_in(r, 0.3, 1.5), strcmp(kind, "sphere") ? "base" : "center",
            random_in(r, -2, 2), random_in(r, -1.5, 1.5), random_in(r, -2, 2));
    if (strcmp(kind, "sphere") != 0)
        fprintf(out, ", \"axis\": [%.3f, 1, %.3f], \"height\": %.3f", random_in(r, -1, 1),
                random_in(r, -1, 1), random_in(r, 0.3, 2));
    fputs("}", out);
}

/* Solids of any kind that overlap and contain one another, and the eye now and then. */
static void write_scene(FILE *out, struct random *r)
{
    const int objects = 1 + (int)random_below(r, 6);
    const double z = random_below(r, 3) ? 7 : random_in(r, -1, 1);
    fprintf(
        out,
        "{\"format\": \"penumbra-scene/1\", \"ambient\": [0.1, 0.1, 0.1], \"background\": "
        "{\"sky\": {\"zenith\": [0.2, 0.4, 0.9], \"horizon\": [0.9, 0.9, 0.8], \"nadir\": [0.3, "
        "0.2, 0.1]}}, \"camera\": {\"position\": [%.3f, %.3f, %.3f], \"direction\": [%.3f, %.3f, "
        "-1]}, \"lights\": [{\"type\": \"directional\", \"intensity\": [0.7, 0.7, 0.6], "
        "\"direction\": [-1, -2, -1.5]}], \"materials\": {",
        random_in(r, -1, 1), random_in(r, -1, 1), z, random_in(r, -0.3, 0.3),
        random_in(r, -0.3, 0.3));
    for (int i = 0; i < objects; i++) {
        fprintf(out, "%s\"m%d\": ", i ? ", " : "", i);
        write_material(out, r);
    }
    fputs("}, \"objects\": [", out);
    for (int i = 0; i < objects; i++) {
        char material[16];
        snprintf(material, sizeof material, "m%d", i);
        fputs(i ? ", " : "", out);
        write_object(out, r, material);
    }
    fprintf(out, "], \"render\": {\"width\": 32, \"height\": 24, \"max_depth\": %u}}\n",
            2 + (unsigned)random_below(r, 6));
}

START_TEST(test_oracle__agrees_on_random_solids)
{
    struct random r = random_begin(780);
    char folder[] = "/tmp/oracle-XXXXXX", name[64], path[80];
    ck_assert_ptr_nonnull(mkdtemp(folder));
    snprintf(name, sizeof name, "%s/scene", folder);
    snprintf(path, sizeof path, "%s.json", name);
    int different = 0;
    for (int i = 0; i < random_cases(60); i++) {
        FILE *out = fopen(path, "w");
        ck_assert_ptr_nonnull(out);
        write_scene(out, &r);
        ck_assert_int_eq(fclose(out), 0);
        different += differences(name, NULL, 32);
    }
    ck_assert(unlink(path) == 0 && rmdir(folder) == 0);
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
          test_oracle__agrees_on_refraction, test_oracle__agrees_on_random_solids,
          test_oracle__agrees_on_the_built_in_scenes)
