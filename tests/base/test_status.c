/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "base/status.h"
#include "base/utf8.h"
#include "support/suite.h"

START_TEST(test_status__codes_map_to_http_and_exit_codes)
{
    const struct {
        enum pen_code code;
        int http, exit;
    } rows[] = {
        {PEN_OK, 200, 0},
        {PEN_USAGE, 400, 2},
        {PEN_SYNTAX, 400, 3},
        {PEN_INVALID, 422, 3},
        {PEN_UNSUPPORTED, 422, 3},
        {PEN_TOO_LARGE, 413, 3},
        {PEN_UNAUTHORIZED, 401, 11},
        {PEN_FORBIDDEN, 403, 11},
        {PEN_NOT_FOUND, 404, 4},
        {PEN_GONE, 410, 4},
        {PEN_METHOD, 405, 2},
        {PEN_CONFLICT, 409, 4},
        {PEN_LENGTH, 411, 3},
        {PEN_MEDIA_TYPE, 415, 3},
        {PEN_QUOTA, 429, 5},
        {PEN_UNAVAILABLE, 503, 5},
        {PEN_STORAGE_FULL, 507, 8},
        {PEN_STORAGE, 503, 8},
        {PEN_NETWORK, 502, 5},
        {PEN_NO_MEMORY, 503, 9},
        {PEN_DIFFERENT, 409, 7},
        {PEN_INTERNAL, 500, 70},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ck_assert_int_eq(pen_code_http(rows[i].code), rows[i].http);
        ck_assert_int_eq(pen_code_exit(rows[i].code), rows[i].exit);
    }
}
END_TEST

START_TEST(test_status__every_code_has_a_unique_name)
{
    for (int i = 0; i < PEN_CODE_COUNT; i++) {
        const char *name = pen_code_name((enum pen_code)i);
        ck_assert_ptr_nonnull(name);
        ck_assert_int_eq((int)pen_code_of_name(name), i);
        ck_assert_uint_eq(strspn(name, "abcdefghijklmnopqrstuvwxyz-"), strlen(name));
        ck_assert_uint_gt(strlen(pen_code_title((enum pen_code)i)), 0);
        ck_assert_int_ge(pen_code_http((enum pen_code)i), 200);
        ck_assert(i == PEN_OK || pen_code_exit((enum pen_code)i) > 1);
    }
    ck_assert_int_eq((int)pen_code_of_name("no such name"), PEN_INTERNAL);
    ck_assert_str_eq(pen_code_name((enum pen_code) - 1), "internal");
    ck_assert_str_eq(pen_code_name(PEN_CODE_COUNT), "internal");
}
END_TEST

START_TEST(test_status__fail_fills_every_field)
{
    struct pen_status st = {PEN_OK, 3, 4, "/old", "old"};
    ck_assert(!pen_fail(&st, PEN_IO, "cannot read %s: %d", "x", 5));
    ck_assert(st.code == PEN_IO && st.line == 0 && st.column == 0);
    ck_assert_str_eq(st.at, "");
    ck_assert_str_eq(st.msg, "cannot read x: 5");
    ck_assert(!pen_fail_line(&st, PEN_SYNTAX, 7, 9, "bad"));
    ck_assert(st.code == PEN_SYNTAX && st.line == 7 && st.column == 9);
    ck_assert(!pen_fail_at(&st, PEN_INVALID, "/a/b", "bad %c", 'x'));
    ck_assert(st.line == 0 && st.column == 0);
    ck_assert_str_eq(st.at, "/a/b");
    ck_assert_str_eq(st.msg, "bad x");
}
END_TEST

START_TEST(test_status__arguments_may_come_from_the_status_itself)
{
    struct pen_status st = {PEN_OK, 0, 0, "/here", "inner"};
    pen_fail_at(&st, PEN_INVALID, st.at, "outer: %s (%s)", st.msg, st.at);
    ck_assert_str_eq(st.at, "/here");
    ck_assert_str_eq(st.msg, "outer: inner (/here)");
}
END_TEST

static void check_valid(const char *text)
{
    for (size_t length; *text; text += length) {
        length = pen_utf8_char(text, strlen(text));
        ck_assert_uint_gt(length, 0);
    }
}

START_TEST(test_status__long_text_is_cut_between_characters)
{
    struct pen_status st;
    for (int shift = 0; shift < 4; shift++) {
        char text[1200] = "";
        memset(text, 'a', (size_t)shift);
        while (strlen(text) < 1100)
            strcat(text, "\xF0\x9F\x8E\xA8"); /* a palette, four bytes */
        pen_fail_at(&st, PEN_INVALID, text, "%s", text);
        check_valid(st.msg);
        check_valid(st.at);
        ck_assert_uint_ge(strlen(st.msg), PEN_MSG_BYTES - 4);
        ck_assert_uint_ge(strlen(st.at), PEN_AT_BYTES - 4 - 3);
        ck_assert_str_eq(st.at + strlen(st.at) - 3, "\xE2\x80\xA6");
    }
}
END_TEST

START_TEST(test_status__a_pointer_that_just_fits_is_whole)
{
    char text[PEN_AT_BYTES + 1];
    struct pen_status st;
    memset(text, 'p', sizeof text);
    text[PEN_AT_BYTES - 1] = '\0';
    pen_fail_at(&st, PEN_INVALID, text, "x");
    ck_assert_str_eq(st.at, text);
    text[PEN_AT_BYTES - 1] = 'p';
    text[PEN_AT_BYTES] = '\0';
    pen_fail_at(&st, PEN_INVALID, text, "x");
    ck_assert_uint_eq(strlen(st.at), PEN_AT_BYTES - 1);
    ck_assert_str_eq(st.at + strlen(st.at) - 3, "\xE2\x80\xA6");
}
END_TEST

START_TEST(test_status__invalid_bytes_become_question_marks)
{
    struct pen_status st;
    pen_fail(&st, PEN_INVALID, "a%sb", "\xFF\xC0\x80\xED\xA0\x80\xC3");
    ck_assert_str_eq(st.msg, "a???????b");
}
END_TEST

START_TEST(test_status__all_errors_are_counted)
{
    struct pen_errors list = {0};
    struct pen_status st;
    for (int i = 0; i < 50; i++) {
        pen_fail(&st, PEN_INVALID, "error %d", i);
        pen_errors_add(&list, &st);
    }
    ck_assert_uint_eq(list.count, PEN_ERRORS_MAX);
    ck_assert_uint_eq(list.total, 50);
    ck_assert_str_eq(list.item[0].msg, "error 0");
    ck_assert_str_eq(list.item[PEN_ERRORS_MAX - 1].msg, "error 19");
}
END_TEST

START_TEST(test_utf8__valid_characters_are_those_of_the_standard)
{
    const struct {
        const char *text;
        size_t length;
    } rows[] = {{"a", 1},
                {"\xC2\x80", 2},
                {"\xDF\xBF", 2},
                {"\xE0\xA0\x80", 3},
                {"\xED\x9F\xBF", 3},
                {"\xEE\x80\x80", 3},
                {"\xF0\x90\x80\x80", 4},
                {"\xF4\x8F\xBF\xBF", 4},
                {"\x80", 0},
                {"\xC1\xBF", 0},         /* not the shortest */
                {"\xE0\x9F\xBF", 0},     /* not the shortest */
                {"\xF0\x8F\xBF\xBF", 0}, /* not the shortest */
                {"\xED\xA0\x80", 0},     /* a surrogate */
                {"\xF4\x90\x80\x80", 0}, /* beyond U+10FFFF */
                {"\xF5\x80\x80\x80", 0},
                {"\xC3", 0},
                {"\xE2\x80", 0},
                {"\xE2\x80z", 0},
                {"\xF0\x9F\x8E", 0}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        ck_assert_uint_eq(pen_utf8_char(rows[i].text, strlen(rows[i].text)), rows[i].length);
    ck_assert_uint_eq(pen_utf8_char("", 0), 0);
    ck_assert_uint_eq(pen_utf8_char("", 1), 1);
}
END_TEST

START_TEST(test_utf8__copy_tells_whether_all_fitted)
{
    char out[4];
    ck_assert(pen_utf8_copy(out, sizeof out, "abc"));
    ck_assert_str_eq(out, "abc");
    ck_assert(!pen_utf8_copy(out, sizeof out, "abcd"));
    ck_assert_str_eq(out, "abc");
    ck_assert(!pen_utf8_copy(out, sizeof out, "ab\xC3\xA9"));
    ck_assert_str_eq(out, "ab");
    ck_assert(pen_utf8_copy(out, 1, ""));
    ck_assert(!pen_utf8_copy(out, 1, "a"));
    ck_assert_str_eq(out, "");
}
END_TEST

PEN_SUITE("status", test_status__codes_map_to_http_and_exit_codes,
          test_status__every_code_has_a_unique_name, test_status__fail_fills_every_field,
          test_status__arguments_may_come_from_the_status_itself,
          test_status__long_text_is_cut_between_characters,
          test_status__a_pointer_that_just_fits_is_whole,
          test_status__invalid_bytes_become_question_marks, test_status__all_errors_are_counted,
          test_utf8__valid_characters_are_those_of_the_standard,
          test_utf8__copy_tells_whether_all_fitted)
