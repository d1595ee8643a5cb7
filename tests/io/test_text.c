/* SPDX-License-Identifier: MIT */
/* Names, messages and the built-in scenes. */
#include <stdio.h>
#include <string.h>

#include "io/builtin.h"
#include "io/scene_json.h"
#include "support/suite.h"

static const char *const keys[] = {"radius", "center", "look_at", "kd", "ks", "shininess", NULL};

static void expect_nearest(const char *word, const char *nearest)
{
    const char *found = pen_nearest_name(word, keys);
    ck_assert_msg(nearest ? found && strcmp(found, nearest) == 0 : !found, "%s: %s", word,
                  found ? found : "nothing");
}

START_TEST(test_text__a_misspelt_name_finds_its_neighbour)
{
    expect_nearest("radius", "radius");
    expect_nearest("raduis", "radius");  /* two letters swapped */
    expect_nearest("radus", "radius");   /* one missing */
    expect_nearest("raddius", "radius"); /* one too many */
    expect_nearest("redius", "radius");
    expect_nearest("RADIUS", "radius");
    expect_nearest("lookAt", "look_at");
    expect_nearest("look-at", "look_at");
    expect_nearest("centre", "center");
    expect_nearest("shinyness", "shininess");
}
END_TEST

START_TEST(test_text__a_word_too_far_from_all_names_finds_none)
{
    expect_nearest("diameter", NULL);
    expect_nearest("r", NULL);
    expect_nearest("kt", NULL); /* one edit of two letters is another word */
    expect_nearest("", NULL);
    expect_nearest("rodiusses", NULL); /* three edits */
    char word[4096];
    memset(word, 'a', sizeof word - 1);
    word[sizeof word - 1] = '\0';
    expect_nearest(word, NULL);
}
END_TEST

START_TEST(test_text__the_first_of_equally_near_names_wins)
{
    static const char *const names[] = {"abcdeX", "abcdeY", NULL};
    ck_assert_str_eq(pen_nearest_name("abcdeZ", names), "abcdeX");
}
END_TEST

START_TEST(test_text__an_error_is_one_line_with_its_place)
{
    struct pen_status st;
    char text[64];
    pen_fail_line(&st, PEN_SYNTAX, 3, 14, "a comma is missing");
    pen_status_describe(&st, "room.json", text, sizeof text);
    ck_assert_str_eq(text, "room.json:3:14: a comma is missing");
    pen_status_describe(&st, "", text, sizeof text);
    ck_assert_str_eq(text, "3:14: a comma is missing");
    pen_fail_at(&st, PEN_INVALID, "/objects/0", "is wrong");
    pen_status_describe(&st, "room.json", text, sizeof text);
    ck_assert_str_eq(text, "room.json: at /objects/0: is wrong");
    pen_fail(&st, PEN_NO_MEMORY, "out of memory");
    pen_status_describe(&st, NULL, text, sizeof text);
    ck_assert_str_eq(text, "out of memory");
    char small[8];
    pen_status_describe(&st, "room.json", small, sizeof small);
    ck_assert_str_eq(small, "room.js");
}
END_TEST

START_TEST(test_text__built_in_scenes_are_found_by_name_and_valid)
{
    struct pen_limits limits = pen_limits_default();
    size_t bytes;
    ck_assert_uint_ge(pen_builtin_count(), 3);
    for (size_t i = 0; i < pen_builtin_count(); i++) {
        struct pen_scene_desc desc;
        struct pen_errors errors = {0};
        struct pen_arena *arena = pen_arena_new(0);
        const char *name = pen_builtin_name(i);
        const char *text = pen_builtin_find(name, &bytes);
        ck_assert_ptr_eq(text, pen_builtin_text(i, &bytes));
        ck_assert_uint_eq(bytes, strlen(text));
        ck_assert_msg(pen_scene_load(text, bytes, &limits, arena, &desc, &errors), "%s: %s", name,
                      errors.item[0].msg);
        pen_arena_free(arena);
        ck_assert_str_eq(pen_builtin_nearest(name), name);
    }
    ck_assert_ptr_nonnull(pen_builtin_find("room", &bytes));
    ck_assert_str_eq(pen_builtin_nearest("roon"), "room");
    ck_assert_ptr_null(pen_builtin_nearest("nothing-like-it"));
    ck_assert_ptr_null(pen_builtin_find("roo", &bytes));
    ck_assert_ptr_null(pen_builtin_find("room.json", &bytes));
    ck_assert_ptr_null(pen_builtin_find("", &bytes));
}
END_TEST

PEN_SUITE("io/text", test_text__a_misspelt_name_finds_its_neighbour,
          test_text__a_word_too_far_from_all_names_finds_none,
          test_text__the_first_of_equally_near_names_wins,
          test_text__an_error_is_one_line_with_its_place,
          test_text__built_in_scenes_are_found_by_name_and_valid)
