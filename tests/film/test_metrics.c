/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "film/encode.h"
#include "film/metrics.h"
#include "support/alloc.h"
#include "support/suite.h"

enum { W = 4, H = 3 };

/* Sets all values to that whose sRGB encoding is `encoded`. */
static void fill(float rgb[W * H * 3], double encoded)
{
    for (int i = 0; i < W * H * 3; i++)
        rgb[i] = (float)pen_decode_srgb(encoded);
}

static struct pen_difference compare(float *a, float *b, double tolerance)
{
    struct pen_status st;
    struct pen_film fa = {W, H, a}, fb = {W, H, b};
    struct pen_picture *pa = pen_picture_of_film(&fa, PEN_TRANSFER_LINEAR, &st),
                       *pb = pen_picture_of_film(&fb, PEN_TRANSFER_LINEAR, &st);
    struct pen_difference d;
    ck_assert(pa && pb && pen_picture_compare(pa, pb, tolerance, &d, &st));
    pen_picture_free(pa);
    pen_picture_free(pb);
    return d;
}

START_TEST(test_metrics__equal_pictures_do_not_differ)
{
    float a[W * H * 3];
    fill(a, 0.3);
    struct pen_difference d = compare(a, a, 0);
    ck_assert(d.rmse == 0 && d.psnr == INFINITY && d.max_error == 0 && d.differing == 0);
    ck_assert(d.over == 0 && d.rmse_within == 0);
}
END_TEST

START_TEST(test_metrics__values_are_compared_encoded)
{
    float a[W * H * 3], b[W * H * 3];
    fill(a, 0.25);
    fill(b, 0.5);
    struct pen_difference d = compare(a, b, 1);
    ck_assert(fabs(d.rmse - 0.25) < 1e-7 && fabs(d.max_error - 0.25) < 1e-7);
    ck_assert(fabs(d.psnr - 12.041199826559248) < 1e-5);
    ck_assert(d.differing == W * H && d.over == 0 && d.rmse_within == d.rmse);
    ck_assert(d.max_x == 0 && d.max_y == 0);
}
END_TEST

START_TEST(test_metrics__one_value_counts_once)
{
    float a[W * H * 3], b[W * H * 3];
    fill(a, 0.5);
    fill(b, 0.5);
    b[(1 * W + 2) * 3 + 1] = (float)pen_decode_srgb(0.75);
    b[(2 * W + 3) * 3] = (float)pen_decode_srgb(0.6);
    struct pen_difference d = compare(a, b, 0.2);
    ck_assert(fabs(d.rmse - sqrt((0.0625 + 0.01) / (W * H * 3))) < 1e-7);
    ck_assert(fabs(d.max_error - 0.25) < 1e-7 && d.max_x == 2 && d.max_y == 1);
    ck_assert(d.differing == 2 && d.over == 1);
    ck_assert(fabs(d.rmse_within - sqrt(0.01 / ((W * H - 1) * 3))) < 1e-7);
    d = compare(a, b, 0);
    ck_assert(d.over == 2 && d.rmse_within == 0);
}
END_TEST

START_TEST(test_metrics__values_are_clamped_before_they_are_compared)
{
    float a[W * H * 3], b[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        a[i] = i % 2 ? 1 : -5;
        b[i] = i % 2 ? 100 : 0;
    }
    struct pen_difference d = compare(a, b, 0);
    ck_assert(d.rmse == 0 && d.differing == 0);
}
END_TEST

static struct pen_picture *pfm_of(float *rgb)
{
    struct pen_status st;
    struct pen_buf file = {0};
    const struct pen_film film = {W, H, rgb};
    ck_assert(pen_pfm_write(&film, &file, &st));
    struct pen_picture *read = pen_picture_read(file.data, file.bytes, &st);
    pen_buf_release(&file);
    ck_assert_ptr_nonnull(read);
    return read;
}

/* Two PFM files differ wherever their values do, also beyond 0 and 1. Within, what is found is as
 * for films. */
START_TEST(test_metrics__values_of_two_pfm_files_are_not_clamped)
{
    struct pen_status st;
    struct pen_difference d, inside;
    float two[W * H * 3], three[W * H * 3];
    for (int i = 0; i < W * H * 3; i++) {
        two[i] = 2;
        three[i] = 3;
    }
    struct pen_picture *a = pfm_of(two), *b = pfm_of(three);
    ck_assert(pen_picture_compare(a, b, 0.25, &d, &st));
    ck_assert(fabs(d.max_error - (1.055 * (pow(3, 1 / 2.4) - pow(2, 1 / 2.4)))) < 1e-12);
    ck_assert(d.differing == W * H && d.over == W * H && d.rmse == 0);
    pen_picture_free(b);
    for (int i = 0; i < W * H * 3; i++)
        three[i] = 2;
    two[4] = -1;
    three[4] = -1.5F;
    pen_picture_free(a);
    a = pfm_of(two);
    b = pfm_of(three);
    ck_assert(pen_picture_compare(a, b, 0, &d, &st));
    ck_assert(d.differing == 1 && d.max_x == 1 && d.max_y == 0);
    ck_assert(pen_picture_compare(a, a, 0, &d, &st) && d.max_error == 0 && d.differing == 0);
    pen_picture_free(a);
    pen_picture_free(b);
    for (int i = 0; i < W * H * 3; i++) {
        two[i] = (float)i / (W * H * 3 - 1);
        three[i] = (float)(W * H * 3 - 1 - i) / (W * H * 3 - 1);
    }
    a = pfm_of(two);
    b = pfm_of(three);
    inside = compare(two, three, 0.1);
    ck_assert(pen_picture_compare(a, b, 0.1, &d, &st));
    ck_assert(d.max_error == inside.max_error && d.over == inside.over && d.over > 0);
    pen_picture_free(a);
    pen_picture_free(b);
}
END_TEST

/* A PNG file of the film, in which pixels with a mask of 0 are transparent; NULL: it has no alpha.
 */
static struct pen_picture *png_of(float *rgb, int bits, const unsigned char *mask)
{
    struct pen_status st;
    struct pen_buf file = {0};
    const struct pen_film film = {W, H, rgb};
    const struct pen_png_options options = {.bits = bits, .mask = mask};
    ck_assert(pen_png_write(&film, &options, &file, &st));
    struct pen_picture *read = pen_picture_read(file.data, file.bytes, &st);
    pen_buf_release(&file);
    ck_assert_ptr_nonnull(read);
    return read;
}

START_TEST(test_metrics__other_alpha_is_another_picture)
{
    struct pen_status st;
    struct pen_difference d;
    float black[W * H * 3] = {0};
    unsigned char opaque[W * H], holes[W * H];
    for (int i = 0; i < W * H; i++) {
        opaque[i] = 1;
        holes[i] = i != 2 && i != 7;
    }
    for (int bits = 8; bits <= 16; bits += 8) {
        struct pen_picture *none = png_of(black, bits, NULL), *all = png_of(black, 8, opaque),
                           *some = png_of(black, bits, holes);
        ck_assert(pen_picture_compare(none, all, 0, &d, &st));
        ck_assert(d.alpha == 0 && d.differing == 0);
        ck_assert(pen_picture_compare(none, some, 0, &d, &st));
        ck_assert(d.alpha == 2 && d.differing == 2 && d.max_error == 0);
        ck_assert(pen_picture_compare(some, all, 0, &d, &st) && d.alpha == 2);
        pen_picture_free(none);
        pen_picture_free(all);
        pen_picture_free(some);
    }
}
END_TEST

/* Linear, not clamped, and relative to the second picture. */
START_TEST(test_metrics__relative_errors_are_linear)
{
    float a[W * H * 3], b[W * H * 3];
    double sum = 0, back = 0;
    for (int i = 0; i < W * H * 3; i++) {
        a[i] = (float)(i * 0.25 - 2);
        b[i] = (float)(i % 5 * 1.5);
        const double error = (double)a[i] - (double)b[i], square = error * error;
        sum += square / ((double)b[i] * (double)b[i] + 0.01);
        back += square / ((double)a[i] * (double)a[i] + 0.01);
    }
    ck_assert(fabs(compare(a, b, 0).relative_mse / (sum / (W * H * 3)) - 1) < 1e-14);
    ck_assert(fabs(compare(b, a, 0).relative_mse / (back / (W * H * 3)) - 1) < 1e-14);
    ck_assert(compare(a, a, 0).relative_mse == 0);
    a[0] = INFINITY;
    ck_assert(!isfinite(compare(a, b, 0).relative_mse));
}
END_TEST

/* PNG files of 8 and 16 bits count as the linear values that they encode. */
START_TEST(test_metrics__relative_errors_of_encoded_files)
{
    struct pen_status st;
    float rgb[256 * 3];
    for (int i = 0; i < 256 * 3; i++)
        rgb[i] = (float)pen_decode_srgb(i / 3 / 255.0);
    const struct pen_film film = {256, 1, rgb};
    struct pen_picture *exact = pen_picture_of_film(&film, PEN_TRANSFER_LINEAR, &st);
    for (int bits = 8; bits <= 16; bits += 8) {
        const struct pen_png_options options = {.bits = bits};
        struct pen_buf file = {0};
        struct pen_difference d;
        ck_assert(pen_png_write(&film, &options, &file, &st));
        struct pen_picture *read = pen_picture_read(file.data, file.bytes, &st);
        ck_assert(read && pen_picture_compare(read, exact, 0, &d, &st));
        ck_assert_msg(d.relative_mse < 1e-14, "%d bits: %g", bits, d.relative_mse);
        pen_picture_free(read);
        pen_buf_release(&file);
    }
    pen_picture_free(exact);
}
END_TEST

/* All codes of 8 bits that are 2 apart are within a tolerance of 2/255. */
START_TEST(test_metrics__tolerance_allows_for_rounding)
{
    struct pen_status st;
    float rgb[256 * 3], shifted[256 * 3];
    for (int i = 0; i < 256 * 3; i++) {
        rgb[i] = (float)pen_decode_srgb(i / 3 / 255.0);
        shifted[i] = (float)pen_decode_srgb((i / 3 + 2) / 255.0);
    }
    struct pen_film film = {256, 1, rgb}, other = {256, 1, shifted};
    struct pen_png_options options = {.bits = 8};
    struct pen_buf a = {0}, b = {0};
    ck_assert(pen_png_write(&film, &options, &a, &st) && pen_png_write(&other, &options, &b, &st));
    struct pen_picture *pa = pen_picture_read(a.data, a.bytes, &st);
    struct pen_picture *pb = pen_picture_read(b.data, b.bytes, &st);
    struct pen_difference d;
    ck_assert(pen_picture_compare(pa, pb, 2 / 255.0, &d, &st));
    ck_assert_int_eq(d.over, 0);
    ck_assert(pen_picture_compare(pa, pb, 1.99 / 255.0, &d, &st));
    ck_assert_int_eq(d.over, 254);
    pen_picture_free(pa);
    pen_picture_free(pb);
    pen_buf_release(&a);
    pen_buf_release(&b);
}
END_TEST

START_TEST(test_metrics__different_sizes_are_an_error)
{
    struct pen_status st;
    float a[W * H * 3];
    fill(a, 0.5);
    struct pen_film film = {W, H, a}, transposed = {H, W, a};
    struct pen_picture *p = pen_picture_of_film(&film, PEN_TRANSFER_LINEAR, &st),
                       *q = pen_picture_of_film(&transposed, PEN_TRANSFER_LINEAR, &st);
    struct pen_difference d;
    ck_assert(!pen_picture_compare(p, q, 0, &d, &st) && st.code == PEN_INVALID);
    ck_assert_str_eq(st.msg, "pictures of 4 x 3 and 3 x 4 pixels do not compare");
    alloc_fail_after(0);
    bool ok = pen_picture_compare(p, p, 0, &d, &st);
    struct pen_picture *none = pen_picture_of_film(&film, PEN_TRANSFER_LINEAR, &st);
    alloc_succeed();
    ck_assert(!ok && !none && st.code == PEN_NO_MEMORY);
    pen_picture_free(p);
    pen_picture_free(q);
}
END_TEST

PEN_SUITE("metrics", test_metrics__equal_pictures_do_not_differ,
          test_metrics__values_are_compared_encoded, test_metrics__one_value_counts_once,
          test_metrics__values_are_clamped_before_they_are_compared,
          test_metrics__values_of_two_pfm_files_are_not_clamped,
          test_metrics__other_alpha_is_another_picture, test_metrics__relative_errors_are_linear,
          test_metrics__relative_errors_of_encoded_files,
          test_metrics__tolerance_allows_for_rounding, test_metrics__different_sizes_are_an_error)
