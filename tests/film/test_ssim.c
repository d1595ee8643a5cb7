/* SPDX-License-Identifier: MIT */
/* SSIM against the paper's formulas (ssim.h), window by window, in long double. */
#include <math.h>
#include <string.h>

#include "film/encode.h"
#include "film/ssim.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

enum { PIXELS_MAX = 8192 };

typedef long double real;

/* Two pictures, linear, and their lumas. */
struct pair {
    int width, height;
    float a[3 * PIXELS_MAX], b[3 * PIXELS_MAX];
    real luma_a[PIXELS_MAX], luma_b[PIXELS_MAX];
};
static struct pair pair;

static bool try_ssim(double *out, bool exchanged, struct pen_status *st)
{
    const struct pen_film film_a = {pair.width, pair.height, pair.a},
                          film_b = {pair.width, pair.height, pair.b};
    struct pen_picture *a = pen_picture_of_film(&film_a, PEN_TRANSFER_LINEAR, st),
                       *b = a ? pen_picture_of_film(&film_b, PEN_TRANSFER_LINEAR, st) : NULL;
    const bool ok =
        b && (exchanged ? pen_picture_ssim(b, a, out, st) : pen_picture_ssim(a, b, out, st));
    pen_picture_free(a);
    pen_picture_free(b);
    return ok;
}

static double ssim(void)
{
    struct pen_status st;
    double out;
    ck_assert(try_ssim(&out, false, &st));
    return out;
}

static int pixels(void)
{
    return pair.width * pair.height;
}

/* Sets all values to that whose sRGB encoding is `encoded`. */
static void fill(float *rgb, double encoded)
{
    for (int i = 0; i < 3 * pixels(); i++)
        rgb[i] = (float)pen_decode_srgb(encoded);
}

static void make_pair(int width, int height, struct random *r)
{
    pair.width = width;
    pair.height = height;
    for (int i = 0; i < 3 * pixels(); i++) {
        const double ground = (i / 3 % width / 6 + i / 3 / width / 4) % 2 ? 0.8 : 0.2;
        pair.a[i] = (float)(ground + random_in(r, -0.2, 0.2));
        pair.b[i] = (float)(0.9 * ground + random_in(r, -0.3, 0.3));
    }
}

static real encoded(float linear)
{
    const real v = (real)linear;
    if (!(v > 0))
        return 0;
    return v >= 1 ? 1 : v <= 0.0031308L ? 12.92L * v : 1.055L * powl(v, 1 / 2.4L) - 0.055L;
}

static void make_lumas(void)
{
    for (int i = 0; i < pixels(); i++) {
        const float *a = pair.a + 3 * i, *b = pair.b + 3 * i;
        pair.luma_a[i] =
            0.2126L * encoded(a[0]) + 0.7152L * encoded(a[1]) + 0.0722L * encoded(a[2]);
        pair.luma_b[i] =
            0.2126L * encoded(b[0]) + 0.7152L * encoded(b[1]) + 0.0722L * encoded(b[2]);
    }
}

/* The index of the window of w x h pixels whose corner is x, y: means first, then deviations from
 * them. */
static real window(int x, int y, int w, int h)
{
    real weight[11 * 11], sum = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int i = 0; i < w * h; i++) {
        const real dx = i % w - (w - 1) / 2.0L, dy = i / w - (h - 1) / 2.0L;
        weight[i] = expl(-(dx * dx + dy * dy) / (2 * 1.5L * 1.5L));
        sum += weight[i];
    }
    for (int i = 0; i < w * h; i++) {
        const int at = (y + i / w) * pair.width + x + i % w;
        a += weight[i] / sum * pair.luma_a[at];
        b += weight[i] / sum * pair.luma_b[at];
    }
    for (int i = 0; i < w * h; i++) {
        const int at = (y + i / w) * pair.width + x + i % w;
        const real da = pair.luma_a[at] - a, db = pair.luma_b[at] - b;
        aa += weight[i] / sum * da * da;
        bb += weight[i] / sum * db * db;
        ab += weight[i] / sum * da * db;
    }
    const real c1 = 0.01L * 0.01L, c2 = 0.03L * 0.03L;
    return (2 * a * b + c1) * (2 * ab + c2) / ((a * a + b * b + c1) * (aa + bb + c2));
}

static real definition(void)
{
    const int w = pair.width < 11 ? pair.width : 11, h = pair.height < 11 ? pair.height : 11;
    real sum = 0;
    int count = 0;
    make_lumas();
    for (int y = 0; y + h <= pair.height; y++)
        for (int x = 0; x + w <= pair.width; x++, count++)
            sum += window(x, y, w, h);
    return sum / count;
}

/* Sizes below, at and above those of the window and of the strips in which pictures are taken. */
START_TEST(test_ssim__agrees_with_the_definition)
{
    static const int sizes[][2] = {{1, 1},   {3, 2},   {1, 30},   {30, 1},   {10, 12},
                                   {11, 11}, {12, 40}, {266, 12}, {267, 11}, {300, 20}};
    struct random r = random_begin(31);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        make_pair(sizes[i][0], sizes[i][1], &r);
        const real want = definition(), got = (real)ssim();
        ck_assert_msg(fabsl(got - want) < 1e-12L, "%d x %d: %.15Lg, not %.15Lg, seed %llu",
                      pair.width, pair.height, got, want, (unsigned long long)r.seed);
    }
}
END_TEST

START_TEST(test_ssim__equal_pictures_have_1)
{
    struct random r = random_begin(32);
    make_pair(50, 40, &r);
    memcpy(pair.b, pair.a, sizeof pair.b);
    ck_assert(ssim() == 1);
}
END_TEST

/* Of one pixel in the last digit, bright pictures differ by less than moments are rounded by. */
START_TEST(test_ssim__rounding_does_not_lead_beyond_1)
{
    struct random r = random_begin(38);
    pair.width = pair.height = 11;
    for (int i = 0; i < 300; i++) {
        for (int j = 0; j < 3 * pixels(); j++)
            pair.a[j] = pair.b[j] = (float)random_in(&r, 0.85, 0.9);
        const uint32_t at = random_below(&r, 3 * 11 * 11);
        pair.b[at] = nextafterf(pair.a[at], 1);
        const double s = ssim();
        ck_assert_msg(s <= 1 && s > 1 - 1e-11, "%d: 1 + %g, seed %llu", i, s - 1,
                      (unsigned long long)r.seed);
    }
}
END_TEST

START_TEST(test_ssim__exchanging_the_pictures_changes_no_bit)
{
    struct pen_status st;
    double there, back;
    struct random r = random_begin(33);
    make_pair(50, 40, &r);
    ck_assert(try_ssim(&there, false, &st) && try_ssim(&back, true, &st));
    ck_assert(there == back && there < 1);
}
END_TEST

/* Without structure only the means count. */
START_TEST(test_ssim__flat_pictures)
{
    pair.width = 20;
    pair.height = 15;
    fill(pair.a, 0.25);
    fill(pair.b, 0.5);
    ck_assert(fabs(ssim() - (2 * 0.25 * 0.5 + 1e-4) / (0.25 * 0.25 + 0.5 * 0.5 + 1e-4)) < 1e-6);
    fill(pair.a, 0);
    fill(pair.b, 1);
    ck_assert(fabs(ssim() - 1e-4 / (1 + 1e-4)) < 1e-9);
}
END_TEST

START_TEST(test_ssim__a_negative_has_a_negative_index)
{
    pair.width = pair.height = 24;
    for (int i = 0; i < 3 * pixels(); i++) {
        const int odd = (i / 3 % 24 + i / 3 / 24) % 2;
        pair.a[i] = odd ? 1 : 0;
        pair.b[i] = odd ? 0 : 1;
    }
    ck_assert(ssim() < -0.9);
}
END_TEST

START_TEST(test_ssim__more_noise_is_less_similar)
{
    struct random ground = random_begin(34);
    double last = 1;
    make_pair(64, 48, &ground);
    for (double amplitude = 0.01; amplitude < 0.3; amplitude *= 1.5) {
        struct random r = random_begin(35);
        for (int i = 0; i < 3 * pixels(); i++)
            pair.b[i] = pair.a[i] + (float)random_in(&r, -amplitude, amplitude);
        const double s = ssim();
        ck_assert_msg(s < last, "%g: %g after %g", amplitude, s, last);
        last = s;
    }
    ck_assert_msg(last < 0.95, "%g", last);
}
END_TEST

START_TEST(test_ssim__values_outside_count_as_black_and_white)
{
    static const float odd[] = {-3, NAN, -INFINITY, INFINITY, 1e30f, 2},
                       even[] = {0, 0, 0, 1, 1, 1};
    struct random r = random_begin(36);
    pair.width = 30;
    pair.height = 20;
    for (int i = 0; i < 3 * pixels(); i++) {
        const uint32_t k = random_below(&r, 6);
        pair.a[i] = odd[k];
        pair.b[i] = even[k];
    }
    ck_assert(ssim() == 1);
}
END_TEST

START_TEST(test_ssim__different_sizes_are_an_error)
{
    struct pen_status st;
    double s;
    pair.width = 4;
    pair.height = 3;
    fill(pair.a, 1);
    const struct pen_film film = {4, 3, pair.a}, transposed = {3, 4, pair.a};
    struct pen_picture *p = pen_picture_of_film(&film, PEN_TRANSFER_LINEAR, &st),
                       *q = pen_picture_of_film(&transposed, PEN_TRANSFER_LINEAR, &st);
    ck_assert(!pen_picture_ssim(p, q, &s, &st) && st.code == PEN_INVALID);
    pen_picture_free(p);
    pen_picture_free(q);
}
END_TEST

START_TEST(test_ssim__every_failed_allocation_is_reported)
{
    struct pen_status st = {0};
    struct random r = random_begin(37);
    double s;
    make_pair(5, 4, &r);
    long n = 0;
    for (bool refused = true; refused; n++) {
        alloc_fail_after(n);
        const bool ok = try_ssim(&s, false, &st);
        refused = alloc_succeed();
        ck_assert(ok != refused && (ok || st.code == PEN_NO_MEMORY));
    }
    ck_assert_int_eq(n, 4); /* two pictures and a strip; then none is refused */
}
END_TEST

PEN_SUITE("ssim", test_ssim__agrees_with_the_definition, test_ssim__equal_pictures_have_1,
          test_ssim__rounding_does_not_lead_beyond_1,
          test_ssim__exchanging_the_pictures_changes_no_bit, test_ssim__flat_pictures,
          test_ssim__a_negative_has_a_negative_index, test_ssim__more_noise_is_less_similar,
          test_ssim__values_outside_count_as_black_and_white,
          test_ssim__different_sizes_are_an_error, test_ssim__every_failed_allocation_is_reported)
