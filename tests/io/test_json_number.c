/* SPDX-License-Identifier: MIT */
/* Numbers: the doubles are those of strtod, to the bit, and equal texts give one value. */
#include <fenv.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "support/suite.h"

static json_t *parse(const char *text)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    return pen_json_parse(text, strlen(text), &limits, &st);
}

/* Compares a number, not an integer, with strtod. */
static void check(const char *text)
{
    double expected = strtod(text, NULL), found;
    json_t *value = parse(text);
    if (!isfinite(expected)) {
        ck_assert_msg(!value, "%s", text);
        return;
    }
    ck_assert_msg(json_is_real(value), "%s", text);
    found = json_real_value(value);
    ck_assert_msg(memcmp(&found, &expected, sizeof found) == 0, "%s: %a, expected %a", text, found,
                  expected);
    json_decref(value);
}

static uint64_t state = 1;

/* A random number below n, or of 64 bits if n is 0 (Steele, Lea, Flood, "Fast splittable
 * pseudorandom number generators", OOPSLA 2014). */
static uint64_t random_below(uint64_t n)
{
    uint64_t z = state += UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return n ? z % n : z;
}

/* Up to 21 random digits, a point somewhere among them, and often an exponent. */
static void check_random_digits(void)
{
    char text[64];
    size_t length = 0, digits = 1 + random_below(21), point = 1 + random_below(digits);
    if (random_below(2))
        text[length++] = '-';
    for (size_t i = 0; i < digits; i++) {
        if (i == point)
            text[length++] = '.';
        int first = i == 0 && point > 1; /* not 0 before other digits */
        text[length++] = (char)('0' + first + (int)random_below(first ? 9 : 10));
    }
    int exponent = (int)random_below(random_below(4) ? 60 : 700);
    if (point == digits || random_below(2))
        sprintf(text + length, "%c%d", random_below(2) ? 'e' : 'E',
                random_below(2) ? exponent : -exponent);
    else
        text[length] = '\0';
    check(text);
}

/* A random double in 17 digits, as most programs write them, which read back as the same. */
static void check_random_double(void)
{
    char text[64];
    double value = (double)random_below(0) * ldexp(1, (int)random_below(200) - 164);
    snprintf(text, sizeof text, random_below(2) ? "%.17e" : "%.16e", value);
    check(text);
    check(snprintf(text, sizeof text, "%.17f", value * 0x1p-20) > 0 ? text : "0.0");
}

/* The middle between two doubles, exactly, and its neighbours in the last place written. */
static void check_random_tie(void)
{
    char text[64];
    uint64_t odd = (UINT64_C(1) << 53) + 2 * random_below(UINT64_C(1) << 52) + 1;
    int places = (int)random_below(6); /* odd / 2^places has so many decimal places */
    uint64_t five = 1;
    for (int i = 0; i < places; i++)
        five *= 5;
    for (int step = -1; step <= 1; step++) {
        snprintf(text, sizeof text, "%llue-%d", (unsigned long long)(odd * five + (uint64_t)step),
                 places);
        check(text);
    }
}

START_TEST(test_json_number__doubles_are_those_of_strtod)
{
    static const char *const texts[] = {"0.0",
                                        "-0.0",
                                        "0e0",
                                        "-0e-400",
                                        "0.1",
                                        "1e22",
                                        "1e23",
                                        "9007199254740993.0",
                                        "9007199254740991e27",
                                        "7450580596923828125e-27",
                                        "18446744073709551615e-27",
                                        "18446744073709551609e-1",
                                        "18446744073709551610e-1",
                                        "18446744073709551616e-1",
                                        "1e-27",
                                        "1e-28",
                                        "1e27",
                                        "1e28",
                                        "2e19",
                                        "1.7976931348623157e308",
                                        "1.7976931348623159e308",
                                        "4.9406564584124654e-324",
                                        "2.4703282292062327e-324",
                                        "2.2250738585072011e-308",
                                        "1e-1000",
                                        "1e1000",
                                        "1e99999999999999999999",
                                        "1e-99999999999999999999",
                                        "0.00000000000000000000000000000000000001e38",
                                        "0.5000000000000000000000000000000000001",
                                        "100000000000000000000000000000000000000.0e-38"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        check(texts[i]);
    for (int i = 0; i < 100000; i++) {
        check_random_digits();
        check_random_double();
        check_random_tie();
    }
}
END_TEST

/* "0.", `zeros` zeros, "1e", and an exponent that makes it 1 again. */
START_TEST(test_json_number__long_numbers_are_those_of_strtod)
{
    static char text[20100];
    for (size_t zeros = 900; zeros < 20000; zeros += zeros < 1100 ? 1 : 4999) {
        memset(text, '0', sizeof text);
        text[1] = '.';
        sprintf(text + 2 + zeros, "1e%zu", zeros + 1);
        check(text);
    }
}
END_TEST

/* A program that embeds the library may round in another direction. */
START_TEST(test_json_number__rounding_modes_change_no_number)
{
    static const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO, FE_TONEAREST};
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        fesetround(modes[i]);
        json_t *list = parse("[0.1, -0.28867513459481287, 1.2345678901234567e20]");
        fesetround(FE_TONEAREST);
        ck_assert_double_eq(json_real_value(json_array_get(list, 0)), 0x1.999999999999ap-4);
        ck_assert_double_eq(json_real_value(json_array_get(list, 1)), -0x1.279a74590331cp-2);
        ck_assert_double_eq(json_real_value(json_array_get(list, 2)), 0x1.ac53a7e04bcd9p66);
        json_decref(list);
    }
}
END_TEST

START_TEST(test_json_number__equal_numbers_are_one_value)
{
    json_t *list = parse("[2, 0.5, 2, 5e-1, 2.0, -0.0, 0.0, 4611686018427387904]");
    ck_assert_ptr_eq(json_array_get(list, 0), json_array_get(list, 2));
    ck_assert_ptr_eq(json_array_get(list, 1), json_array_get(list, 3));
    ck_assert(json_is_integer(json_array_get(list, 0)) && json_is_real(json_array_get(list, 4)));
    ck_assert(signbit(json_real_value(json_array_get(list, 5))));
    ck_assert(!signbit(json_real_value(json_array_get(list, 6))));
    ck_assert(json_is_integer(json_array_get(list, 7))); /* has the bits of 2.0 */
    json_decref(list);
}
END_TEST

PEN_SUITE("io/json_number", test_json_number__doubles_are_those_of_strtod,
          test_json_number__long_numbers_are_those_of_strtod,
          test_json_number__rounding_modes_change_no_number,
          test_json_number__equal_numbers_are_one_value)
