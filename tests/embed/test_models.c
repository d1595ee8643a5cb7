/* SPDX-License-Identifier: MIT */
/* Models in libpenumbra: the program gives the bytes, and the pictures are those of the command
 * line. */
#include <fenv.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "penumbra.h"
#include "support/alloc.h"
#include "support/suite.h"

static const char obj[] = "mtllib sub/red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\n"
                          "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
static const char mtl[] = "newmtl red\nKd 0.8 0.1 0.1\n";
static const char scene[] =
    "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [3, 2, 4],"
    " \"look_at\": [0, 0, 0]}, \"ambient\": [1, 1, 1],"
    " \"objects\": [{\"type\": \"mesh\", \"file\": \"%s\"}]}";

/* The files of a program, in memory. */
struct shelf {
    int asked;
    char names[128];
};

static int give(void *user, const char *name, struct penumbra_file *file)
{
    struct shelf *shelf = user;
    shelf->asked++;
    snprintf(shelf->names + strlen(shelf->names), sizeof shelf->names - strlen(shelf->names), "%s;",
             name);
    if (fegetround() != FE_UPWARD)
        return 0;
    if (strstr(name, ".mtl"))
        return penumbra_file_append(file, mtl, sizeof mtl - 1);
    const char *slash = strrchr(name, '/');
    if (strcmp(slash ? slash + 1 : name, "model.obj") != 0)
        return 0;
    return penumbra_file_append(file, obj, 20) && /* in two parts */
           penumbra_file_append(file, obj + 20, sizeof obj - 21);
}

static struct shelf shelf;
static struct penumbra_models models = {.size = sizeof models, .read = give, .user = &shelf};

static struct penumbra_scene *load(const char *file, struct penumbra_errors **errors)
{
    char text[512];
    snprintf(text, sizeof text, scene, file);
    return penumbra_scene_read(text, strlen(text), &models, errors);
}

static void setup(void)
{
    shelf = (struct shelf){0};
    models = (struct penumbra_models){.size = sizeof models, .read = give, .user = &shelf};
    fesetround(FE_UPWARD); /* the program's own, also in its callback */
}

static void teardown(void)
{
    ck_assert_int_eq(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
}

/* The bytes of a PNG of a scene, which is freed. */
static size_t png_of(struct penumbra_scene *from, char *out, size_t room)
{
    struct penumbra_errors *errors = NULL;
    size_t bytes = 0;
    ck_assert_ptr_nonnull(from);
    ck_assert(penumbra_scene_set(from, "width=40", NULL));
    ck_assert(penumbra_scene_set(from, "height=30", NULL));
    struct penumbra_image *image = penumbra_render(from, NULL, NULL, &errors);
    ck_assert_ptr_nonnull(image);
    void *png = penumbra_image_encode(image, "png", &bytes, &errors);
    ck_assert(png && bytes < room);
    memcpy(out, png, bytes);
    penumbra_free(png);
    penumbra_image_free(image);
    penumbra_scene_free(from);
    return bytes;
}

static void write_file(const char *folder, const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    ck_assert(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

/* `penumbra render` reads the same files from a folder. */
static void check_like_program(const char *folder, const char *name, const char *png, size_t bytes)
{
    const char *program = getenv("PENUMBRA_PROGRAM");
    char command[512], wanted[1 << 14];
    snprintf(command, sizeof command,
             "%s render %s/%s --format png -o - -q --set width=40 --set height=30",
             program ? program : "build/penumbra", folder, name);
    FILE *pipe = popen(command, "r");
    const size_t count = fread(wanted, 1, sizeof wanted, pipe);
    ck_assert_int_eq(pclose(pipe), 0);
    ck_assert_uint_eq(count, bytes);
    ck_assert_mem_eq(wanted, png, count);
}

START_TEST(test_models__pictures_are_those_of_the_program)
{
    char folder[] = "/tmp/penumbra-models-XXXXXX", text[512], command[64], png[1 << 14];
    ck_assert_ptr_nonnull(mkdtemp(folder));
    snprintf(command, sizeof command, "mkdir %s/sub", folder);
    ck_assert_int_eq(system(command), 0);
    snprintf(text, sizeof text, scene, "model.obj");
    write_file(folder, "model.obj", obj);
    write_file(folder, "sub/red.mtl", mtl);
    write_file(folder, "scene.json", text);
    setup();
    size_t bytes = png_of(load("model.obj", NULL), png, sizeof png);
    teardown();
    ck_assert_str_eq(shelf.names, "model.obj;sub/red.mtl;");
    check_like_program(folder, "scene.json", png, bytes);
    setup();
    bytes = png_of(penumbra_scene_model("model.obj", &models, NULL), png, sizeof png);
    teardown();
    ck_assert_str_eq(shelf.names, "model.obj;sub/red.mtl;"); /* each file once */
    check_like_program(folder, "model.obj", png, bytes);
    setup();
    models.up = 'z';
    bytes = png_of(penumbra_scene_model("model.obj", &models, NULL), png, sizeof png);
    teardown();
    check_like_program(folder, "model.obj --up z", png, bytes);
    snprintf(command, sizeof command, "rm -r %s", folder);
    ck_assert_int_eq(system(command), 0);
}
END_TEST

static void check_refused(struct penumbra_scene *got, struct penumbra_errors **errors,
                          const char *code, const char *pointer)
{
    struct penumbra_error error = {.size = sizeof error};
    ck_assert_ptr_null(got);
    ck_assert_int_eq(penumbra_errors_get(*errors, 0, &error), 1);
    ck_assert_msg(strcmp(error.code, code) == 0, "%s: %s, not %s", error.code, error.text, code);
    ck_assert_str_eq(error.pointer, pointer);
    penumbra_errors_free(*errors);
}

START_TEST(test_models__wrong_files_are_errors)
{
    struct penumbra_errors *errors = NULL;
    setup();
    check_refused(load("none.ply", &errors), &errors, "not-found", "/objects/0/file");
    ck_assert_int_eq(shelf.asked, 1);
    check_refused(load("../model.obj", &errors), &errors, "forbidden", "/objects/0/file");
    check_refused(load("/model.obj", &errors), &errors, "forbidden", "/objects/0/file");
    check_refused(load("model.txt", &errors), &errors, "unsupported", "/objects/0/file");
    check_refused(penumbra_scene_model("sub/../model.obj", &models, &errors), &errors, "forbidden",
                  "");
    ck_assert_int_eq(shelf.asked, 1);
    models.max_triangles = 3;
    check_refused(load("model.obj", &errors), &errors, "too-large", "/objects/0/file");
    models.max_triangles = 0;
    models.up = 'x';
    check_refused(penumbra_scene_model("model.obj", &models, &errors), &errors, "usage", "");
    models.up = 0;
    models.read = NULL;
    check_refused(load("model.obj", &errors), &errors, "invalid-scene", "/objects/0/file");
    check_refused(penumbra_scene_model("model.obj", &models, &errors), &errors, "usage", "");
    check_refused(penumbra_scene_model("model.obj", NULL, &errors), &errors, "usage", "");
    models.size = 1;
    check_refused(load("model.obj", &errors), &errors, "usage", "");
    teardown();
}
END_TEST

START_TEST(test_models__no_allocation_is_taken_for_granted)
{
    setup();
    penumbra_scene_free(penumbra_scene_model("model.obj", &models, NULL));
    for (long n = 0;; n++) {
        struct penumbra_errors *errors = NULL;
        struct penumbra_error error = {.size = sizeof error};
        shelf = (struct shelf){0};
        alloc_fail_after(n);
        struct penumbra_scene *got = penumbra_scene_model("model.obj", &models, &errors);
        const bool refused = alloc_succeed();
        const bool told = penumbra_errors_get(errors, 0, &error);
        ck_assert_msg(told == !got, "allocation %ld", n);
        penumbra_errors_free(errors);
        penumbra_scene_free(got);
        if (!refused) {
            ck_assert_ptr_nonnull(got);
            ck_assert_int_gt(n, 40);
            break;
        }
    }
    teardown();
}
END_TEST

PEN_SUITE("models", test_models__pictures_are_those_of_the_program,
          test_models__wrong_files_are_errors, test_models__no_allocation_is_taken_for_granted)
