/* SPDX-License-Identifier: MIT */
/* The checks of vertex loops: what is refused, at which place, and that the decisions are exact. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/desc.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static bool accepted(const vec3 *v, uint32_t count, struct pen_status *st)
{
    memset(st, 0, sizeof *st);
    return pen_polygon_check(v, count, st);
}

static void assert_accepted(const vec3 *v, uint32_t count)
{
    struct pen_status st;
    ck_assert_msg(accepted(v, count, &st), "%s: %s", st.at, st.msg);
}

static void assert_refused(const vec3 *v, uint32_t count, const char *at, const char *says)
{
    struct pen_status st;
    ck_assert(!accepted(v, count, &st));
    ck_assert_int_eq(st.code, PEN_INVALID);
    ck_assert_str_eq(st.at, at);
    ck_assert_msg(strstr(st.msg, says) != NULL, "\"%s\" does not say \"%s\"", st.msg, says);
}

START_TEST(test_polygon_check__accepts_simple_outlines)
{
    const vec3 triangle[] = {{0, 1, 0}, {1, 0, 0}, {-1, 0, 0}};
    assert_accepted(triangle, 3);
    const vec3 square[] = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}};
    assert_accepted(square, 4);
    const vec3 concave[] = {{0, 0, 0}, {4, 0, 4}, {4, 4, 4}, {2, 1, 2}, {0, 4, 0}};
    assert_accepted(concave, 5);
    const vec3 on_a_side[] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0.5, 0.5}}; /* straight angle */
    assert_accepted(on_a_side, 4);
}
END_TEST

START_TEST(test_polygon_check__refuses_too_few_and_repeated)
{
    const vec3 v[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {-0.0, 0, 0}};
    assert_refused(v, 2, "/vertices", "at least 3");
    assert_refused(v, 4, "/vertices/3", "repeats vertex 0");
    const vec3 twice[] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    assert_refused(twice, 4, "/vertices/2", "repeats vertex 1");
    const vec3 zeros[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-0.0, 0, -0.0}};
    assert_refused(zeros, 4, "/vertices/3", "repeats vertex 0");
}
END_TEST

START_TEST(test_polygon_check__refuses_no_area)
{
    const vec3 line[] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
    assert_refused(line, 3, "/vertices", "one line");
    const vec3 decimals[] = {{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}, {0.7, 0.7, 0.7}};
    assert_refused(decimals, 4, "/vertices", "one line");
}
END_TEST

/* Corners on a line through the origin, and two beside it at 1e-60: the rounding of differences
 * would hide the width, and the plane. */
START_TEST(test_polygon_check__accepts_needles)
{
    const vec3 needle[] = {{-0.3, 0.1, 0.7}, {1e-60, 2e-60, 3e-60}, {0.6, -0.2, -1.4}};
    assert_accepted(needle, 3);
    const vec3 both[] = {
        {-0.3, 0.1, 0.7}, {1e-60, 2e-60, 0}, {0.6, -0.2, -1.4}, {-1e-60, -2e-60, 0}};
    assert_accepted(both, 4);
    const vec3 dented[] = {
        {-0.3, 0.1, 0.7}, {1e-60, 2e-60, 0}, {0.6, -0.2, -1.4}, {5e-61, 1e-60, 0}};
    assert_accepted(dented, 4);
    const vec3 bow[] = {{-0.3, 0.1, 0.7}, {0.6, -0.2, -1.4}, {1e-60, 0, 0}, {-1e-60, 0, 0}};
    assert_refused(bow, 4, "/vertices/2", "meets itself");
}
END_TEST

START_TEST(test_polygon_check__h054_planar_within_a_millionth)
{
    vec3 quad[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 1e-9}, {0, 1, 0}};
    assert_accepted(quad, 4);
    quad[2].z = 0.9e-6;
    assert_accepted(quad, 4);
    quad[2].z = 1.1e-5;
    struct pen_status st;
    ck_assert(!accepted(quad, 4, &st));
    const vec3 seed[] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 2, 2}};
    assert_refused(seed, 4, "/vertices/3", "plane");
    const vec3 far[] = {
        {1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6 + 1, 1, 0}, {1e6, 1, 0}, {1e6 - 1, 0.5, 0.01}};
    assert_refused(far, 5, "/vertices/4", "plane");
}
END_TEST

START_TEST(test_polygon_check__h053_refuses_crossings_and_touches)
{
    const vec3 bow_tie[] = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
    assert_refused(bow_tie, 4, "/vertices/2", "meets itself");
    const vec3 vertex_on_edge[] = {{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {2, 0, 0}, {0, 2, 0}};
    struct pen_status st;
    ck_assert(!accepted(vertex_on_edge, 5, &st));
    const vec3 spike[] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {2, 1, 0}, {0, 1, 0}};
    ck_assert(!accepted(spike, 5, &st));
    const vec3 along[] = {{0, 0, 0}, {6, 0, 0}, {6, 3, 0}, {4, 0, 0}, {2, 0, 0}, {0, 3, 0}};
    ck_assert(!accepted(along, 6, &st));
}
END_TEST

/* Stars turn to the same side at every vertex, as convex outlines do. */
START_TEST(test_polygon_check__refuses_stars)
{
    struct pen_status st;
    for (int points = 3; points <= 11; points += 2)
        for (int step = 1; step <= points / 2; step++) {
            vec3 v[11];
            for (int i = 0; i < points; i++) {
                double turn = 2 * acos(-1) * (i * step % points) / points + 0.25;
                v[i] = pen_vec3(3, cos(turn), sin(turn));
            }
            ck_assert_int_eq(accepted(v, (uint32_t)points, &st), step == 1);
        }
}
END_TEST

/* A vertex off an edge by one unit in the last place either touches or does not; the sides of the
 * rounded numbers decide, at any place in space. */
START_TEST(test_polygon_check__one_ulp_decides)
{
    for (int k = -300; k <= 300; k += 60) {
        double s = ldexp(1, k), third = ldexp(1.0 / 3, k);
        vec3 v[] = {{0, 0, 0}, {s, third, 0}, {s, s, 0}, {0.5 * s, 0.5 * third, 0}, {0, s, 0}};
        struct pen_status st;
        ck_assert(!accepted(v, 5, &st));
        v[3].y = nextafter(0.5 * third, INFINITY);
        assert_accepted(v, 5);
        v[3].y = nextafter(0.5 * third, 0);
        ck_assert(!accepted(v, 5, &st));
    }
}
END_TEST

/* A vertex among the last bits around a long diagonal, where rounded differences have lost the
 * side (Kettner et al., "Classroom examples of robustness problems", 2008, figure 2). */
START_TEST(test_polygon_check__sides_are_exact)
{
    for (int i = 0; i < 32; i++)
        for (int j = 0; j < 32; j++) {
            vec3 v[] = {{-24, -24, 0}, {24, 24, 0}, {0, 30, 0}, {0, 0, 0}, {-30, 5, 0}};
            v[3] = pen_vec3(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53, 0);
            struct pen_status st;
            ck_assert_int_eq(accepted(v, 5, &st), j > i);
        }
}
END_TEST

START_TEST(test_polygon_check__tiny_far_from_the_origin)
{
    const vec3 v[] = {{1, 0, 0}, {1, 1e-170, 0}, {1, 1e-170, 1e-170}, {1, 0, 1e-170}};
    assert_accepted(v, 4);
    const vec3 crossed[] = {{1, 0, 0}, {1, 1e-170, 1e-170}, {1, 1e-170, 0}, {1, 0, 1e-170}};
    struct pen_status st;
    ck_assert(!accepted(crossed, 4, &st));
}
END_TEST

/* ---- Against every pair of edges, in integers ---- */

struct cell {
    int x, y;
};

static int side(struct cell a, struct cell b, struct cell c)
{
    int det = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    return (det > 0) - (det < 0);
}

static bool between(struct cell a, struct cell b, struct cell c)
{
    return side(a, b, c) == 0 && (c.x - a.x) * (c.x - b.x) <= 0 && (c.y - a.y) * (c.y - b.y) <= 0;
}

static bool edges_meet(struct cell a, struct cell b, struct cell c, struct cell d)
{
    if (between(a, b, c) || between(a, b, d) || between(c, d, a) || between(c, d, b))
        return true;
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

static bool simple_by_pairs(const struct cell *v, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++) {
            struct cell a = v[i], b = v[(i + 1) % n], c = v[j], d = v[(j + 1) % n];
            if (j == i + 1) { /* b == c */
                if (between(a, b, d) || between(c, d, a))
                    return false;
            } else if (i == 0 && j == n - 1) { /* d == a */
                if (between(a, b, c) || between(c, d, b))
                    return false;
            } else if (edges_meet(a, b, c, d)) {
                return false;
            }
        }
    return true;
}

static vec3 lift(struct cell c, int how)
{
    double x = c.x, y = c.y, z = how / 3 ? 0.25 * x - 0.5 * y + 3 : 7;
    return how % 3 == 0 ? pen_vec3(x, y, z) : how % 3 == 1 ? pen_vec3(z, x, y) : pen_vec3(y, z, x);
}

START_TEST(test_polygon_check__agrees_with_all_pairs)
{
    unsigned seed = 20240611;
    srand(seed);
    int simple = 0;
    for (int round = 0; round < 60000; round++) {
        int n = 3 + rand() % 8, grid = 2 + rand() % 5, how = rand() % 6;
        struct cell cells[10];
        vec3 v[10];
        for (int i = 0; i < n; i++) {
            cells[i] = (struct cell){rand() % grid, rand() % grid};
            v[i] = lift(cells[i], how);
        }
        bool want = simple_by_pairs(cells, n);
        struct pen_status st;
        bool got = accepted(v, (uint32_t)n, &st);
        ck_assert_msg(got == want, "seed %u round %d: %d, want %d (%s %s)", seed, round, got, want,
                      st.at, st.msg);
        simple += want;
    }
    ck_assert_int_gt(simple, 2000);
}
END_TEST

START_TEST(test_polygon_check__ten_thousand_vertices)
{
    enum { N = 10000 };
    static vec3 v[N];
    for (int i = 0; i < N; i++) {
        double a = 2 * 3.14159265358979323846 * i / N;
        v[i] = pen_vec3(cos(a), sin(a), cos(a));
    }
    assert_accepted(v, N);
    vec3 keep = v[N / 2];
    v[N / 2] = pen_vec3(1.5, 0.0123, 1.5);
    struct pen_status st;
    ck_assert(!accepted(v, N, &st));
    v[N / 2] = keep;
}
END_TEST

/* Teeth as long as the polygon: a grid or a list of boxes would test every pair. */
START_TEST(test_polygon_check__long_teeth_in_no_order)
{
    enum { N = 200000 };
    vec3 *v = malloc(N * sizeof *v);
    for (int i = 0; i < N; i++)
        v[i] = pen_vec3(i, i % 2 ? 1e6 + i % 7 : i % 5, 0);
    v[N - 1] = pen_vec3(N, -10, 0);
    v[0] = pen_vec3(-1, -10, 0);
    assert_accepted(v, N);
    v[N / 2].y = -11; /* through the long edge that closes the loop */
    struct pen_status st;
    ck_assert(!accepted(v, N, &st));
    free(v);
}
END_TEST

PEN_SUITE("polygon_check", test_polygon_check__accepts_simple_outlines,
          test_polygon_check__refuses_too_few_and_repeated, test_polygon_check__refuses_no_area,
          test_polygon_check__accepts_needles, test_polygon_check__h054_planar_within_a_millionth,
          test_polygon_check__h053_refuses_crossings_and_touches, test_polygon_check__refuses_stars,
          test_polygon_check__one_ulp_decides, test_polygon_check__sides_are_exact,
          test_polygon_check__tiny_far_from_the_origin, test_polygon_check__agrees_with_all_pairs,
          test_polygon_check__ten_thousand_vertices, test_polygon_check__long_teeth_in_no_order)
