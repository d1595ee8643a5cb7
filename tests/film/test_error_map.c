/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "film/encode.h"
#include "film/error_map.h"
#include "support/alloc.h"
#include "support/suite.h"

enum { STEPS = 256 };

/* Errors from 0 to 1. */
static void make_errors(float errors[STEPS])
{
    for (int i = 0; i < STEPS; i++)
        errors[i] = (float)(i / (STEPS - 1.0));
}

START_TEST(test_error_map__numbers_are_the_errors)
{
    struct pen_status st;
    float errors[STEPS];
    make_errors(errors);
    struct pen_film *film = pen_error_map(errors, STEPS / 4, 4, PEN_ERROR_MAP_VALUES, &st);
    ck_assert(film && film->width == STEPS / 4 && film->height == 4);
    for (int i = 0; i < 3 * STEPS; i++)
        ck_assert(film->rgb[i] == errors[i / 3]);
    pen_film_free(film);
}
END_TEST

static double luminance(const float *rgb)
{
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

START_TEST(test_error_map__larger_errors_are_lighter)
{
    struct pen_status st;
    float errors[STEPS];
    make_errors(errors);
    struct pen_film *film = pen_error_map(errors, STEPS, 1, PEN_ERROR_MAP_COLOURS, &st);
    ck_assert_ptr_nonnull(film);
    for (int i = 1; i < STEPS; i++)
        ck_assert_msg(luminance(film->rgb + 3 * i) > luminance(film->rgb + 3 * (i - 1)), "step %d",
                      i);
    pen_film_free(film);
}
END_TEST

/* The first, middle and last colours of magma as others print them. */
START_TEST(test_error_map__colours_are_those_of_magma)
{
    static const struct {
        int step;
        unsigned char rgb[3];
    } rows[] = {{0, {0, 0, 4}},
                {64, {81, 18, 124}},
                {128, {183, 55, 121}},
                {192, {252, 137, 97}},
                {255, {252, 253, 191}}};
    struct pen_status st;
    float errors[STEPS];
    unsigned char codes[3 * STEPS];
    make_errors(errors);
    struct pen_film *film = pen_error_map(errors, STEPS, 1, PEN_ERROR_MAP_COLOURS, &st);
    ck_assert_ptr_nonnull(film);
    pen_encode_8(film->rgb, 3 * STEPS, PEN_TRANSFER_SRGB, codes);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        for (int c = 0; c < 3; c++)
            ck_assert_msg(abs(codes[3 * rows[i].step + c] - rows[i].rgb[c]) <= 3,
                          "step %d, channel %d: %d", rows[i].step, c, codes[3 * rows[i].step + c]);
    pen_film_free(film);
}
END_TEST

START_TEST(test_error_map__no_memory_is_an_error)
{
    struct pen_status st;
    float errors[STEPS];
    make_errors(errors);
    alloc_fail_after(0);
    const struct pen_film *film = pen_error_map(errors, 16, 16, PEN_ERROR_MAP_COLOURS, &st);
    alloc_succeed();
    ck_assert(!film && st.code == PEN_NO_MEMORY);
}
END_TEST

PEN_SUITE("error map", test_error_map__numbers_are_the_errors,
          test_error_map__larger_errors_are_lighter, test_error_map__colours_are_those_of_magma,
          test_error_map__no_memory_is_an_error)
