/* SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "film/film.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

START_TEST(test_film__new_is_black)
{
    struct pen_status st;
    struct pen_film *film = pen_film_new(7, 5, &st);
    ck_assert(film && film->width == 7 && film->height == 5);
    for (int i = 0; i < 7 * 5 * 3; i++)
        ck_assert(film->rgb[i] == 0 && !signbit(film->rgb[i]));
    pen_film_free(film);
    pen_film_free(NULL);
}
END_TEST

START_TEST(test_film__sizes_have_bounds)
{
    const struct {
        int width, height;
        enum pen_code code;
    } rows[] = {{0, 1, PEN_INVALID},         {1, 0, PEN_INVALID},
                {-3, 5, PEN_INVALID},        {INT32_MIN, INT32_MIN, PEN_INVALID},
                {8192, 8193, PEN_TOO_LARGE}, {INT32_MAX, INT32_MAX, PEN_TOO_LARGE}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pen_status st = {PEN_OK, 0, 0, "", ""};
        ck_assert_ptr_null(pen_film_new(rows[i].width, rows[i].height, &st));
        ck_assert_int_eq(st.code, rows[i].code);
        ck_assert_uint_gt(strlen(st.msg), 0);
    }
}
END_TEST

START_TEST(test_film__no_memory_is_an_error)
{
    for (long n = 0; n < 2; n++) {
        struct pen_status st = {PEN_OK, 0, 0, "", ""};
        alloc_fail_after(n);
        struct pen_film *film = pen_film_new(10, 10, &st);
        bool refused = alloc_succeed();
        ck_assert(refused && !film && st.code == PEN_NO_MEMORY);
    }
}
END_TEST

/* A changed bit changes at least 8 bits of the hash; the size and the order of values count too. */
START_TEST(test_film__hash_sees_every_bit)
{
    float rgb[3 * 3 * 5], swapped[3 * 3 * 5];
    struct random r = random_begin(1);
    for (int i = 0; i < 45; i++)
        rgb[i] = (float)random_in(&r, 0, 1);
    struct pen_film film = {3, 5, rgb}, transposed = {5, 3, rgb}, other = {3, 5, swapped};
    uint64_t hash = pen_film_hash(&film);
    ck_assert(hash == pen_film_hash(&film) && hash != pen_film_hash(&transposed));
    for (int i = 0; i < 45 * 32; i++) {
        uint32_t bits;
        memcpy(swapped, rgb, sizeof rgb);
        memcpy(&bits, &swapped[i / 32], sizeof bits);
        bits ^= 1u << i % 32;
        memcpy(&swapped[i / 32], &bits, sizeof bits);
        int changed = __builtin_popcountll(hash ^ pen_film_hash(&other));
        if (changed < 8)
            ck_abort_msg("bit %d of value %d changes %d bits", i % 32, i / 32, changed);
    }
    memcpy(swapped, rgb, sizeof rgb);
    swapped[0] = rgb[2], swapped[2] = rgb[0];
    ck_assert(hash != pen_film_hash(&other));
}
END_TEST

START_TEST(test_film__hash_is_fixed)
{
    const float rgb[3] = {0, 0.5f, 1};
    struct pen_film film = {1, 1, (float *)rgb};
    ck_assert_uint_eq(pen_film_hash(&film), UINT64_C(3370865169503583345));
}
END_TEST

PEN_SUITE("film", test_film__new_is_black, test_film__sizes_have_bounds,
          test_film__no_memory_is_an_error, test_film__hash_sees_every_bit,
          test_film__hash_is_fixed)
