/* SPDX-License-Identifier: MIT */
/* STL files: ASCII and binary, told apart by size; vertices that become one. */
#include "support/models.h"

#define FACET(a, b, c)                                                                             \
    "facet normal 0 0 1\n outer loop\n vertex " a "\n vertex " b "\n vertex " c                    \
    "\n endloop\nendfacet\n"

/* A binary file of triangles; returns its length. */
static size_t write_binary(unsigned char *out, float (*corner)[3][3], uint32_t count)
{
    memset(out, 0, 84 + 50 * count);
    memcpy(out, "solid of a program that does not know better", 44);
    for (int i = 0; i < 4; i++)
        out[80 + i] = (unsigned char)(count >> (8 * i));
    for (uint32_t t = 0; t < count; t++) {
        for (int i = 0; i < 9; i++) {
            uint32_t bits;
            memcpy(&bits, &corner[t][i / 3][i % 3], sizeof bits);
            for (int k = 0; k < 4; k++)
                out[84 + 50 * t + 12 + 4 * (uint32_t)i + (uint32_t)k] =
                    (unsigned char)(bits >> (8 * k));
        }
        out[84 + 50 * t + 48] = 9; /* an attribute */
    }
    return 84 + 50 * (size_t)count;
}

START_TEST(test_model_stl__text_and_binary_are_the_same)
{
    static float corner[2][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1.5f, 0}},
                                    {{1, 0, 0}, {0, -0.0f, -0.0f}, {0, 1.5f, -1}}};
    static const float vertex[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1.5f, 0}, {0, 1.5f, -1}};
    unsigned char file[300];
    struct model r = {.mtl = NULL};
    for (int binary = 0; binary < 2; binary++) {
        if (binary)
            ck_assert(model_read(&r, PEN_MODEL_STL, file, write_binary(file, corner, 2)));
        else
            ck_assert(model_text(
                &r, PEN_MODEL_STL,
                "\n solid a name of facet endsolid\r\n" FACET(
                    "0 0 0", "1 0 0",
                    "0 1.5 0") "ENDSOLID a name\r\nSolid\n" FACET("1 0 0", "0 -0 -0.0",
                                                                  "0 15e-1 -1") "endsolid"));
        ck_assert_uint_eq(r.m.vertex_count, 4);
        ck_assert_mem_eq(r.m.vertex, vertex, sizeof vertex);
        model_check_corners(&r, (const uint32_t[][3]){{0, 1, 2}, {1, 0, 3}}, 2);
        ck_assert(r.m.open_edges == 4 && model_noted(&r, "4 edges"));
    }
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_stl__is_refused_if_its_size_is_wrong)
{
    static float corner[1][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    unsigned char file[300];
    struct model r = {.mtl = NULL};
    size_t bytes = write_binary(file, corner, 1);
    ck_assert(!model_read(&r, PEN_MODEL_STL, file, bytes - 1)); /* begins with "solid" */
    ck_assert(r.st.code == PEN_SYNTAX && strstr(r.st.msg, "84 bytes and 50"));
    file[0] = 'x';
    ck_assert(model_read(&r, PEN_MODEL_STL, file, bytes));
    for (size_t n = 0; n < bytes; n++) {
        ck_assert(!model_read(&r, PEN_MODEL_STL, file, n));
        ck_assert(r.st.code == PEN_SYNTAX && strstr(r.st.msg, "84 bytes and 50"));
    }
    ck_assert(!model_read(&r, PEN_MODEL_STL, file, bytes + 1));
    ck_assert(strstr(r.st.msg, "promises 1 triangles, which take 134 bytes"));
    write_binary(file, corner, 0);
    ck_assert(!model_read(&r, PEN_MODEL_STL, file, 84));
    ck_assert_int_eq(r.st.code, PEN_INVALID);
}
END_TEST

START_TEST(test_model_stl__refuses_numbers_that_are_not_finite)
{
    float corner[2][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 2}}};
    unsigned char file[300];
    struct model r = {.mtl = NULL};
    corner[1][2][1] = NAN;
    ck_assert(!model_read(&r, PEN_MODEL_STL, file, write_binary(file, corner, 2)));
    ck_assert_msg(r.st.code == PEN_INVALID && strstr(r.st.msg, "Byte 174"), "%s", r.st.msg);
    corner[1][2][1] = -INFINITY;
    ck_assert(!model_read(&r, PEN_MODEL_STL, file, write_binary(file, corner, 2)));
}
END_TEST

START_TEST(test_model_stl__refuses_with_a_line_and_advice)
{
    static const struct model_refusal refusals[] = {
        {"solid\nendsolid\n", PEN_INVALID, 0, "has an area"},
        {"solid\n" FACET("0 0 0", "1 0 0", "0 1 0"), PEN_SYNTAX, 9, "write endsolid"},
        {"solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0", PEN_SYNTAX, 4, "the end of the file"},
        {"solid\n" FACET("0 0 0", "1 x 0", "0 1 0"), PEN_SYNTAX, 5, "found \"x\""},
        {"solid\n" FACET("0 0 0", "1 0 0", "0 1 0\nvertex 1 1 1"), PEN_SYNTAX, 7, "write endloop"},
        {"solid\nface normal 0 0 0\n", PEN_SYNTAX, 2, "found \"face\""},
        {"solid\nendsolid\n" FACET("0 0 0", "1 0 0", "0 1 0"), PEN_SYNTAX, 3, "write solid"},
        {"solid\nfacet normal 0 0 1\nouter loops\n", PEN_SYNTAX, 3, "write loop"},
        {"solid\n" FACET("0 0 0", "1 1e99 0", "0 1 0"), PEN_INVALID, 5, "too large"},
    };
    model_check_refusals(PEN_MODEL_STL, refusals, sizeof refusals / sizeof refusals[0]);
}
END_TEST

START_TEST(test_model_stl__allows_as_many_triangles_as_are_asked_for)
{
    struct model r = {.max_triangles = 2};
    const char *two = "solid\n" FACET("0 0 0", "1 0 0", "1 0 0") FACET("0 0 0", "1 0 0", "0 1 0");
    char file[1000];
    snprintf(file, sizeof file, "%sendsolid\n", two);
    ck_assert(model_text(&r, PEN_MODEL_STL, file));
    ck_assert(r.m.repeated == 1 && r.m.triangle_count == 1);
    snprintf(file, sizeof file, "%s%sendsolid\n", two, FACET("0 0 0", "1 0 0", "0 1 0"));
    ck_assert(!model_text(&r, PEN_MODEL_STL, file));
    ck_assert_int_eq(r.st.code, PEN_TOO_LARGE);
}
END_TEST

PEN_SUITE("io/model_stl", test_model_stl__text_and_binary_are_the_same,
          test_model_stl__is_refused_if_its_size_is_wrong,
          test_model_stl__refuses_numbers_that_are_not_finite,
          test_model_stl__refuses_with_a_line_and_advice,
          test_model_stl__allows_as_many_triangles_as_are_asked_for)
