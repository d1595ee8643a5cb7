/* SPDX-License-Identifier: MIT */
/* PLY files: all types in both byte orders and as text, what is skipped, and what is refused. */
#include "support/models.h"
#include "support/random.h"

#define HEAD "ply\nformat ascii 1.0\n"
#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define FACE "property list uchar int vertex_indices\nend_header\n"
#define THREE "0 0 0\n1 0 0\n0 1 0\n"

START_TEST(test_model_ply__reads_text_with_properties_in_any_order)
{
    struct model r = {.mtl = NULL};
    ck_assert(model_text(
        &r, PEN_MODEL_PLY,
        "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info none\r\nelement note 2\r\n"
        "property list uchar float weights\r\nproperty uchar red\r\nelement vertex 4\r\n"
        "property uchar red\r\nproperty float z\r\nproperty float nx\r\nproperty list char int "
        "more\r\n"
        "property float x\r\nproperty float nz\r\nproperty float y\r\nproperty float ny\r\n"
        "property float s\r\nelement empty 4000000000\r\nelement face 2\r\nproperty uchar flags\r\n"
        "property list int uint vertex_index\r\nproperty list uchar float "
        "texcoord\r\nend_header\r\n"
        "2 .5 .25 7\r\n0 9\r\n"
        "1 0 .1 0 0 .3 0 .2 0\r\n2 0 .1 1 7 1 .3 0 .2 0\r\n3 0 .1 0 0 .3 1 .2 0\r\n4 1 1 2 5 6 0 0 "
        "0 1 "
        ".5\r\n255 3 0 1 2 2 .1 .2\r\n0 3 0 1 3 0\r\n"));
    const float vertex[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    ck_assert_uint_eq(r.m.vertex_count, 4);
    ck_assert_mem_eq(r.m.vertex, vertex, sizeof vertex);
    model_check_corners(&r, (const uint32_t[][3]){{0, 1, 2}, {0, 1, 3}}, 2);
    ck_assert_uint_eq(r.m.normal_count, 4);
    ck_assert(r.m.normal[0][0] == 0.1f && r.m.normal[0][1] == 0.2f && r.m.normal[0][2] == 0.3f);
    ck_assert(!r.m.corner_normal && !r.m.material_of && r.m.material_count == 0);
    pen_model_release(&r.m);
}
END_TEST

/* Coordinates and indices of the same small mesh, in all types. */
static const char *const types[] = {"char",  "uint8", "int16", "ushort",
                                    "int32", "uint",  "float", "float64"};
static const int sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};

static size_t put(unsigned char *out, int type, double value, bool big)
{
    const int size = sizes[type];
    uint64_t bits = type < 6 ? (uint64_t)(int64_t)value : 0;
    float f = (float)value;
    uint32_t word;
    memcpy(&word, &f, sizeof word);
    if (type == 6)
        bits = word;
    if (type == 7)
        memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < size; i++)
        out[big ? size - 1 - i : i] = (unsigned char)(bits >> (8 * i));
    return (size_t)size;
}

/* The mesh as binary file; returns its length. */
static size_t write_binary(unsigned char *out, int coordinate, int count, int index, bool big)
{
    static const double vertex[4][3] = {{0, 0, 0}, {100, 0, 1}, {0, 120, 3}, {5, 2, 50}};
    static const double face[2][5] = {{3, 0, 1, 2}, {4, 0, 1, 3, 2}};
    size_t n = (size_t)sprintf((char *)out,
                               "ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty %s "
                               "x\nproperty %s y\nproperty %s z\nelement face 2\nproperty uchar "
                               "skipped\nproperty list %s %s vertex_indices\nend_header\n",
                               big ? "big" : "little", types[coordinate], types[coordinate],
                               types[coordinate], types[count], types[index]);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            n += put(out + n, coordinate, vertex[i][k], big);
    for (int i = 0; i < 2; i++) {
        out[n++] = 77;
        n += put(out + n, count, face[i][0], big);
        for (int k = 1; k <= (int)face[i][0]; k++)
            n += put(out + n, index, face[i][k], big);
    }
    return n;
}

START_TEST(test_model_ply__reads_every_type_in_both_byte_orders)
{
    static const float vertex[4][3] = {{0, 0, 0}, {100, 0, 1}, {0, 120, 3}, {5, 2, 50}};
    unsigned char file[1024];
    struct model r = {.mtl = NULL};
    uint32_t first[3][3];
    for (int i = 0; i < 2 * 8 * 8 * 8; i++) {
        size_t bytes = write_binary(file, i / 2 % 8, i / 16 % 8, i / 128, i % 2);
        ck_assert_msg(model_read(&r, PEN_MODEL_PLY, file, bytes), "%s\n%s", file, r.st.msg);
        ck_assert_mem_eq(r.m.vertex, vertex, sizeof vertex);
        ck_assert_uint_eq(r.m.triangle_count, 3);
        if (i == 0)
            memcpy(first, r.m.corner, sizeof first);
        ck_assert_mem_eq(r.m.corner, first, sizeof first);
    }
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_ply__refuses_every_truncation)
{
    unsigned char file[1024];
    struct model r = {.mtl = NULL};
    size_t bytes = write_binary(file, 6, 1, 4, false);
    for (size_t n = 0; n < bytes; n++) {
        ck_assert(!model_read(&r, PEN_MODEL_PLY, file, n));
        ck_assert_int_eq(r.st.code, PEN_SYNTAX);
    }
    ck_assert(strstr(r.st.msg, "Byte ") && strstr(r.st.msg, "\"face\""));
    ck_assert(model_read(&r, PEN_MODEL_PLY, file, bytes));
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_ply__keeps_floats_bit_by_bit)
{
    struct random random = random_begin(1);
    struct model r = {.mtl = NULL};
    const int count = 3000;
    char *text = malloc((size_t)count * 64 + 400);
    float(*v)[3] = malloc((size_t)count * sizeof *v);
    ck_assert(text && v);
    int n = sprintf(text, HEAD "element vertex %d\n" XYZ "element face 1\n" FACE, count);
    for (int i = 0; i < 3 * count; i++) {
        uint32_t bits = (uint32_t)random_bits(&random);
        bits = (bits >> 23 & 0xff) == 0xff ? bits & 0xff7fffffu : bits;
        memcpy(&v[i / 3][i % 3], &bits, sizeof bits);
        n += sprintf(text + n, "%.9g\n", (double)v[i / 3][i % 3]);
    }
    sprintf(text + n, "3 0 1 2\n");
    ck_assert_msg(model_text(&r, PEN_MODEL_PLY, text), "%s (seed %llu)", r.st.msg,
                  (unsigned long long)random.seed);
    ck_assert(r.m.shift[0] == 0 && r.m.shift[1] == 0 && r.m.shift[2] == 0);
    ck_assert_mem_eq(r.m.vertex, v, (size_t)count * sizeof *v);
    free(text);
    free(v);
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_ply__refuses_with_a_place_and_advice)
{
    static const struct model_refusal refusals[] = {
        {"", PEN_SYNTAX, 1, "ply as the first line"},
        {"plyx\n", PEN_SYNTAX, 1, "found \"plyx\""},
        {"ply\nformat ascii 2.0\n", PEN_SYNTAX, 2, "binary_big_endian, and 1.0"},
        {"ply\nformat text 1.0\n", PEN_SYNTAX, 2, "found \"text\""},
        {HEAD "element vertex -1\n", PEN_SYNTAX, 3, "a count below"},
        {HEAD "element vertex 1.5\n", PEN_SYNTAX, 3, "a count below"},
        {HEAD "element vertex\n", PEN_SYNTAX, 3, "the end of the line"},
        {HEAD "property float x\n", PEN_SYNTAX, 3, "after its element"},
        {HEAD "element vertex 3\nproperty half x\n", PEN_SYNTAX, 4, "found \"half\""},
        {HEAD "element vertex 3\nproperty float x\nproperty float x\n", PEN_SYNTAX, 5, "once"},
        {HEAD "element vertex 3\n" XYZ, PEN_SYNTAX, 7, "end_header: the file is truncated"},
        {"ply\nelement vertex 3\n" XYZ "element face 1\n" FACE, PEN_SYNTAX, 8, "the format"},
        {HEAD "element vertex 3\nproperty float x\nproperty float y\nend_header\n", PEN_INVALID, 0,
         "x, y and z"},
        {HEAD "element vertex 3\n" XYZ "end_header\n" THREE, PEN_INVALID, 0, "point clouds"},
        {HEAD "element vertex 3\n" XYZ "element face 0\n" FACE THREE, PEN_INVALID, 0,
         "point clouds"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "2 0 1\n", PEN_INVALID, 0,
         "point clouds"},
        {HEAD "element vertex 9\n" XYZ "element face 1\n" FACE THREE, PEN_SYNTAX, 10,
         "promises 9 of the element \"vertex\""},
        {HEAD "element vertex 4294967294\n" XYZ "element face 1\n" FACE THREE, PEN_SYNTAX, 10,
         "promises 4294967294"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "3 0 1", PEN_SYNTAX, 13,
         "number 1 of 1 of the element \"face\""},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "900 0 1 2", PEN_SYNTAX, 13,
         "number 1 of 1 of the element \"face\""},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "3 0 1 3\n", PEN_INVALID, 13,
         "has 3 where an integer from 0 to below 3"},
        {HEAD "element vertex 0\n" XYZ "element face 1\n" FACE "3 0 1 2\n", PEN_INVALID, 10,
         "below 0"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "3 0 1 -1\n", PEN_INVALID, 13,
         "has -1 where"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "3 0 1 1.5\n", PEN_INVALID, 13,
         "has 1.5 where"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE THREE "-3 0 1 2\n", PEN_INVALID, 13,
         "has -3 where"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n",
         PEN_SYNTAX, 10, "found \"nan\""},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE "0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n",
         PEN_SYNTAX, 11, "found \"inf\""},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE "0 0 0\n1 1e39 0\n0 1 0\n3 0 1 2\n",
         PEN_INVALID, 11, "too large"},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE "0 0 0\n1 0x1 0\n0 1 0\n3 0 1 2\n",
         PEN_SYNTAX, 11, "found \"0x1\""},
        {HEAD "element vertex 3\n" XYZ "element face 1\n" FACE "0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n",
         PEN_INVALID, 0, "has an area"},
    };
    model_check_refusals(PEN_MODEL_PLY, refusals, sizeof refusals / sizeof refusals[0]);
}
END_TEST

START_TEST(test_model_ply__refuses_numbers_of_binary_files_that_are_not_finite)
{
    unsigned char file[1024];
    struct model r = {.mtl = NULL};
    const double wrong[] = {(double)NAN, (double)INFINITY, 1e39};
    for (int i = 0; i < 5; i++) {
        const int type = i < 2 ? 6 : 7;
        size_t bytes = write_binary(file, type, 1, 4, false), at = bytes;
        at -= 2 * 2 + 7 * 4 + 12 * (size_t)sizes[type] - 4 * (size_t)sizes[type];
        put(file + at, type, wrong[i % 2 + (i == 4)], false);
        if (i == 4)
            put(file + at, type, 1e39, false);
        ck_assert(!model_read(&r, PEN_MODEL_PLY, file, bytes));
        ck_assert_msg(r.st.code == PEN_INVALID && strstr(r.st.msg, "vertex 1 has the number"), "%s",
                      r.st.msg);
    }
}
END_TEST

START_TEST(test_model_ply__passes_over_unknown_lines_of_the_header_with_a_note)
{
    struct model r = {.mtl = NULL};
    ck_assert(model_text(&r, PEN_MODEL_PLY,
                         HEAD "Created by hand\nelement vertex 3\n" XYZ
                              "element face 1\n" FACE THREE "3 0 1 2"));
    ck_assert(model_noted(&r, "\"Created\"") && r.notes.item[0].line == 3);
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_ply__allows_as_many_triangles_as_are_asked_for)
{
    struct model r = {.max_triangles = 2};
    const char *text =
        HEAD "element vertex 5\n" XYZ "element face 1\n" FACE THREE "0 .5 0\n.1 .1 0\n";
    char file[600];
    snprintf(file, sizeof file, "%s4 0 1 2 3\n", text);
    ck_assert(model_text(&r, PEN_MODEL_PLY, file));
    snprintf(file, sizeof file, "%s5 0 1 2 3 4\n", text);
    ck_assert(!model_text(&r, PEN_MODEL_PLY, file));
    ck_assert_int_eq(r.st.code, PEN_TOO_LARGE);
    ck_assert(strstr(r.st.msg, "3 triangles, and 2 are allowed"));
}
END_TEST

PEN_SUITE("io/model_ply", test_model_ply__reads_text_with_properties_in_any_order,
          test_model_ply__reads_every_type_in_both_byte_orders,
          test_model_ply__refuses_every_truncation, test_model_ply__keeps_floats_bit_by_bit,
          test_model_ply__refuses_with_a_place_and_advice,
          test_model_ply__refuses_numbers_of_binary_files_that_are_not_finite,
          test_model_ply__passes_over_unknown_lines_of_the_header_with_a_note,
          test_model_ply__allows_as_many_triangles_as_are_asked_for)
