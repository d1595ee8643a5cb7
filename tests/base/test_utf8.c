/* SPDX-License-Identifier: MIT */
/* Text in its safe form for a terminal. */
#include <string.h>

#include "base/utf8.h"
#include "support/suite.h"

static const char *shown(const char *text)
{
    static char out[256];
    ck_assert(pen_utf8_show(out, sizeof out, text));
    return out;
}

START_TEST(test_utf8__hidden_characters_are_escaped)
{
    ck_assert_str_eq(shown("a\x1b[31mb\x07\x7f\r"), "a\\u001b[31mb\\u0007\\u007f\\u000d");
    ck_assert_str_eq(shown("one\ntwo\t"), "one\\ntwo\\u0009");
    ck_assert_str_eq(shown("\xC2\x9B"
                           "31m"),
                     "\\u009b31m"); /* CSI of C1 */
    ck_assert_str_eq(shown("x\xE2\x80\xAEgnp.exe"), "x\\u202egnp.exe");
    ck_assert_str_eq(shown("\xE2\x81\xA6\xE2\x81\xA9\xD8\x9C\xE2\x80\x8F"),
                     "\\u2066\\u2069\\u061c\\u200f");
    ck_assert_str_eq(shown("\xE2\x80\x8B\xEF\xBB\xBF\xC2\xAD\xE2\x80\xA8"),
                     "\\u200b\\ufeff\\u00ad\\u2028");
    ck_assert_str_eq(shown("\xF3\xA0\x81\x81"), "\\udb40\\udc41"); /* a tag, U+E0041 */
}
END_TEST

START_TEST(test_utf8__other_text_is_shown_as_it_is)
{
    static const char text[] = "Zimmer \xC3\xBC \xD7\x90\xD8\xA7 \xE6\x97\xA5 \xF0\x9F\x91\xA9"
                               "\xE2\x80\x8D\xF0\x9F\x92\xBB \xE0\xA4\x95\xE2\x80\x8C\"\\";
    ck_assert_str_eq(shown(text), text);
    ck_assert_str_eq(shown("\xFF\xC3 \xED\xA0\x80"), "?? ???");
}
END_TEST

START_TEST(test_utf8__text_is_cut_between_characters)
{
    char out[8];
    ck_assert(!pen_utf8_show(out, sizeof out, "12\xE2\x80\xAE"));
    ck_assert_str_eq(out, "12");
    ck_assert(pen_utf8_show(out, sizeof out, "1\xE2\x80\xAE"));
    ck_assert_str_eq(out, "1\\u202e");
    ck_assert(!pen_utf8_show(out, 1, "1"));
    ck_assert_str_eq(out, "");
}
END_TEST

START_TEST(test_utf8__characters_are_counted)
{
    ck_assert_uint_eq(pen_utf8_count(""), 0);
    ck_assert_uint_eq(pen_utf8_count("a\xC3\xBC\xE6\x97\xA5\xF0\x9F\x91\xA9"), 4);
    ck_assert_uint_eq(pen_utf8_count("\xFF\xC3"), 2);
}
END_TEST

/* Wide: U+65E5, U+1F469; a mark: U+0308; a joiner: U+200D. */
START_TEST(test_utf8__columns_of_a_terminal_are_counted)
{
    static const struct {
        const char *text;
        size_t columns;
    } cases[] = {{"", 0},
                 {"abc", 3},
                 {"\xC3\xBC", 1},
                 {"u\xCC\x88", 1},
                 {"\xE6\x97\xA5\xE6\x97\xA5", 4},
                 {"\xF0\x9F\x91\xA9\xE2\x80\x8D\xF0\x9F\x92\xBB", 4},
                 {"\xFF\xC3", 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        ck_assert_uint_eq(pen_utf8_columns(cases[i].text, strlen(cases[i].text)), cases[i].columns);
}
END_TEST

START_TEST(test_utf8__every_character_is_encoded_as_it_is_read)
{
    char out[4];
    ck_assert_uint_eq(pen_utf8_encode(0x20AC, out), 3);
    ck_assert_mem_eq(out, "\xE2\x82\xAC", 3);
    ck_assert_uint_eq(pen_utf8_encode(0x1D11E, out), 4);
    ck_assert_mem_eq(out, "\xF0\x9D\x84\x9E", 4);
    for (unsigned code = 0; code <= 0x10FFFF; code++) {
        size_t length = pen_utf8_encode(code, out);
        bool surrogate = code >= 0xD800 && code <= 0xDFFF;
        ck_assert_uint_eq(pen_utf8_char(out, length), surrogate ? 0 : length);
    }
}
END_TEST

PEN_SUITE("utf8", test_utf8__every_character_is_encoded_as_it_is_read,
          test_utf8__characters_are_counted, test_utf8__columns_of_a_terminal_are_counted,
          test_utf8__hidden_characters_are_escaped, test_utf8__other_text_is_shown_as_it_is,
          test_utf8__text_is_cut_between_characters)
