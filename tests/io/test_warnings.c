/* SPDX-License-Identifier: MIT */
/* Counts of T-junctions, and where the search for warnings ends. The corpus tests the others. */
#include <stdio.h>
#include <string.h>

#include "base/buf.h"
#include "io/scene_json.h"
#include "support/suite.h"

static const char head[] =
    "{\"format\": \"penumbra-scene/1\", \"ambient\": [1, 1, 1],"
    " \"camera\": {\"position\": [0, 0, 5], \"look_at\": [0, 0, 0]},"
    " \"objects\": [{\"type\": \"group\", \"transform\": {\"rotate\": {\"axis\": [3, 5, 7],"
    " \"degrees\": 20}}, \"objects\": [";

/* The warnings about a document, whose text is released. */
static struct pen_errors warnings_of_text(struct pen_buf *text)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    struct pen_errors errors = {0}, warnings = {0};
    struct pen_status st;
    ck_assert(!text->failed);
    json_t *document = pen_json_parse((const char *)text->data, text->bytes, &limits, &st);
    ck_assert(pen_scene_read(document, "/scene", &limits, arena, &desc, &errors));
    pen_scene_warnings(document, "/scene", &desc, &warnings);
    json_decref(document);
    pen_buf_release(text);
    pen_arena_free(arena);
    return warnings;
}

/* The warnings about a rectangle above the x axis, from 0 to `count`, and `count` triangles below
 * it, each of which shares one vertex with the next. `split` gives the rectangle their vertices,
 * too. All is rotated, so that most points inside an edge are on it except for rounding. */
static struct pen_errors warnings_of(int count, bool split)
{
    struct pen_buf text = {0};
    pen_buf_puts(&text, head);
    pen_buf_puts(&text, "{\"type\": \"polygon\", \"vertices\": [[0.1, 0, 0]");
    for (int i = 1; split && i < count; i++)
        pen_buf_printf(&text, ", [%d.1, 0, 0]", i);
    pen_buf_printf(&text, ", [%d.1, 0, 0], [%d, 1, 0], [0, 1, 0]]}", count, count);
    for (int i = 0; i < count; i++)
        pen_buf_printf(&text,
                       ", {\"type\": \"triangle\", \"vertices\": [[%d.1, 0, 0], [%d, -1, 0], "
                       "[%d.1, 0, 0]]}",
                       i, i, i + 1);
    pen_buf_puts(&text, "]}]}");
    return warnings_of_text(&text);
}

/* Whether warning number `from_end`, the last one being 0, is about the whole scene and says this.
 */
static bool ends_with(const struct pen_errors *warnings, size_t from_end, const char *text)
{
    if (warnings->count <= from_end)
        return false;
    const struct pen_status *st = &warnings->item[warnings->count - 1 - from_end];
    return strcmp(st->at, "/scene") == 0 && strstr(st->msg, text);
}

START_TEST(test_warnings__h051_every_vertex_inside_an_edge_is_found)
{
    /* Two triangles meet at each vertex inside. A few vertices are on the edge exactly, which is
     * not reported. */
    static const int counts[] = {3, 10, 1000, 6000};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        size_t inside = 2 * (size_t)(counts[i] - 1);
        struct pen_errors found = warnings_of(counts[i], false);
        ck_assert_msg(found.total <= inside && 10 * found.total >= 8 * inside, "%zu of %zu",
                      found.total, inside);
        ck_assert_uint_eq(found.count, found.total < PEN_ERRORS_MAX ? found.total : PEN_ERRORS_MAX);
        ck_assert_int_eq(found.item[0].code, PEN_OK);
        ck_assert_ptr_nonnull(strstr(found.item[0].at, "/scene/objects/0/objects/"));
        ck_assert_ptr_nonnull(strstr(found.item[0].msg, "/scene/objects/0/objects/0,"));
        ck_assert(!ends_with(&found, 0, ""));
    }
}
END_TEST

START_TEST(test_warnings__shared_vertices_are_not_t_junctions)
{
    ck_assert_uint_eq(warnings_of(2, true).total, 0);
    ck_assert_uint_eq(warnings_of(1000, true).total, 0);
}
END_TEST

START_TEST(test_warnings__large_scenes_are_not_searched_for_t_junctions)
{
    struct pen_errors found = warnings_of(6665, false); /* 19 999 edges */
    ck_assert_uint_gt(found.total, 1);
    ck_assert(!ends_with(&found, 0, ""));
    found = warnings_of(6666, false); /* 20 002 */
    ck_assert_uint_eq(found.total, 1);
    ck_assert(ends_with(&found, 0, "T-junctions"));
}
END_TEST

/* Triangles along one line, so that every edge meets all corners. After many it is told that they
 * are too many, in the place of other warnings. */
START_TEST(test_warnings__the_search_for_t_junctions_ends)
{
    static const int counts[] = {100, 2500};
    for (int i = 0; i < 2; i++) {
        struct pen_buf text = {0};
        pen_buf_puts(&text, head);
        for (int k = 0; k < counts[i]; k++)
            pen_buf_printf(&text,
                           "%s{\"type\": \"triangle\", \"vertices\": [[0, %d.1e-12, 0], [1, "
                           "%d.3e-12, 0], [0, 0, %d.7e-12]]}",
                           k ? ", " : "", k % 97 + 1, k, k + 1);
        pen_buf_puts(&text, "]}]}");
        const struct pen_errors found = warnings_of_text(&text);
        ck_assert_uint_le(found.count, PEN_ERRORS_MAX);
        ck_assert_int_eq(ends_with(&found, 0, "T-junctions"), i == 1);
    }
}
END_TEST

/* Where many views look at many primitives, no view is measured. */
START_TEST(test_warnings__measuring_views_ends)
{
    static const int counts[] = {100, 33000};
    for (int i = 0; i < 2; i++) {
        struct pen_buf text = {0};
        pen_buf_puts(&text,
                     "{\"format\": \"penumbra-scene/1\", \"ambient\": [1, 1, 1], \"camera\": "
                     "{\"position\": [0, 0, 5], \"look_at\": [0, 0, 0]}, \"views\": [");
        for (int k = 0; k < 64; k++)
            pen_buf_printf(&text, "%s{\"name\": \"v%d\"}", k ? ", " : "", k);
        pen_buf_puts(&text, "], \"objects\": [");
        for (int k = 0; k < counts[i]; k++)
            pen_buf_printf(&text,
                           "%s{\"type\": \"triangle\", \"vertices\": [[%d, 0, 0], [%d.5, 0, 0], "
                           "[%d, 1, 0]]}",
                           k ? ", " : "", k, k, k);
        pen_buf_puts(&text, "]}");
        const struct pen_errors found = warnings_of_text(&text);
        ck_assert_uint_eq(found.total, i == 1 ? 2 : 0);
        ck_assert_int_eq(ends_with(&found, 1, "precision"), i == 1);
        ck_assert_int_eq(ends_with(&found, 0, "T-junctions"), i == 1);
    }
}
END_TEST

PEN_SUITE("io/warnings", test_warnings__h051_every_vertex_inside_an_edge_is_found,
          test_warnings__shared_vertices_are_not_t_junctions,
          test_warnings__large_scenes_are_not_searched_for_t_junctions,
          test_warnings__the_search_for_t_junctions_ends, test_warnings__measuring_views_ends)
