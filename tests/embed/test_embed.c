/* SPDX-License-Identifier: MIT */
/* libpenumbra through its public header: errors with places, callbacks, threads, memory. Only the
 * bound on memory is compared with the memory that the modules below really take. */
#include <fenv.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>

#include "base/arena.h"
#include "base/buf.h"
#include "io/builtin.h"
#include "io/scene_json.h"
#include "penumbra.h"
#include "scene/scene.h"
#include "support/alloc.h"
#include "support/suite.h"

static struct penumbra_error first_error(const struct penumbra_errors *errors)
{
    struct penumbra_error error = {.size = sizeof error};
    ck_assert_int_eq(penumbra_errors_get(errors, 0, &error), 1);
    return error;
}

static struct penumbra_scene *small_scene(const char *name)
{
    struct penumbra_scene *scene = penumbra_scene_builtin(name, NULL);
    ck_assert_ptr_nonnull(scene);
    ck_assert(penumbra_scene_set(scene, "width=64", NULL));
    ck_assert(penumbra_scene_set(scene, "height=48", NULL));
    return scene;
}

static void check_place(const char *text, const char *code, const char *pointer, int line)
{
    struct penumbra_errors *errors = NULL;
    ck_assert_ptr_null(penumbra_scene_load(text, strlen(text), &errors));
    struct penumbra_error error = first_error(errors);
    ck_assert_str_eq(error.code, code);
    ck_assert_str_eq(error.pointer, pointer);
    ck_assert_int_eq(error.line, line);
    ck_assert_ptr_nonnull(strstr(error.text, error.message));
    ck_assert(penumbra_errors_count(errors) >= 1);
    ck_assert_int_eq(penumbra_errors_get(errors, penumbra_errors_count(errors), &error), 0);
    penumbra_errors_free(errors);
    ck_assert_ptr_null(penumbra_scene_load(text, strlen(text), NULL)); /* nobody wants the errors */
}

START_TEST(test_embed__errors_have_their_places)
{
    check_place("{\n\"format\": }", "syntax", "", 2);
    check_place("{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
                " \"look_at\": [0, 0, 0]}, \"objects\": [{\"type\": \"sphere\","
                " \"center\": [0, 0, 0], \"radius\": -1}]}",
                "invalid-scene", "/objects/0/radius", 0);
    check_place("<scene>\n  <nothing/>\n", "syntax", "", 3);
}
END_TEST

START_TEST(test_embed__header_and_library_have_one_version)
{
    int major, minor, patch;
    ck_assert_int_eq(sscanf(penumbra_version(), "%d.%d.%d", &major, &minor, &patch), 3);
    ck_assert_int_eq(PENUMBRA_VERSION_NUMBER, 10000 * major + 100 * minor + patch);
}
END_TEST

START_TEST(test_embed__no_errors_are_an_empty_list)
{
    struct penumbra_error error = {.size = sizeof error};
    ck_assert_uint_eq(penumbra_errors_count(NULL), 0);
    ck_assert_int_eq(penumbra_errors_get(NULL, 0, &error), 0);
    penumbra_errors_free(NULL);
}
END_TEST

START_TEST(test_embed__bad_arguments_are_errors)
{
    struct penumbra_scene *scene = small_scene("spheres");
    struct penumbra_errors *errors = NULL;
    ck_assert_ptr_null(penumbra_scene_builtin("sphere", &errors));
    ck_assert_str_eq(first_error(errors).code, "not-found");
    ck_assert_ptr_nonnull(strstr(first_error(errors).message, "\"spheres\""));
    penumbra_errors_free(errors);
    ck_assert_int_eq(penumbra_scene_set(scene, "widht=3", &errors), 0);
    ck_assert_str_eq(first_error(errors).code, "usage");
    penumbra_errors_free(errors);
    ck_assert_ptr_null(penumbra_render(scene, "nowhere", NULL, &errors));
    ck_assert_str_eq(first_error(errors).code, "not-found");
    penumbra_errors_free(errors);
    static const struct penumbra_render_options wrong[] = {
        {.size = sizeof wrong[0], .threads = -1},
        {.size = sizeof wrong[0], .threads = 1025},
        {.size = 0}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        ck_assert_ptr_null(penumbra_render(scene, NULL, &wrong[i], &errors));
        ck_assert_str_eq(first_error(errors).code, "usage");
        penumbra_errors_free(errors);
    }
    struct penumbra_image *image = penumbra_render(scene, NULL, NULL, NULL);
    size_t bytes;
    ck_assert_ptr_null(penumbra_image_encode(image, "jpeg", &bytes, &errors));
    ck_assert_str_eq(first_error(errors).code, "usage");
    penumbra_errors_free(errors);
    penumbra_image_free(image);
    penumbra_scene_free(scene);
}
END_TEST

/* A structure of a later version: a member behind the ones that this version knows. */
START_TEST(test_embed__structures_of_other_sizes_are_taken)
{
    struct {
        struct penumbra_render_options known;
        uint64_t later;
    } options = {.known = {.size = sizeof options}};
    struct penumbra_scene *scene = small_scene("spheres");
    struct penumbra_image *image = penumbra_render(scene, NULL, &options.known, NULL);
    ck_assert_ptr_nonnull(image);
    penumbra_image_free(image);
    options.later = 1;
    ck_assert_ptr_null(penumbra_render(scene, NULL, &options.known, NULL));
    struct penumbra_estimate estimate = {.size = offsetof(struct penumbra_estimate, rays),
                                         .rays = -1};
    ck_assert(penumbra_scene_estimate(scene, &estimate, NULL));
    ck_assert(estimate.width == 64 && estimate.height == 48 && estimate.rays == -1);
    penumbra_scene_free(scene);
}
END_TEST

/* The bound of a scene, against what it takes with each accelerator. Returns the largest part
 * of the bound that is taken. */
static double check_estimate(const char *text, size_t bytes)
{
    static const enum pen_accelerator kinds[] = {PEN_ACCEL_AUTO, PEN_ACCEL_NONE, PEN_ACCEL_CBR,
                                                 PEN_ACCEL_MANUAL, PEN_ACCEL_MEDIAN};
    struct penumbra_scene *scene = penumbra_scene_load(text, bytes, NULL);
    struct penumbra_estimate estimate = {.size = sizeof estimate};
    ck_assert(scene && penumbra_scene_estimate(scene, &estimate, NULL));
    penumbra_scene_free(scene);
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0};
    struct pen_scene_desc desc;
    struct pen_status st;
    struct pen_arena *arena = pen_arena_new(0);
    double most = 0;
    ck_assert(pen_scene_load(text, bytes, &limits, arena, &desc, &errors));
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        struct pen_scene *frozen = pen_scene_freeze(&desc, kinds[k], 0, &st);
        ck_assert_ptr_nonnull(frozen);
        const size_t taken = pen_arena_used(arena) + pen_arena_used(frozen->arena);
        ck_assert_uint_le(taken, estimate.scene_bytes);
        most = fmax(most, (double)taken / (double)estimate.scene_bytes);
        pen_scene_free(frozen);
    }
    pen_arena_free(arena);
    return most;
}

START_TEST(test_embed__estimates_bound_what_is_rendered)
{
    const char *name;
    for (size_t i = 0; (name = penumbra_builtin_name(i)); i++) {
        size_t bytes;
        const char *text = pen_builtin_find(name, &bytes);
        check_estimate(text, bytes);
    }
}
END_TEST

/* Triangles that share vertices, which take least, and triangles far apart, which fill no blocks:
 * of glass, and turned, so that the mesh gets vertices of its own. */
START_TEST(test_embed__estimates_bound_meshes)
{
    enum { SIDE = 90 };
    struct pen_buf text = {0};
    for (int apart = 0; apart < 2; apart++) {
        pen_buf_release(&text);
        pen_buf_printf(&text,
                       "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0, 0, 9],"
                       " \"look_at\": [0, 0, 0]}, \"objects\": [{\"type\": \"group\", "
                       "\"transform\": {\"rotate\": {\"axis\": [0, 1, 0], \"degrees\": 20}}, "
                       "\"objects\": [{\"type\": \"mesh\", \"material\": {\"kt\": 1, \"ior\": %s}, "
                       "\"positions\": [",
                       apart ? "1.5" : "1");
        for (int i = 0; i < SIDE * SIDE; i++) {
            const int x = i % SIDE, y = i / SIDE;
            if (apart)
                pen_buf_printf(&text, "%s[%d, %d, 0], [%d.1, %d, 0], [%d, %d.1, %d]", i ? "," : "",
                               x * x * x, y * y * y, x * x * x, y * y * y, x * x * x, y * y * y, x);
            else
                pen_buf_printf(&text, "%s[%d, %d, %d]", i ? "," : "", x, y, x * y % 3);
        }
        pen_buf_puts(&text, "], \"faces\": [");
        for (int i = 0; i < SIDE * SIDE - (apart ? 0 : SIDE + 1); i++)
            if (apart)
                pen_buf_printf(&text, "%s[%d, %d, %d]", i ? "," : "", 3 * i, 3 * i + 1, 3 * i + 2);
            else
                pen_buf_printf(&text, "%s[%d, %d, %d], [%d, %d, %d]", i ? "," : "", i, i + 1,
                               i + SIDE, i + 1, i + SIDE + 1, i + SIDE);
        ck_assert(pen_buf_puts(&text, "]}]}]}"));
        const double part = check_estimate((const char *)text.data, text.bytes);
        ck_assert_msg(part > 1. / 6, "%g of the bound are taken", part);
    }
    pen_buf_release(&text);
}
END_TEST

struct watcher {
    int calls, stop_after;
    double last;
};

static void note_progress(void *user, double done)
{
    struct watcher *watcher = user;
    ck_assert(done > watcher->last && done <= 1);
    watcher->last = done;
    watcher->calls++;
}

static int stops(void *user)
{
    const struct watcher *watcher = user;
    return watcher->stop_after > 0 && watcher->calls >= watcher->stop_after;
}

START_TEST(test_embed__progress_grows_to_one_and_cancel_stops)
{
    struct penumbra_scene *scene = small_scene("room");
    ck_assert(penumbra_scene_set(scene, "tile=16", NULL));
    struct watcher watcher = {0};
    struct penumbra_render_options options = {.size = sizeof options,
                                              .threads = 2,
                                              .progress = note_progress,
                                              .cancel = stops,
                                              .user = &watcher};
    struct penumbra_image *image = penumbra_render(scene, NULL, &options, NULL);
    ck_assert_ptr_nonnull(image);
    ck_assert(watcher.last == 1 && watcher.calls == 12);
    penumbra_image_free(image);
    struct penumbra_errors *errors = NULL;
    watcher = (struct watcher){.stop_after = 3};
    ck_assert_ptr_null(penumbra_render(scene, NULL, &options, &errors));
    ck_assert_str_eq(first_error(errors).code, "cancelled");
    ck_assert_int_lt(watcher.calls, 12);
    penumbra_errors_free(errors);
    penumbra_scene_free(scene);
}
END_TEST

static void *render_png(void *user)
{
    struct penumbra_scene *scene = small_scene(user);
    struct penumbra_render_options options = {.size = sizeof options, .threads = 2};
    fesetround(FE_UPWARD);
    struct penumbra_image *image = penumbra_render(scene, NULL, &options, NULL);
    size_t bytes;
    void *png = penumbra_image_encode(image, "png", &bytes, NULL);
    ck_assert_int_eq(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
    struct pen_buf *out = calloc(1, sizeof *out);
    pen_buf_add(out, png, bytes);
    penumbra_free(png);
    penumbra_image_free(image);
    penumbra_scene_free(scene);
    return out;
}

/* What `penumbra render` writes, which goes by the rooms directly. */
static void check_like_program(const char *name, struct pen_buf *got)
{
    const char *program = getenv("PENUMBRA_PROGRAM");
    char command[512], bytes[1 << 16];
    snprintf(command, sizeof command,
             "%s render builtin:%s --format png -o - -q --set width=64 --set height=48",
             program ? program : "build/penumbra", name);
    FILE *pipe = popen(command, "r");
    size_t count = fread(bytes, 1, sizeof bytes, pipe);
    ck_assert_int_eq(pclose(pipe), 0);
    ck_assert_uint_eq(count, got->bytes);
    ck_assert_mem_eq(bytes, got->data, count);
    pen_buf_release(got);
    free(got);
}

START_TEST(test_embed__two_threads_give_the_bytes_of_the_program)
{
    static char room[] = "room", spheres[] = "spheres";
    pthread_t thread[2];
    void *png[2];
    ck_assert_int_eq(pthread_create(&thread[0], NULL, render_png, room), 0);
    ck_assert_int_eq(pthread_create(&thread[1], NULL, render_png, spheres), 0);
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(pthread_join(thread[i], &png[i]), 0);
    check_like_program(room, png[0]);
    check_like_program(spheres, png[1]);
}
END_TEST

/* Everything a program does, once; true if nothing failed. *told: whether errors say so exactly
 * then. Libcheck allocates, so nothing is asserted here. */
static bool work(bool *told)
{
    struct penumbra_errors *errors = NULL;
    struct penumbra_scene *scene = penumbra_scene_builtin("spheres", &errors);
    struct penumbra_render_options options = {.size = sizeof options, .threads = 1};
    bool ok = scene && penumbra_scene_set(scene, "width=8", &errors) &&
              penumbra_scene_set(scene, "height=8", &errors);
    struct penumbra_image *image = ok ? penumbra_render(scene, NULL, &options, &errors) : NULL;
    size_t bytes;
    void *png = image ? penumbra_image_encode(image, "png", &bytes, &errors) : NULL;
    char *settings = png ? penumbra_scene_settings(scene, &errors) : NULL;
    ok = settings != NULL;
    struct penumbra_error error = {.size = sizeof error};
    *told =
        ok ? errors == NULL : errors && penumbra_errors_get(errors, 0, &error) && error.message[0];
    penumbra_free(settings);
    penumbra_free(png);
    penumbra_image_free(image);
    penumbra_scene_free(scene);
    penumbra_errors_free(errors);
    return ok;
}

START_TEST(test_embed__no_allocation_is_taken_for_granted)
{
    bool told;
    alloc_spare_new_threads();
    ck_assert(work(&told)); /* the C library allocates for good at its first use of some parts */
    for (long n = 0;; n++) {
        alloc_fail_after(n);
        bool ok = work(&told);
        bool refused = alloc_succeed();
        ck_assert_msg(told, "allocation %ld", n);
        if (!refused) {
            ck_assert(ok);
            ck_assert_int_gt(n, 40);
            break;
        }
    }
}
END_TEST

PEN_SUITE("embed", test_embed__errors_have_their_places,
          test_embed__header_and_library_have_one_version, test_embed__no_errors_are_an_empty_list,
          test_embed__bad_arguments_are_errors, test_embed__structures_of_other_sizes_are_taken,
          test_embed__estimates_bound_what_is_rendered, test_embed__estimates_bound_meshes,
          test_embed__progress_grows_to_one_and_cancel_stops,
          test_embed__two_threads_give_the_bytes_of_the_program,
          test_embed__no_allocation_is_taken_for_granted)
