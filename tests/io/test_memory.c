/* SPDX-License-Identifier: MIT */
/* Reading scenes with too little memory: each allocation fails once. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "support/alloc.h"
#include "support/suite.h"

static const char *const files[] = {
    "tests/io/corpus/good/all-objects.json",      "tests/io/corpus/good/all-lights.json",
    "tests/io/corpus/good/camera-full.json",      "tests/io/corpus/good/views.json",
    "tests/io/corpus/good/text-escapes.json",     "tests/io/corpus/xml-good/bodies.xml",
    "tests/io/corpus/xml-good/order.xml",         "tests/io/corpus/xml-good/views.xml",
    "tests/io/corpus/xml-good/classroom.xml",     "tests/io/corpus/xml-spellings/lights.xml",
    "tests/io/corpus/xml-spellings/material.xml", "tests/io/corpus/xml-spellings/points.xml",
    "tests/io/corpus/xml-spellings/ambient.xml",  "tests/io/corpus/xml-spellings/twice.xml",
    "tests/io/corpus/xml-spellings/utf16-le.xml"};

static char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    char *text = malloc(1 << 20);
    *bytes = fread(text, 1, 1 << 20, file);
    fclose(file);
    return text;
}

static bool load(const char *text, size_t bytes, size_t cap, struct pen_errors *errors)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(cap);
    struct pen_scene_desc desc;
    if (!arena)
        return false;
    bool ok = pen_scene_load(text, bytes, &limits, arena, &desc, errors);
    pen_arena_free(arena);
    return ok;
}

/* qsort works without memory, too, so a failed allocation need not be an error. */
START_TEST(test_memory__any_failed_allocation_is_reported_as_such)
{
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        size_t bytes;
        char *text = read_file(files[i], &bytes);
        bool refused = true;
        for (long n = 0; refused; n++) {
            struct pen_errors errors = {0};
            alloc_fail_after(n);
            bool ok = load(text, bytes, 0, &errors);
            refused = alloc_succeed();
            ck_assert_msg(ok || refused, "%s: %s", files[i], errors.item[0].msg);
            for (size_t e = 0; e < errors.count; e++)
                ck_assert_msg(errors.item[e].code == PEN_NO_MEMORY, "%s, allocation %ld: %s",
                              files[i], n, errors.item[e].msg);
        }
        free(text);
    }
}
END_TEST

START_TEST(test_memory__any_cap_of_the_arena_is_kept)
{
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        size_t bytes, cap = 1;
        char *text = read_file(files[i], &bytes);
        struct pen_errors errors = {0};
        for (; !load(text, bytes, cap, &errors); cap += 16) {
            ck_assert_uint_eq(errors.total, 1);
            ck_assert_int_eq(errors.item[0].code, PEN_NO_MEMORY);
            errors = (struct pen_errors){0};
        }
        ck_assert_uint_gt(cap, 256);
        free(text);
    }
}
END_TEST

/* Whichever allocation fails, the scene is refused; if none fails, with all its errors. */
static void check_refusal(const char *path, size_t errors_wanted)
{
    size_t bytes;
    char *text = read_file(path, &bytes);
    bool refused = true;
    for (long n = 0; refused; n++) {
        struct pen_errors errors = {0};
        alloc_fail_after(n);
        bool ok = load(text, bytes, 0, &errors);
        refused = alloc_succeed();
        ck_assert(!ok);
        ck_assert(refused || errors.count == errors_wanted);
    }
    free(text);
}

START_TEST(test_memory__a_bad_scene_is_refused_whatever_fails)
{
    check_refusal("tests/io/corpus/bad/several.json", 7);
    check_refusal("tests/io/corpus/xml-bad/camera-transforms.xml", 8);
    check_refusal("tests/io/corpus/xml-bad/mismatch.xml", 1);
    check_refusal("tests/io/corpus/xml-bad/plane-missing.xml", 2);
}
END_TEST

PEN_SUITE("io/memory", test_memory__any_failed_allocation_is_reported_as_such,
          test_memory__any_cap_of_the_arena_is_kept,
          test_memory__a_bad_scene_is_refused_whatever_fails)
