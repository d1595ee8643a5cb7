/* SPDX-License-Identifier: MIT */
/* What all readers share: numbers, shift, faces without area, polygons, edges. */
#include <math.h>

#include "geom/triangulate.h"
#include "math/exact_sum.h"
#include "support/models.h"
#include "support/random.h"

/* Random decimals, many of them hard: digits beyond a float, the middle of two floats, the ends of
 * the range. */
static int write_decimal(struct random *r, char *out, size_t bytes)
{
    const float f = (float)random_in(r, -1000, 1000);
    float next = nextafterf(f, INFINITY);
    switch (random_below(r, 6)) {
    case 0:
        return snprintf(out, bytes, "%.*f", (int)random_below(r, 30), random_in(r, -1e4, 1e4));
    case 1:
        return snprintf(out, bytes, "%.*e", (int)random_below(r, 40),
                        ldexp(random_in(r, -1, 1), (int)random_below(r, 290) - 165));
    case 2:
        return snprintf(out, bytes, "%.*f", 30 + (int)random_below(r, 50),
                        ((double)f + (double)next) / 2);
    case 3:
        return snprintf(out, bytes, "%+.*g", 15 + (int)random_below(r, 4),
                        ((double)f + (double)next) / 2);
    case 4:
        return snprintf(out, bytes, "%llu.%llue-%u", (unsigned long long)random_bits(r) >> 40,
                        (unsigned long long)random_bits(r), random_below(r, 60));
    default:
        return snprintf(out, bytes, "00%u.", random_below(r, 1u << 31));
    }
}

START_TEST(test_model_mesh__decimals_become_the_nearest_floats)
{
    struct random random = random_begin(2);
    struct model r = {.mtl = NULL};
    const int count = random_some(1000000, 60000) / 3;
    char *text = malloc((size_t)count * 3 * 120 + 100);
    float(*want)[3] = malloc((size_t)count * sizeof *want);
    size_t n = 0;
    ck_assert(text && want);
    for (int i = 0; i < 3 * count; i++) {
        n += (size_t)sprintf(text + n, i % 3 == 0 ? "\nv " : " ");
        int length = write_decimal(&random, text + n, 110);
        want[i / 3][i % 3] = strtof(text + n, NULL);
        n += (size_t)length;
    }
    strcpy(text + n, "\nf 1 2 3\n");
    ck_assert_msg(model_text(&r, PEN_MODEL_OBJ, text), "%s (seed %llu)", r.st.msg,
                  (unsigned long long)random.seed);
    for (int i = 0; i < count; i++)
        ck_assert_msg(memcmp(r.m.vertex[i], want[i], sizeof want[i]) == 0,
                      "vertex %d: %a %a %a (seed %llu)", i, (double)want[i][0], (double)want[i][1],
                      (double)want[i][2], (unsigned long long)random.seed);
    free(text);
    free(want);
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_mesh__bad_decimals_are_refused)
{
    static const char *const bad[] = {"",    "-",   ".",   "1e",  "1e+",  "0x1", "1.0f", "+-1",
                                      "1..", "1_0", "inf", "NaN", "1e99", "1d3", "1,0",  "٣"};
    struct model r = {.mtl = NULL};
    char text[700], digits[600];
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0 1 %s\nf 1 2 3\n", bad[i]);
        ck_assert_msg(!model_text(&r, PEN_MODEL_OBJ, text), "%s", bad[i]);
        ck_assert_int_eq(r.st.line, 3);
    }
    memset(digits, '1', sizeof digits - 1);
    digits[1] = '.';
    digits[sizeof digits - 1] = '\0';
    snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0 1 %s\nf 1 2 3\n", digits);
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, text));
    ck_assert(strstr(r.st.msg, "a number of 599 characters"));
}
END_TEST

START_TEST(test_model_mesh__a_far_model_gets_a_shift_and_is_rounded_once)
{
    struct random random = random_begin(3);
    struct model r = {.mtl = NULL};
    char text[2000];
    for (int i = 0; i < 300; i++) {
        const double far = ldexp(random_in(&random, 1, 2), (int)random_below(&random, 40));
        const double size = far * ldexp(1, -5 - (int)random_below(&random, 20));
        double v[3][3];
        int n = 0;
        for (int k = 0; k < 9; k++) {
            v[k / 3][k % 3] = (k % 3 == 1 ? far : 0) + random_in(&random, -size, size);
            n += snprintf(text + n, sizeof text - (size_t)n, "%s %.17g", k % 3 ? "" : "\nv",
                          v[k / 3][k % 3]);
        }
        snprintf(text + n, sizeof text - (size_t)n, "\nf 1 2 3\n");
        ck_assert_msg(model_text(&r, PEN_MODEL_OBJ, text), "%s", r.st.msg);
        ck_assert(r.m.shift[1] != 0 && fabs(r.m.shift[1] - far) < 4 * size);
        for (int k = 0; k < 9; k++) {
            const long double exact = (long double)v[k / 3][k % 3] - r.m.shift[k % 3];
            ck_assert_msg(r.m.vertex[k / 3][k % 3] == (float)exact, "seed %llu",
                          (unsigned long long)random.seed);
        }
    }
    pen_model_release(&r.m);
}
END_TEST

/* Bounds of all vertices would hide that the triangles are far. */
START_TEST(test_model_mesh__vertices_that_no_face_uses_do_not_count)
{
    static const double corner[3] = {500000.01, 500001.02, 500000.97};
    static const char *const texts[] = {
        "v 0 0 0\nv 0 1 500000.01\nv 0 0 500001.02\nv 1 0 500000.97\nusemtl a\nf 2 2 3\nf 2 3 4\n",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n0 1 500000.01\n0 0 500001.02\n1 0 500000.97\n3 1 1 2\n3 1 2 3\n"};
    struct model r = {.mtl = NULL};
    for (int kind = 0; kind < 2; kind++) {
        ck_assert(model_text(&r, kind ? PEN_MODEL_PLY : PEN_MODEL_OBJ, texts[kind]));
        ck_assert(r.m.shift[2] != 0 && r.m.repeated == 1 && r.m.triangle_count == 1);
        for (int i = 0; i < 3; i++)
            ck_assert(r.m.vertex[i + 1][2] == (float)(corner[i] - r.m.shift[2]));
        ck_assert(kind == 1 || model_noted(&r, "the material of 1 statements usemtl"));
    }
    pen_model_release(&r.m);
}
END_TEST

/* The differences in x need 54 bits. Rounded first to a double, one is in the middle of two floats.
 */
START_TEST(test_model_mesh__a_shift_does_not_round_twice)
{
    struct model r = {.mtl = NULL};
    char text[200];
    snprintf(text, sizeof text, "v 0.2 1000 0\nv 2.2 1000 1\nv %.17g 1001 0\nf 1 2 3\n",
             1 - 0x1p-24 - 0x1p-53);
    ck_assert(model_text(&r, PEN_MODEL_OBJ, text));
    ck_assert(r.m.shift[0] == 2 && r.m.shift[1] == 1000);
    ck_assert(r.m.vertex[2][0] == -1 - 0x1p-23f);
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_mesh__near_models_and_short_floats_have_no_shift)
{
    struct model r = {.mtl = NULL};
    ck_assert(model_text(&r, PEN_MODEL_OBJ, "v 10.1 1 1\nv 12.3 1 1\nv 11 3.3 1\nf 1 2 3\n"));
    ck_assert(r.m.shift[0] == 0 && r.m.vertex[1][0] == 12.3f);
    ck_assert(
        model_text(&r, PEN_MODEL_STL,
                   "solid\nfacet\nouter loop\nvertex 1001 0 0\nvertex 1000 0 0\nvertex 1000 1 "
                   "0\nendloop\nendfacet\nendsolid"));
    ck_assert(r.m.shift[0] != 0 && r.m.shift[1] == 0);
    ck_assert(r.m.shift[0] + (double)r.m.vertex[0][0] == 1001);
    /* Doubles of a PLY that floats cannot hold. */
    const char *ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double "
                      "y\nproperty double z\nelement face 1\nproperty list uchar int "
                      "vertex_indices\nend_header\n";
    char text[500];
    snprintf(text, sizeof text, "%s10.1 0 0\n11.1 0 0\n10.2 1 0\n3 0 1 2\n", ply);
    ck_assert(model_text(&r, PEN_MODEL_PLY, text));
    ck_assert(r.m.shift[0] != 0 && r.m.vertex[0][0] == (float)(10.1 - r.m.shift[0]));
    snprintf(text, sizeof text, "%s0.1 0 0\n1.1 0 0\n0.2 1 0\n3 0 1 2\n", ply);
    ck_assert(model_text(&r, PEN_MODEL_PLY, text));
    ck_assert(r.m.shift[0] == 0 && r.m.vertex[0][0] == 0.1f);
    pen_model_release(&r.m);
}
END_TEST

/* Triangles on or near a line, of floats whose differences need not be doubles. */
START_TEST(test_model_mesh__area_is_decided_exactly)
{
    struct random random = random_begin(4);
    struct model r = {.mtl = NULL};
    char text[500];
    int flat = 0;
    for (int i = 0; i < random_some(200000, 10000); i++) {
        float v[3][3];
        const float step =
            (float)ldexp(1, -(int)random_below(&random, 2) * 60 - (int)random_below(&random, 60));
        const uint32_t along = random_below(&random, 2) * (1 + random_below(&random, 3));
        for (int k = 0; k < 3; k++) {
            v[0][k] = (float)random_below(&random, 5) * (random_below(&random, 3) ? 1 : step);
            v[1][k] = v[0][k] + (float)(along > 0 ? along : random_below(&random, 4));
            v[2][k] = random_below(&random, 5) ? 2 * v[1][k] - v[0][k] : v[1][k] + step;
        }
        int n = 0;
        for (int k = 0; k < 3; k++)
            n += snprintf(text + n, sizeof text - (size_t)n, "v %.9g %.9g %.9g\n", (double)v[k][0],
                          (double)v[k][1], (double)v[k][2]);
        snprintf(text + n, sizeof text - (size_t)n,
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n");
        struct pen_vec3 p[3];
        for (int k = 0; k < 3; k++)
            p[k] = pen_vec3(v[k][0], v[k][1], v[k][2]);
        const struct pen_vec3 normal = pen_exact_normal(p, 3);
        const bool none = normal.x == 0 && normal.y == 0 && normal.z == 0;
        ck_assert(model_text(&r, PEN_MODEL_OBJ, text));
        if (r.m.shift[0] != 0 || r.m.shift[1] != 0 || r.m.shift[2] != 0)
            continue;
        ck_assert_msg(r.m.flat == none && r.m.triangle_count == 2 - (uint32_t)none,
                      "%s (seed %llu)", text, (unsigned long long)random.seed);
        flat += none;
    }
    ck_assert_int_gt(flat, 100);
    pen_model_release(&r.m);
}
END_TEST

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, 3 * sizeof(uint32_t));
}

/* Writes triangles each from its least corner on, sorted. */
static void sort_pieces(const uint32_t (*piece)[3], uint32_t count, uint32_t (*out)[3])
{
    for (uint32_t t = 0; t < count; t++) {
        const uint32_t *c = piece[t];
        int least = c[0] < c[1] && c[0] < c[2] ? 0 : c[1] < c[2] ? 1 : 2;
        for (int i = 0; i < 3; i++)
            out[t][i] = c[(least + i) % 3];
    }
    qsort(out, count, sizeof *out, compare);
}

/* The triangles of a face, sorted. */
static uint32_t sorted_pieces(struct model *r, const char *points, const uint32_t *corner,
                              uint32_t count, uint32_t (*out)[3])
{
    char text[4000];
    int n = snprintf(text, sizeof text, "%sf", points);
    for (uint32_t i = 0; i < count; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, " %u", corner[i] + 1);
    ck_assert_msg(model_text(r, PEN_MODEL_OBJ, text), "%s", r->st.msg);
    sort_pieces((const uint32_t(*)[3])r->m.corner, r->m.triangle_count, out);
    return r->m.triangle_count;
}

START_TEST(test_model_mesh__polygons_are_cut_as_the_scenes_polygons)
{
    struct random random = random_begin(5);
    struct model r = {.mtl = NULL};
    for (int i = 0; i < 200; i++) {
        const uint32_t count = 4 + random_below(&random, 12);
        struct pen_vec3 v[16];
        uint32_t corner[16], first[16][3], again[16][3], piece[16][3];
        char points[2000];
        int n = 0;
        const bool regular = i % 2 == 1;       /* its ears have the same shape, but for rounding */
        for (uint32_t k = 0; k < count; k++) { /* tilted, and bent by rounding */
            const double angle = 6.2831853 * k / count,
                         radius = regular ? 1 : random_in(&random, 0.3, 1);
            const float x = (float)(radius * cos(angle)), y = (float)(radius * sin(angle)),
                        z = (float)(0.4 * (double)x - 0.7 * (double)y);
            v[k] = pen_vec3(x, y, z);
            n += snprintf(points + n, sizeof points - (size_t)n, "v %.9g %.9g %.9g\n", (double)x,
                          (double)y, (double)z);
            corner[k] = k;
        }
        uint32_t pieces = sorted_pieces(&r, points, corner, count, first);
        ck_assert_uint_eq(pieces, count - 2);
        ck_assert_uint_eq(r.m.open_edges, count);
        ck_assert(pen_triangulate(v, count, pen_exact_normal(v, count), piece));
        sort_pieces((const uint32_t(*)[3])piece, pieces, again);
        ck_assert_msg(regular || memcmp(again, first, pieces * sizeof *first) == 0, "seed %llu, %d",
                      (unsigned long long)random.seed, i);
        for (uint32_t turn = 1; turn < count; turn++) {
            for (uint32_t k = 0; k < count; k++)
                corner[k] = (k + turn) % count;
            ck_assert_uint_eq(sorted_pieces(&r, points, corner, count, again), pieces);
            ck_assert_mem_eq(again, first, pieces * sizeof *first);
        }
    }
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_mesh__repeated_corners_are_left_out)
{
    struct model r = {.mtl = NULL};
    const char *points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    char text[300];
    snprintf(text, sizeof text, "%sf 1 2 2\nf 1 1 2 3 3 1\nf 4 4 4\nf 1 2 3 4\n", points);
    ck_assert(model_text(&r, PEN_MODEL_OBJ, text));
    ck_assert(r.m.repeated == 3 && r.m.flat == 0 && r.m.triangle_count == 3);
    ck_assert(model_noted(&r, "3 faces have a corner twice"));
    snprintf(text, sizeof text, "%sv 2 0 0\nf 1 2 5\nf 1 2 5 2\nf 1 2 3\n", points);
    ck_assert(model_text(&r, PEN_MODEL_OBJ, text));
    ck_assert(r.m.flat == 2 && r.m.triangle_count == 1);
    ck_assert(model_noted(&r, "2 faces have no area and are left out"));
    pen_model_release(&r.m);
}
END_TEST

/* Counts edges by comparing all with all. */
static void count_slowly(const struct pen_model *m, const uint32_t *place, uint32_t *open,
                         uint32_t *crowded)
{
    const uint32_t edges = 3 * m->triangle_count;
    *open = *crowded = 0;
    for (uint32_t i = 0; i < edges; i++) {
        uint32_t same = 0;
        bool first = true;
        for (uint32_t k = 0; k < edges; k++) {
            const uint32_t *c = m->corner[i / 3], *d = m->corner[k / 3];
            uint32_t p = place[c[i % 3]], q = place[c[(i + 1) % 3]], s = place[d[k % 3]],
                     t = place[d[(k + 1) % 3]];
            bool is = (p == s && q == t) || (p == t && q == s);
            same += is;
            first = first && !(is && k < i);
        }
        *open += first && same == 1;
        *crowded += first && same >= 3;
    }
}

START_TEST(test_model_mesh__edges_are_counted)
{
    struct random random = random_begin(6);
    struct model r = {.mtl = NULL};
    for (int i = 0; i < 300; i++) {
        const uint32_t points = 4 + random_below(&random, 9), faces = 1 + random_below(&random, 40);
        char text[4000];
        uint32_t place[32], open, crowded;
        int n = 0;
        for (uint32_t k = 0; k < points; k++) {
            place[k] = k;
            n += snprintf(text + n, sizeof text - (size_t)n, "v %u %u %u\n", k * k % 31, k,
                          k * k * k % 29);
        }
        for (uint32_t k = 0; k < faces; k++) {
            uint32_t a = random_below(&random, points);
            n += snprintf(text + n, sizeof text - (size_t)n, "f %u %u %u\n", a + 1,
                          (a + 1 + k % 2) % points + 1, (a + 3) % points + 1);
        }
        ck_assert_msg(model_text(&r, PEN_MODEL_OBJ, text), "%s", r.st.msg);
        count_slowly(&r.m, place, &open, &crowded);
        ck_assert_uint_eq(r.m.open_edges, open);
        ck_assert_uint_eq(r.m.crowded_edges, crowded);
    }
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_mesh__a_seam_of_equal_places_is_no_open_edge)
{
    struct model r = {.mtl = NULL};
    const char *closed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 0\nv 1 -0 -0\nv 0 1 0\n"
                         "f 1 3 2\nf 5 6 4\nf 6 7 4\nf 7 5 4\n";
    ck_assert(model_text(&r, PEN_MODEL_OBJ, closed));
    ck_assert(r.m.open_edges == 0 && r.m.crowded_edges == 0 && r.notes.count == 0);
    ck_assert_uint_eq(r.m.vertex_count, 7);
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_mesh__kinds_have_names)
{
    ck_assert_int_eq(pen_model_kind_of_name("a/b.ply"), PEN_MODEL_PLY);
    ck_assert_int_eq(pen_model_kind_of_name("A.OBJ"), PEN_MODEL_OBJ);
    ck_assert_int_eq(pen_model_kind_of_name("a.ply.stl"), PEN_MODEL_STL);
    ck_assert_int_eq(pen_model_kind_of_name("a.json"), PEN_MODEL_NONE);
    ck_assert_int_eq(pen_model_kind_of_name("ply"), PEN_MODEL_NONE);
    ck_assert_int_eq(pen_model_kind_of_name("a.ply/b"), PEN_MODEL_NONE);
    struct model r = {.mtl = NULL};
    ck_assert(!model_text(&r, PEN_MODEL_NONE, "ply"));
    ck_assert_int_eq(r.st.code, PEN_UNSUPPORTED);
}
END_TEST

PEN_SUITE("io/model_mesh", test_model_mesh__decimals_become_the_nearest_floats,
          test_model_mesh__bad_decimals_are_refused,
          test_model_mesh__a_far_model_gets_a_shift_and_is_rounded_once,
          test_model_mesh__vertices_that_no_face_uses_do_not_count,
          test_model_mesh__a_shift_does_not_round_twice,
          test_model_mesh__near_models_and_short_floats_have_no_shift,
          test_model_mesh__area_is_decided_exactly,
          test_model_mesh__polygons_are_cut_as_the_scenes_polygons,
          test_model_mesh__repeated_corners_are_left_out, test_model_mesh__edges_are_counted,
          test_model_mesh__a_seam_of_equal_places_is_no_open_edge,
          test_model_mesh__kinds_have_names)
