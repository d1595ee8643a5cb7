/* SPDX-License-Identifier: MIT */
/* Whether doubles resolve a scene: the measures against values computed by hand. A picture without
 * a warning is right. */
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "render/render.h"
#include "scene/precision.h"
#include "support/suite.h"

enum { SIDE = 60, VALUES = 3 * SIDE * SIDE };

static struct pen_scene *scene;
static struct pen_settings settings;

static void read_scene(const char *text, size_t bytes)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    struct pen_errors errors = {0};
    struct pen_status st;
    ck_assert_msg(pen_scene_load(text, bytes, &limits, arena, &desc, &errors), "%s: %s",
                  errors.item[0].at, errors.item[0].msg);
    pen_scene_free(scene);
    scene = pen_scene_freeze(&desc, PEN_ACCEL_NONE, 0, &st);
    ck_assert_msg(scene != NULL, "%s: %s", st.at, st.msg);
    settings = desc.settings;
    pen_arena_free(arena);
}

/* Measures the scene of these objects, seen from `eye` along -z. The view plane is 1 wide, at
 * distance 1, with 100 pixels, so that a pixel's footprint is 0.01 times the distance. */
static bool measure(const char *eye, const char *objects, struct pen_scene_precision *out)
{
    char text[2000];
    snprintf(text, sizeof text,
             "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [%s], \"direction\": "
             "[0, 0, -1], \"up\": [0, 1, 0], \"view_plane\": {\"distance\": 1, \"width\": 1, "
             "\"height\": 2}}, \"objects\": [%s]}",
             eye, objects);
    read_scene(text, strlen(text));
    return pen_scene_precision(scene, 0, 100, 100, out);
}

static void check_near(double found, double wanted)
{
    ck_assert_msg(fabs(found - wanted) <= 1e-12 * wanted, "%.17g, not %.17g", found, wanted);
}

static void check_footprint(const char *eye, const char *object, double wanted)
{
    struct pen_scene_precision p;
    ck_assert(measure(eye, object, &p));
    check_near(p.pixel_footprint, wanted);
}

START_TEST(test_precision__measures_are_those_of_the_scene)
{
    struct pen_scene_precision p;
    ck_assert(
        measure("0, 0, 0", "{\"type\": \"sphere\", \"center\": [0, 0, -10], \"radius\": 1}", &p));
    check_near(p.extent, 2);
    check_near(p.coordinate_max, 11);
    check_near(p.ulp, 0x1p-49); /* 11 is in [2^3, 2^4) */
    check_near(p.pixel_footprint, 9 * 0.01);
    check_near(p.resolution, 0.09 * 0x1p49);
    ck_assert(
        measure("0, 70, 0", "{\"type\": \"sphere\", \"center\": [0, 0, -10], \"radius\": 1}", &p));
    check_near(p.coordinate_max, 70); /* the eye's */
    ck_assert(!measure("0, 0, 0", "", &p));
}
END_TEST

START_TEST(test_precision__the_nearest_primitive_counts)
{
#define FLOOR "{\"type\": \"polygon\", \"vertices\": [[-8,0,8], [8,0,8], [8,0,-8], [-8,0,-8]]}"
#define BALL "{\"type\": \"sphere\", \"center\": [0, 0, -10], \"radius\": 4}"
    check_footprint("0, 0, 0", BALL, 0.06);
    check_footprint("0, 0, -9", BALL, 0.03); /* inside */
    check_footprint("0, 3, 0", FLOOR, 0.03);
    check_footprint("0, 3, 0", FLOOR "," BALL, 0.03);
    check_footprint("0, 0, 0", FLOOR, 0.01 * 16 / 1024); /* seen edge-on: by the floor's size */
    check_footprint("0, 5, 0", "{\"type\": \"plane\", \"point\": [7,0,7], \"normal\": [0,2,0]}",
                    0.05);
    check_footprint("1, 5, 0",
                    "{\"type\": \"tube\", \"origin\": [1,0,7], \"axis\": [0,0,3], \"radius\": 2}",
                    0.03);
    check_footprint("0, 0, 0",
                    "{\"type\": \"triangle\", \"vertices\": [[0,0,-2], [1,0,-2], [0,1,-2]]}", 0.02);
    check_footprint("0, 0, 0",
                    "{\"type\": \"cylinder\", \"base\": [0,-1,-5], \"axis\": [0,1,0], "
                    "\"radius\": 1, \"height\": 2}",
                    0.04);
}
END_TEST

static bool warns(const struct pen_scene_precision *p)
{
    char text[PEN_MSG_BYTES] = "";
    bool found = pen_precision_warning(p, text, sizeof text);
    ck_assert(found == (p->resolution < PEN_PRECISION_ENOUGH) && found == (text[0] != '\0'));
    return found;
}

/* A sphere of radius 1e-6 on one of radius 1e9, where doubles are 1.2e-7 apart, warns. A planet
 * seen from a height of 2 does not, nor a unit sphere seen through a telescope. */
START_TEST(test_precision__h081_h082_h083_scale_is_judged_by_the_pixel)
{
    struct pen_scene_precision p;
    ck_assert(measure("0, 1000000000.000001, 1e-5",
                      "{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1e9}, {\"type\": "
                      "\"sphere\", \"center\": [0, 1000000000.000001, 0], \"radius\": 1e-6}",
                      &p));
    ck_assert(warns(&p));
    ck_assert(measure("0, 6400002, 0",
                      "{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 6.4e6}", &p));
    ck_assert(!warns(&p));
    for (double far = 1e4; far <= 1e8; far *= 100) {
        char text[600];
        snprintf(text, sizeof text,
                 "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, %g], "
                 "\"direction\": [0, 0, -1], \"view_plane\": {\"distance\": %g, \"width\": 3, "
                 "\"height\": 3}}, \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], "
                 "\"radius\": 1}]}",
                 far, far);
        read_scene(text, strlen(text));
        ck_assert(pen_scene_precision(scene, 0, 500, 500, &p));
        ck_assert(!warns(&p));
    }
}
END_TEST

/* Copies text, and adds `offset` to every number after an @. */
static void put_moved(char *out, const char *in, double offset)
{
    for (; *in; in++) {
        char *end;
        if (*in != '@') {
            *out++ = *in;
            continue;
        }
        out += sprintf(out, "%.17g", strtod(in + 1, &end) + offset);
        in = end - 1;
    }
    *out = '\0';
}

static bool warns_thin(const struct pen_scene_precision *p)
{
    char text[PEN_MSG_BYTES] = "";
    bool found = pen_thinness_warning(p, text, sizeof text);
    ck_assert(found == (text[0] != '\0'));
    return found;
}

/* An object behind a sphere, which is not thin; `text` has @0 where its width is. */
static void check_thin(const char *text, double width)
{
    char object[500], objects[1000];
    struct pen_scene_precision p;
    put_moved(object, text, width);
    snprintf(objects, sizeof objects, "%s, %s", BALL, object);
    ck_assert(measure("0, 0, 9", objects, &p));
    ck_assert_uint_eq(p.thin_prim, 1);
    ck_assert_msg(p.thinness >= width * (1 - 1e-5) && p.thinness <= width * (1 + 1e-5),
                  "%g, not %g", p.thinness, width);
    ck_assert_msg(warns_thin(&p) == (width < 0x1p-30), "%g of %s", width, text);
}

/* Primitives of length 1. */
START_TEST(test_precision__h137_what_is_thinner_than_can_be_tested_warns)
{
    static const double width[] = {0x1p-10, 0x1p-29, 0x1p-30, 0x1.ffp-31, 0x1p-31, 0x1p-45};
    struct pen_scene_precision p;
    for (int i = 0; i < 6; i++) {
        check_thin("{\"type\": \"polygon\", \"vertices\": [[0,0,0], [1,0,0], [1,@0,0], [0,@0,0]]}",
                   width[i]);
        check_thin("{\"type\": \"triangle\", \"vertices\": [[0,0,0], [1,0,0], [0.5,0,@0]]}",
                   width[i]);
        check_thin(
            "{\"type\": \"cylinder\", \"base\": [0,0,0], \"axis\": [0,1,0], \"radius\": 0.5, "
            "\"height\": @0}",
            width[i]);
    }
    ck_assert(measure("0, 0, 9", BALL, &p) && p.thinness == 1 && !warns_thin(&p));
}
END_TEST

START_TEST(test_precision__built_in_scenes_do_not_warn)
{
    glob_t found;
    ck_assert_int_eq(glob("scenes/*.json", 0, NULL, &found), 0);
    ck_assert_uint_ge(found.gl_pathc, 4);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        enum { BYTES_MAX = 16 << 20 };
        struct pen_scene_precision p;
        char *text = malloc(BYTES_MAX);
        FILE *file = fopen(found.gl_pathv[i], "rb");
        ck_assert_ptr_nonnull(file);
        read_scene(text, fread(text, 1, BYTES_MAX, file));
        fclose(file);
        free(text);
        for (uint32_t v = 0; v < scene->view_count; v++) {
            ck_assert(pen_scene_precision(scene, (int)v, settings.width, settings.height, &p));
            ck_assert_msg(!warns(&p) && p.resolution > 1e9, "%s: %g", found.gl_pathv[i],
                          p.resolution);
            ck_assert_msg(!warns_thin(&p) && p.thinness > 1e-3, "%s: %g", found.gl_pathv[i],
                          p.thinness);
        }
    }
    globfree(&found);
}
END_TEST

/* A room of size 1 with a sphere and a triangle, moved by `offset` along all three axes. */
static void read_room(double offset)
{
    static const char room[] =
        "{\"format\": \"penumbra-scene/1\", \"ambient\": [0.1, 0.1, 0.1], \"camera\": "
        "{\"position\": [@0.5, @0.5, @1.9], \"direction\": [0, 0, -1], \"up\": [0, 1, 0], "
        "\"fov_degrees\": 40}, \"lights\": [{\"type\": \"point\", \"position\": [@0.5, @0.9, "
        "@0.5], \"intensity\": [0.8, 0.8, 0.8]}], \"materials\": {\"w\": {\"ka\": 0.8, \"kd\": "
        "0.8}, \"r\": {\"ka\": [0.8, 0.1, 0.1], \"kd\": [0.8, 0.1, 0.1]}}, \"objects\": ["
        "{\"type\": \"polygon\", \"material\": \"w\", \"vertices\": "
        "[[@0, @0, @0], [@1, @0, @0], [@1, @0, @1], [@0, @0, @1]]}, "
        "{\"type\": \"polygon\", \"material\": \"w\", \"vertices\": "
        "[[@0, @0, @0], [@0, @1, @0], [@1, @1, @0], [@1, @0, @0]]}, "
        "{\"type\": \"polygon\", \"material\": \"r\", \"vertices\": "
        "[[@0, @0, @0], [@0, @0, @1], [@0, @1, @1], [@0, @1, @0]]}, "
        "{\"type\": \"sphere\", \"material\": \"w\", \"center\": [@0.3, @0.2, @0.4], "
        "\"radius\": 0.2}, "
        "{\"type\": \"triangle\", \"material\": \"r\", \"vertices\": "
        "[[@0.55, @0, @0.3], [@0.9, @0, @0.45], [@0.7, @0.6, @0.35]]}], "
        "\"render\": {\"width\": 60, \"height\": 60, \"samples_per_pixel\": 64}}";
    char text[8000];
    put_moved(text, room, offset);
    read_scene(text, strlen(text));
}

static void render(float *rgb)
{
    struct pen_status st;
    struct pen_render_stats stats;
    struct pen_thread_pool *pool = pen_thread_pool_new(2, &st);
    const struct pen_render_task task = {
        .scene = scene, .settings = &settings, .tile_count = -1, .rgb = rgb};
    ck_assert_int_eq(settings.width * settings.height * 3, VALUES);
    ck_assert_msg(pen_render_run(pool, &task, &stats, &st), "%s", st.msg);
    pen_thread_pool_free(pool);
}

struct difference {
    double most, mean, seen; /* seen: the share of values that differ by more than 4/255 */
};

static struct difference compare(const float *a, const float *b)
{
    struct difference out = {0};
    for (int i = 0; i < VALUES; i++) {
        double d = fabs(fmin(a[i], 1) - fmin(b[i], 1));
        out.most = fmax(out.most, d);
        out.mean += d / VALUES;
        out.seen += d > 4.0 / 255 ? 1.0 / VALUES : 0;
    }
    return out;
}

/* H077: the picture of a room moved far away equals that of the room as long as there is no
 * warning. Where the distance between doubles nears the size of a pixel the picture is wrong, with
 * a warning. */
START_TEST(test_precision__h077_a_picture_is_right_unless_it_warns)
{
    static float want[VALUES], found[VALUES];
    int right = 0, wrong = 0;
    read_room(0);
    render(want);
    for (double offset = 1e9; offset < 2e15; offset *= 10) {
        struct pen_scene_precision p;
        read_room(offset);
        ck_assert(pen_scene_precision(scene, 0, SIDE, SIDE, &p));
        bool warned = warns(&p);
        render(found);
        struct difference d = compare(want, found);
        printf("offset %g: %.3g steps to a pixel%s: off by %.4f, mean %.1e, seen %.4f\n", offset,
               p.resolution, warned ? ", warned" : "", d.most, d.mean, d.seen);
        ck_assert(warned || (d.most <= 4.0 / 255 && d.mean <= 1e-4));
        right += !warned;
        wrong += warned && d.seen > 0.01;
    }
    ck_assert_int_ge(right, 3);
    ck_assert_int_ge(wrong, 2);
}
END_TEST

PEN_SUITE("precision", test_precision__measures_are_those_of_the_scene,
          test_precision__the_nearest_primitive_counts,
          test_precision__h081_h082_h083_scale_is_judged_by_the_pixel,
          test_precision__built_in_scenes_do_not_warn,
          test_precision__h137_what_is_thinner_than_can_be_tested_warns,
          test_precision__h077_a_picture_is_right_unless_it_warns)
