/* SPDX-License-Identifier: MIT */
/* The classroom's boundary cases of constructing primitives, as scenes. A case that threw an
 * exception there is refused here, with the reason and the place. A case that the classroom refused
 * without need is accepted. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "scene/scene.h"
#include "support/suite.h"

static struct pen_scene_desc desc;
static struct pen_errors errors;
static struct pen_arena *arena;

static bool load(const char *text)
{
    struct pen_limits limits = pen_limits_default();
    errors = (struct pen_errors){0};
    pen_arena_free(arena);
    arena = pen_arena_new(0);
    return pen_scene_load(text, strlen(text), &limits, arena, &desc, &errors);
}

struct refusal {
    const char *text;
    int line;            /* of the error; 0: the error has a JSON Pointer */
    const char *at;      /* that pointer */
    const char *message; /* a part of the message */
};

static void assert_refused(const struct refusal *row, int rows)
{
    for (int i = 0; i < rows; i++) {
        ck_assert_msg(!load(row[i].text), "row %d is accepted", i);
        const struct pen_status *st = &errors.item[0];
        ck_assert_int_eq(st->code, row[i].line && row[i].text[0] != '<' ? PEN_SYNTAX : PEN_INVALID);
        ck_assert_int_eq(st->line, row[i].line);
        if (!row[i].line)
            ck_assert_str_eq(st->at, row[i].at);
        ck_assert_msg(strstr(st->msg, row[i].message) != NULL, "row %d: \"%s\"", i, st->msg);
    }
}

#define COUNT(rows) (int)(sizeof(rows) / sizeof((rows)[0]))
#define SCENE(inner)                                                                               \
    "{\"format\": \"penumbra-scene/1\",\n"                                                         \
    " \"camera\": {\"position\": [0, 0, 5], \"look_at\": [0, 0, 0]},\n"                            \
    " \"objects\": [" inner "]}"
#define PLANE(points) "<scene>\n<geometries>\n<plane " points "/></geometries></scene>"
#define POLYGON(vertices) SCENE("{\"type\": \"polygon\", \"vertices\": [" vertices "]}")

START_TEST(test_boundary__h002_planes_through_repeated_points)
{
    static const struct refusal rows[] = {
        {PLANE("p0='1 2 3' p1='1 2 3' p2='0 1 0'"), 3, "", "one line"},
        {PLANE("p0='1 2 3' p1='0 1 0' p2='1 2 3'"), 3, "", "one line"},
        {PLANE("p0='0 1 0' p1='1 2 3' p2='1 2 3'"), 3, "", "one line"},
        {PLANE("p0='1 1 1' p1='1 1 1' p2='1 1 1'"), 3, "", "one line"},
    };
    assert_refused(rows, COUNT(rows));
}
END_TEST

START_TEST(test_boundary__h003_planes_through_points_on_a_line)
{
    static const struct refusal rows[] = {
        {PLANE("p0='0 0 0' p1='1 1 1' p2='2 2 2'"), 3, "", "one line"},
        {PLANE("p0='0 0 0' p1='0.1 0.2 0.3' p2='0.2 0.4 0.6'"), 3, "", "one line"},
    };
    assert_refused(rows, COUNT(rows));
}
END_TEST

START_TEST(test_boundary__h027_polygons)
{
    static const struct refusal rows[] = {
        {POLYGON("[0, 0, 1], [0, 1, 0], [1, 0, 0], [-1, 1, 1]"), 0, "/objects/0/vertices/2",
         "meets itself"}, /* another order of the quad below */
        {POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 2, 2]"), 0, "/objects/0/vertices/3",
         "plane"},
    };
    assert_refused(rows, COUNT(rows));
    ck_assert(load(POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 1, 1]")));
    ck_assert(load(POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [0.5, 0.25, 0.25]"))); /* concave */
}
END_TEST

/* A loop that repeats a vertex is refused, unless it is the first or the last one at its end; one
 * with a vertex on a side is accepted. */
START_TEST(test_boundary__h028_polygons)
{
    static const struct refusal rows[] = {
        {POLYGON("[0, 0, 1], [0, 0, 1], [1, 0, 0], [0, 1, 0]"), 0, "/objects/0/vertices/1",
         "repeats vertex 0"},
        {POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [1, 0, 0]"), 0, "/objects/0/vertices/3",
         "repeats vertex 1"},
    };
    assert_refused(rows, COUNT(rows));
    ck_assert(load(POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]")));
    ck_assert(load(POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 1, 0]")));
    ck_assert(load(POLYGON("[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0.5, 0.5]")));
}
END_TEST

START_TEST(test_boundary__h035_directions_of_length_zero)
{
    static const struct refusal rows[] = {
        {SCENE("{\"type\": \"plane\", \"point\": [0, 0, 0], \"normal\": [0, 0, 0]}"), 0,
         "/objects/0/normal", "length greater than 0"},
        {SCENE("{\"type\": \"tube\", \"origin\": [0, 0, 0], \"axis\": [0, -0.0, 0], "
               "\"radius\": 1}"),
         0, "/objects/0/axis", "length greater than 0"},
        {SCENE("{\"type\": \"cylinder\", \"base\": [0, 0, 0], \"axis\": [0, 0, 0], "
               "\"radius\": 1, \"height\": 1}"),
         0, "/objects/0/axis", "length greater than 0"},
        {SCENE("], \"lights\": [{\"type\": \"directional\", \"direction\": [0, 0, 0], "
               "\"intensity\": [1, 1, 1]}"),
         0, "/lights/0/direction", "length greater than 0"},
        {SCENE("{\"type\": \"group\", \"transform\": {\"scale\": 0}, \"objects\": []}"), 0,
         "/objects/0/transform/scale", "0"},
    };
    assert_refused(rows, COUNT(rows));
}
END_TEST

/* NaN, infinity and overflowing numbers are refused, with the line. */
START_TEST(test_boundary__h089_no_numbers)
{
    static const struct refusal rows[] = {
        {SCENE("{\"type\": \"sphere\", \"center\": [NaN, 0, 0], \"radius\": 1}"), 3, "", "NaN"},
        {SCENE("{\"type\": \"sphere\", \"center\": [nan, 0, 0], \"radius\": 1}"), 3, "", "nan"},
        {SCENE("{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": Infinity}"), 3, "",
         "Infinity"},
        {SCENE("{\"type\": \"sphere\", \"center\": [0, inf, 0], \"radius\": 1}"), 3, "", "inf"},
        {SCENE("{\"type\": \"sphere\", \"center\": [0, 0, 1e400], \"radius\": 1}"), 3, "",
         "too large"},
        {SCENE("{\"type\": \"sphere\", \"center\": [0, 0, -1e400], \"radius\": 1}"), 3, "",
         "too large"},
        {PLANE("point='nan 0 0' normal='0 0 1'"), 3, "", "nan"},
        {PLANE("point='0 inf 0' normal='0 0 1'"), 3, "", "inf"},
        {PLANE("point='0 0 1e400' normal='0 0 1'"), 3, "", "1e400"},
        {PLANE("point='0 0 0' normal='0 0 NaN'"), 3, "", "NaN"},
    };
    assert_refused(rows, COUNT(rows));
}
END_TEST

PEN_SUITE("boundary", test_boundary__h002_planes_through_repeated_points,
          test_boundary__h003_planes_through_points_on_a_line, test_boundary__h027_polygons,
          test_boundary__h028_polygons, test_boundary__h035_directions_of_length_zero,
          test_boundary__h089_no_numbers)
