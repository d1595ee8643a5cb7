/* SPDX-License-Identifier: MIT */
/* What the parser of JSON checks: length, nesting, numbers, memory. The corpus tests the messages
 * of syntax errors. */
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "support/suite.h"

static json_t *parse(const char *text, size_t bytes, struct pen_status *st)
{
    struct pen_limits limits = pen_limits_default();
    return pen_json_parse(text, bytes, &limits, st);
}

/* `depth` brackets inside each other. */
static char *nest(int depth)
{
    char *text = malloc((size_t)depth * 2 + 1);
    memset(text, '[', (size_t)depth);
    memset(text + depth, ']', (size_t)depth);
    text[2 * depth] = '\0';
    return text;
}

START_TEST(test_json_parse__nesting_of_64_is_the_most)
{
    struct pen_status st;
    for (int depth = 63; depth <= 66; depth++) {
        char *text = nest(depth);
        json_t *document = parse(text, strlen(text), &st);
        ck_assert_msg((document != NULL) == (depth <= 64), "depth %d", depth);
        if (!document)
            ck_assert_int_eq(st.code, PEN_INVALID);
        json_decref(document);
        free(text);
    }
}
END_TEST

START_TEST(test_json_parse__brackets_in_strings_do_not_nest)
{
    struct pen_status st;
    char text[400] = "[\"\\\"", *end = text + strlen(text);
    memset(end, '[', 200);
    strcpy(end + 200, "\\\\\"]");
    json_t *document = parse(text, strlen(text), &st);
    ck_assert_ptr_nonnull(document);
    json_decref(document);
}
END_TEST

START_TEST(test_json_parse__a_million_brackets_are_refused_quickly)
{
    struct pen_status st;
    char *text = nest(1000000);
    ck_assert_ptr_null(parse(text, strlen(text), &st));
    ck_assert_int_eq(st.code, PEN_INVALID);
    free(text);
}
END_TEST

START_TEST(test_json_parse__one_byte_over_the_limit_is_too_large)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    ck_assert_uint_eq(limits.body_bytes, 16777216);
    limits.body_bytes = 4;
    json_t *document = pen_json_parse("[ 1]x", 4, &limits, &st);
    ck_assert_ptr_nonnull(document);
    json_decref(document);
    ck_assert_ptr_null(pen_json_parse("[ 1] ", 5, &limits, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.msg, "the document has 5 bytes, at most 4 are allowed");
}
END_TEST

/* An array that repeats an element, which ends with a comma, up to `bytes`. The digits 1, 2 and 3
 * in it become different numbers in each, because equal values would be made but once. */
static char *repeated(const char *element, size_t bytes, size_t *length)
{
    enum { ROOM = 64 };
    char *text = malloc(bytes + 1);
    int number = 0;
    ck_assert_ptr_nonnull(text);
    text[0] = '[';
    for (*length = 1; *length + ROOM < bytes;)
        for (const char *c = element; *c; c++)
            *length += (size_t)sprintf(text + *length, *c >= '1' && *c <= '3' ? "%d" : "%c",
                                       *c >= '1' && *c <= '3' ? number++ : *c);
    text[*length - 1] = ']'; /* instead of the last comma */
    return text;
}

/* The memory in use, as malloc reports it. */
static size_t in_use(void)
{
    struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

START_TEST(test_json_parse__values_that_take_too_much_memory_are_too_large)
{
    static const char *const elements[] = {"{},", "[],", "1,", "\"1\",", "{\"a\":1},", "[1,2,3],"};
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    limits.parsed_bytes = 8000000;
    for (size_t i = 0; i < sizeof elements / sizeof elements[0]; i++) {
        size_t length, before, taken;
        char *small = repeated(elements[i], 50000, &length);
        before = in_use();
        json_t *document = pen_json_parse(small, length, &limits, &st);
        taken = in_use() - before;
        ck_assert_msg(document != NULL, "%s: %s", elements[i], st.msg);
        json_decref(document);
        free(taken ? NULL : small);
        if (taken == 0) /* a sanitizer's malloc reports nothing */
            continue;
        /* The estimate is near the memory really taken: two thirds of it are not enough, three
         * halves are. */
        limits.parsed_bytes = taken * 2 / 3;
        ck_assert_msg(!pen_json_parse(small, length, &limits, &st), "%s took %zu", elements[i],
                      taken);
        ck_assert_int_eq(st.code, PEN_TOO_LARGE);
        limits.parsed_bytes = taken * 3 / 2;
        document = pen_json_parse(small, length, &limits, &st);
        ck_assert_msg(document != NULL, "%s took %zu", elements[i], taken);
        json_decref(document);
        limits.parsed_bytes = 8000000;
        free(small);
    }
    size_t length;
    char *large = repeated("{},", 2000000, &length);
    ck_assert_ptr_null(pen_json_parse(large, length, &limits, &st));
    ck_assert_int_eq(st.code, PEN_TOO_LARGE);
    ck_assert_str_eq(st.msg, "the document's values take more than 8000000 bytes of memory, which "
                             "is what is allowed");
    free(large);
}
END_TEST

START_TEST(test_json_parse__integers_stay_exact_up_to_64_bits_and_become_reals_beyond)
{
    struct pen_status st;
    const char *exact = "[9007199254740993, 9223372036854775807, -9223372036854775808]";
    json_t *document = parse(exact, strlen(exact), &st);
    ck_assert_int_eq(json_integer_value(json_array_get(document, 0)), INT64_C(9007199254740993));
    ck_assert_int_eq(json_integer_value(json_array_get(document, 1)), INT64_MAX);
    ck_assert_int_eq(json_integer_value(json_array_get(document, 2)), INT64_MIN);
    json_decref(document);
    const char *longer = "[9223372036854775808, -100000000000000000000]";
    document = parse(longer, strlen(longer), &st);
    ck_assert_double_eq(json_number_value(json_array_get(document, 0)), 0x1p63);
    ck_assert_double_eq(json_number_value(json_array_get(document, 1)), -1e20);
    json_decref(document);
}
END_TEST

START_TEST(test_json_parse__text_need_not_end_with_a_zero)
{
    struct pen_status st;
    char *text = malloc(7);
    memcpy(text, "{\"a\":1}", 7);
    json_t *document = parse(text, 7, &st);
    ck_assert_int_eq(json_integer_value(json_object_get(document, "a")), 1);
    json_decref(document);
    ck_assert_ptr_null(parse(text, 6, &st));
    ck_assert_int_eq(st.code, PEN_SYNTAX);
    ck_assert_int_eq(st.line, 1);
    ck_assert_int_eq(st.column, 7);
    free(text);
}
END_TEST

/* The allocations that succeed before one fails. Each test is a process of its own. */
static long allowed;
static void *failing_malloc(size_t bytes)
{
    return allowed-- > 0 ? malloc(bytes) : NULL;
}

START_TEST(test_json_parse__any_failed_allocation_is_an_error)
{
    static const char text[] = "{\"a\": [1, 2.5, \"three\", {\"b\": null, \"c\": [[], {}]}], "
                               "\"n\": 123456789012345678901234567890}";
    struct pen_status st;
    long needed = 0;
    json_set_alloc_funcs(failing_malloc, free);
    for (bool failed = true; failed; needed++) {
        allowed = needed;
        json_t *document = parse(text, sizeof text - 1, &st);
        failed = document == NULL;
        if (failed)
            ck_assert_msg(st.code == PEN_NO_MEMORY, "allocation %ld: %s", needed, st.msg);
        allowed = 1 << 20;
        json_decref(document);
    }
    ck_assert_int_gt(needed, 20);
}
END_TEST

START_TEST(test_json_parse__a_byte_order_mark_in_front_has_no_width)
{
    static const char marked[] = "\xEF\xBB\xBF[1]", wrong[] = "\xEF\xBB\xBF[1,\n x]",
                      twice[] = "\xEF\xBB\xBF\xEF\xBB\xBF[1]", alone[] = "\xEF\xBB\xBF";
    struct pen_status st;
    json_t *document = parse(marked, strlen(marked), &st);
    ck_assert_msg(json_is_array(document), "%s", st.msg);
    json_decref(document);
    ck_assert_ptr_null(parse(wrong, strlen(wrong), &st));
    ck_assert(st.line == 2 && st.column == 2);
    ck_assert_ptr_null(parse(twice, strlen(twice), &st));
    ck_assert_msg(strstr(st.msg, "byte order mark") != NULL, "%s", st.msg);
    ck_assert_ptr_null(parse(alone, strlen(alone), &st));
    ck_assert_msg(strstr(st.msg, "empty") != NULL, "%s", st.msg);
}
END_TEST

PEN_SUITE("io/json_parse", test_json_parse__a_byte_order_mark_in_front_has_no_width,
          test_json_parse__nesting_of_64_is_the_most,
          test_json_parse__brackets_in_strings_do_not_nest,
          test_json_parse__a_million_brackets_are_refused_quickly,
          test_json_parse__one_byte_over_the_limit_is_too_large,
          test_json_parse__values_that_take_too_much_memory_are_too_large,
          test_json_parse__integers_stay_exact_up_to_64_bits_and_become_reals_beyond,
          test_json_parse__text_need_not_end_with_a_zero,
          test_json_parse__any_failed_allocation_is_an_error)
