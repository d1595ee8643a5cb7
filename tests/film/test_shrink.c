/* SPDX-License-Identifier: MIT */
/* Small copies of pictures: their sizes, and the mean of the area that each pixel covers, compared
 * with sums over all pixels of the picture. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "film/encode.h"
#include "film/shrink.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

static struct pen_film *random_film(struct random *r, int width, int height)
{
    struct pen_status st;
    struct pen_film *film = pen_film_new(width, height, &st);
    ck_assert_ptr_nonnull(film);
    for (int i = 0; i < 3 * width * height; i++)
        film->rgb[i] = (float)random_in(r, 0, 2);
    return film;
}

static struct pen_film *shrink(const struct pen_film *film, int edge)
{
    struct pen_status st;
    struct pen_picture *picture = pen_picture_of_film(film, PEN_TRANSFER_LINEAR, &st);
    struct pen_film *copy = pen_picture_shrink(picture, edge, &st);
    ck_assert_ptr_nonnull(copy);
    pen_picture_free(picture);
    return copy;
}

/* Returns the part of pixel k of `to` that pixel i of `from` covers. */
static double weight(int i, int from, int k, int to)
{
    const double low = fmax((double)i / from, (double)k / to),
                 high = fmin((double)(i + 1) / from, (double)(k + 1) / to);
    return high > low ? (high - low) * to : 0;
}

static double mean_at(const struct pen_film *film, const struct pen_film *copy, int x, int y, int c)
{
    double sum = 0;
    for (int i = 0; i < film->width * film->height; i++)
        sum += weight(i % film->width, film->width, x, copy->width) *
               weight(i / film->width, film->height, y, copy->height) *
               (double)film->rgb[3 * i + c];
    return sum;
}

START_TEST(test_shrink__pixels_are_means_of_areas)
{
    struct random r = random_begin(7);
    for (int n = 0; n < 60; n++) {
        const int width = 1 + (int)random_in(&r, 0, 23), height = 1 + (int)random_in(&r, 0, 23),
                  longer = width > height ? width : height;
        struct pen_film *film = random_film(&r, width, height);
        struct pen_film *copy = shrink(film, 1 + (int)random_in(&r, 0, longer));
        for (int i = 0; i < copy->width * copy->height; i++) {
            const int x = i % copy->width, y = i / copy->width;
            for (int c = 0; c < 3; c++)
                ck_assert_msg(
                    fabs((double)copy->rgb[3 * i + c] - mean_at(film, copy, x, y, c)) < 1e-6,
                    "%d x %d to %d x %d at %d,%d", width, height, copy->width, copy->height, x, y);
        }
        pen_film_free(film);
        pen_film_free(copy);
    }
}
END_TEST

START_TEST(test_shrink__keeps_the_aspect)
{
    static const struct {
        int width, height, edge, to_width, to_height;
    } rows[] = {{100, 140, 70, 50, 70}, {1400, 1000, 512, 512, 366}, {640, 64, 64, 64, 6},
                {700, 1, 64, 64, 1},    {1, 700, 64, 1, 64},         {65, 65, 64, 64, 64},
                {1000, 7, 100, 100, 1}, {65, 64, 64, 64, 63},        {64, 64, 64, 64, 64},
                {2000, 250, 64, 64, 8}};
    struct random r = random_begin(8);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pen_film *film = random_film(&r, rows[i].width, rows[i].height);
        struct pen_film *copy = shrink(film, rows[i].edge);
        ck_assert_msg(copy->width == rows[i].to_width && copy->height == rows[i].to_height,
                      "%d x %d becomes %d x %d", film->width, film->height, copy->width,
                      copy->height);
        pen_film_free(film);
        pen_film_free(copy);
    }
}
END_TEST

/* Half of the light of white is the code 188, not 128. */
START_TEST(test_shrink__averages_light)
{
    struct pen_status st;
    struct pen_buf png = {0};
    float stripes[3 * 128];
    unsigned char code[3];
    for (int i = 0; i < 3 * 128; i++)
        stripes[i] = (float)(i / 3 % 2);
    const struct pen_film film = {.width = 128, .height = 1, .rgb = stripes};
    const struct pen_png_options options = {.bits = 8, .transfer = PEN_TRANSFER_SRGB};
    ck_assert(pen_png_write(&film, &options, &png, &st));
    struct pen_picture *picture = pen_picture_read(png.data, png.bytes, &st);
    struct pen_film *copy = pen_picture_shrink(picture, 64, &st);
    for (int x = 0; x < 64; x++) {
        pen_encode_8(copy->rgb + 3 * x, 3, PEN_TRANSFER_SRGB, code);
        ck_assert_int_eq(code[0], 188);
    }
    pen_film_free(copy);
    pen_picture_free(picture);
    pen_buf_release(&png);
}
END_TEST

START_TEST(test_shrink__memory_may_run_out)
{
    struct random r = random_begin(9);
    struct pen_status st;
    struct pen_film *film = random_film(&r, 20, 30);
    struct pen_picture *picture = pen_picture_of_film(film, PEN_TRANSFER_LINEAR, &st);
    bool refused = true;
    for (long n = 0; refused; n++) {
        alloc_fail_after(n);
        struct pen_film *copy = pen_picture_shrink(picture, 10, &st);
        refused = alloc_succeed();
        ck_assert(copy ? !refused : refused && st.code == PEN_NO_MEMORY);
        pen_film_free(copy);
    }
    pen_film_free(film);
    pen_picture_free(picture);
}
END_TEST

PEN_SUITE("shrink", test_shrink__pixels_are_means_of_areas, test_shrink__keeps_the_aspect,
          test_shrink__averages_light, test_shrink__memory_may_run_out)
