/* SPDX-License-Identifier: MIT */
/* Real files of Debian packages, in the folder PEN_MODELS, where tests/io/models.sh puts them. */
#include "support/models.h"

static const char *folder(void)
{
    const char *path = getenv("PEN_MODELS");
    if (!path)
        suite_skip("models", "PEN_MODELS names no folder with models (tests/io/models.sh)");
    return path;
}

/* Appends the bytes of a file. */
static bool append(const char *path, struct pen_buf *out)
{
    char bytes[1 << 16];
    FILE *file = fopen(path, "rb");
    for (size_t n; file && (n = fread(bytes, 1, sizeof bytes, file)) > 0;)
        pen_buf_add(out, bytes, n);
    if (file)
        fclose(file);
    return file != NULL;
}

static bool fetch(void *self, const char *name, struct pen_buf *out, struct pen_status *st)
{
    char path[1000];
    snprintf(path, sizeof path, "%s/%s", (const char *)self, name);
    return append(path, out) || pen_fail(st, PEN_NOT_FOUND, "No such file");
}

static bool read_file(struct model *r, char *in, const char *name)
{
    char path[1000];
    struct pen_buf bytes = {0};
    snprintf(path, sizeof path, "%s/%s", in, name);
    ck_assert_msg(append(path, &bytes), "there is no %s", path);
    const struct pen_model_file file = {bytes.data, bytes.bytes, pen_model_kind_of_name(name),
                                        0,          fetch,       in};
    r->ok = pen_model_read(&file, &r->m, &r->notes, &r->st);
    pen_buf_release(&bytes);
    return r->ok;
}

START_TEST(test_model_files__are_read)
{
    static const struct {
        const char *name;
        uint32_t vertices, triangles, normals, materials, left_out, open;
    } files[] = {{"bunny.obj", 34835, 69666, 0, 0, 0, 0},
                 {"UltimakerRobot_support.stl", 94009, 187974, 0, 0, 0, 102},
                 {"farm2_platform.obj", 5782, 11680, 6727, 0, 0, 0},
                 {"Wuson.ply", 11184, 3732, 11184, 0, 0, 412},
                 {"spider.obj", 762, 1312, 747, 4, 56, 72},
                 {"Spider_ascii.stl", 722, 1312, 0, 0, 56, 72}};
    char *in = (char *)folder();
    for (size_t i = 0; in && i < sizeof files / sizeof files[0]; i++) {
        struct model r = {.mtl = NULL};
        ck_assert_msg(read_file(&r, in, files[i].name), "%s: %s", files[i].name, r.st.msg);
        ck_assert_uint_eq(r.m.vertex_count, files[i].vertices);
        ck_assert_uint_eq(r.m.triangle_count, files[i].triangles);
        ck_assert_uint_eq(r.m.normal_count, files[i].normals);
        ck_assert_uint_eq(r.m.material_count, files[i].materials);
        ck_assert_uint_eq(r.m.flat + r.m.repeated, files[i].left_out);
        ck_assert_uint_eq(r.m.open_edges, files[i].open);
        ck_assert(r.m.shift[0] == 0 && r.m.shift[1] == 0 && r.m.shift[2] == 0);
        ck_assert(model_noted(&r, "map_Kd") == (files[i].materials > 0));
        pen_model_release(&r.m);
    }
}
END_TEST

START_TEST(test_model_files__ascii_and_binary_stl_are_the_same)
{
    struct model ascii = {.mtl = NULL}, binary = {.mtl = NULL};
    char *in = (char *)folder();
    if (!in)
        return;
    ck_assert(read_file(&ascii, in, "Spider_ascii.stl"));
    ck_assert(read_file(&binary, in, "Spider_binary.stl"));
    model_check_corners(&ascii, (const uint32_t(*)[3])binary.m.corner, binary.m.triangle_count);
    for (uint32_t i = 0; i < 3 * ascii.m.vertex_count; i++) {
        const double a = (double)ascii.m.vertex[i / 3][i % 3],
                     b = (double)binary.m.vertex[i / 3][i % 3];
        ck_assert(a - b < 1e-4 && b - a < 1e-4); /* the text has few digits */
    }
    pen_model_release(&ascii.m);
    pen_model_release(&binary.m);
}
END_TEST

START_TEST(test_model_files__a_point_cloud_is_refused)
{
    struct model r = {.mtl = NULL};
    char *in = (char *)folder();
    if (!in)
        return;
    ck_assert(!read_file(&r, in, "pond.0.ply"));
    ck_assert(r.st.code == PEN_INVALID && strstr(r.st.msg, "point clouds"));
}
END_TEST

PEN_SUITE("io/model_files", test_model_files__are_read,
          test_model_files__ascii_and_binary_stl_are_the_same,
          test_model_files__a_point_cloud_is_refused)
