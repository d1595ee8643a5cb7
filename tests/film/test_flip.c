/* SPDX-License-Identifier: MIT */
/* FLIP against a second implementation, which follows the paper's text (flip.h): filters of the
 * plane that are not separated, each pixel separately, in long double, with the C library's
 * functions. */
#include <math.h>
#include <string.h>

#include "film/flip.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

enum { PIXELS_MAX = 4096, RADIUS = 10, FEATURE_RADIUS = 9 };

/* Two pictures, linear. */
struct pair {
    int width, height;
    float a[3 * PIXELS_MAX], b[3 * PIXELS_MAX];
};
static struct pair pair;
static float errors[PIXELS_MAX], others[PIXELS_MAX];

static bool try_flip(float *map, struct pen_flip *out, bool exchanged, struct pen_status *st)
{
    const struct pen_film film_a = {pair.width, pair.height, pair.a},
                          film_b = {pair.width, pair.height, pair.b};
    struct pen_picture *a = pen_picture_of_film(&film_a, PEN_TRANSFER_LINEAR, st),
                       *b = a ? pen_picture_of_film(&film_b, PEN_TRANSFER_LINEAR, st) : NULL;
    const bool ok = b && (exchanged ? pen_picture_flip(b, a, map, out, st)
                                    : pen_picture_flip(a, b, map, out, st));
    pen_picture_free(a);
    pen_picture_free(b);
    return ok;
}

static struct pen_flip flip(float *map)
{
    struct pen_status st;
    struct pen_flip out;
    ck_assert(try_flip(map, &out, false, &st));
    return out;
}

static int pixels(void)
{
    return pair.width * pair.height;
}

static void fill(float *rgb, double red, double green, double blue)
{
    for (int i = 0; i < pixels(); i++) {
        rgb[3 * i] = (float)red;
        rgb[3 * i + 1] = (float)green;
        rgb[3 * i + 2] = (float)blue;
    }
}

/* A picture with edges, points and noise, and one that differs from it. Every tenth value is out of
 * the range of a display. */
static void make_pair(int width, int height, struct random *r)
{
    pair.width = width;
    pair.height = height;
    for (int i = 0; i < 3 * pixels(); i++) {
        const int x = i / 3 % width, y = i / 3 / width;
        const double ground = (x / 7 + y / 5) % 2 ? 0.7 : 0.1;
        pair.a[i] = (float)(ground + random_in(r, -0.05, 0.05));
        pair.b[i] = (float)(i % 3 == 1 ? 0.8 * ground : ground + random_in(r, -0.2, 0.2));
        if (random_below(r, 10) == 0)
            pair.b[i] = (float)random_in(r, -1, 2);
    }
}

/* ---- The second implementation. */

typedef long double real;

/* Solves m x = v by Cramer's rule. */
static void solve(real m[3][3], const real v[3], real x[3])
{
    real all = 0, part[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        all += m[0][i] * (m[1][j] * m[2][k] - m[1][k] * m[2][j]);
    }
    for (int c = 0; c < 3; c++) {
        real n[3][3];
        for (int i = 0; i < 9; i++)
            n[i / 3][i % 3] = i % 3 == c ? v[i / 3] : m[i / 3][i % 3];
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            part[c] += n[0][i] * (n[1][j] * n[2][k] - n[1][k] * n[2][j]);
        }
        x[c] = part[c] / all;
    }
}

/* RGB to XYZ from the chromaticities of the primaries and of white. */
static void colour_matrix(real m[3][3], real white[3])
{
    static const real xy[4][2] = {
        {0.64L, 0.33L}, {0.30L, 0.60L}, {0.15L, 0.06L}, {0.31271L, 0.32902L}};
    real amount[3];
    for (int c = 0; c < 4; c++) {
        const real x = xy[c][0], y = xy[c][1], column[3] = {x / y, 1, (1 - x - y) / y};
        for (int i = 0; i < 3; i++)
            *(c < 3 ? &m[i][c] : &white[i]) = column[i];
    }
    solve(m, white, amount);
    for (int i = 0; i < 9; i++)
        m[i / 3][i % 3] *= amount[i % 3];
}

static void multiply(real m[3][3], const real v[3], real out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

static real clamp(real v)
{
    return v > 0 ? v < 1 ? v : 1 : 0;
}

/* A pixel as YCxCz; coordinates outside are those of the border. */
static void ycxcz(const float *rgb, int x, int y, real out[3])
{
    real m[3][3], white[3], xyz[3], v[3];
    x = x < 0 ? 0 : x < pair.width ? x : pair.width - 1;
    y = y < 0 ? 0 : y < pair.height ? y : pair.height - 1;
    for (int c = 0; c < 3; c++)
        v[c] = clamp((real)rgb[3 * (y * pair.width + x) + c]);
    colour_matrix(m, white);
    multiply(m, v, xyz);
    out[0] = 116 * xyz[1] / white[1] - 16;
    out[1] = 500 * (xyz[0] / white[0] - xyz[1] / white[1]);
    out[2] = 200 * (xyz[1] / white[1] - xyz[2] / white[2]);
}

/* All of a picture as YCxCz, with a border. */
enum { WIDE = 330, HIGH = 130 };
static real plane[HIGH][WIDE][3];

static void make_plane(const float *rgb)
{
    for (int y = -RADIUS; y < pair.height + RADIUS; y++)
        for (int x = -RADIUS; x < pair.width + RADIUS; x++)
            ycxcz(rgb, x, y, plane[y + RADIUS][x + RADIUS]);
}

static const real pi = 3.14159265358979323846264338327950288L;

static real contrast(int channel, real squared_degrees)
{
    static const real a1[3] = {1, 1, 34.1L}, b1[3] = {0.0047L, 0.0053L, 0.04L},
                      a2[3] = {0, 0, 13.5L}, b2[3] = {1e-5L, 1e-5L, 0.025L};
    return a1[channel] * sqrtl(pi / b1[channel]) * expl(-pi * pi * squared_degrees / b1[channel]) +
           a2[channel] * sqrtl(pi / b2[channel]) * expl(-pi * pi * squared_degrees / b2[channel]);
}

static const real pixels_per_degree = 0.7L * (3840 / 0.7L) * (3.14159265358979323846264338L / 180);

/* The filters of the plane, made once: contrast, then edge and point along x. */
static real contrast_weight[3][2 * RADIUS + 1][2 * RADIUS + 1];
static real edge_weight[2 * RADIUS + 1][2 * RADIUS + 1],
    point_weight[2 * RADIUS + 1][2 * RADIUS + 1];

static void normalise(real weight[2 * RADIUS + 1][2 * RADIUS + 1])
{
    real positive = 0, negative = 0;
    for (int i = 0; i < (2 * RADIUS + 1) * (2 * RADIUS + 1); i++) {
        const real w = weight[i / (2 * RADIUS + 1)][i % (2 * RADIUS + 1)];
        *(w > 0 ? &positive : &negative) += w;
    }
    for (int i = 0; i < (2 * RADIUS + 1) * (2 * RADIUS + 1); i++) {
        real *w = &weight[i / (2 * RADIUS + 1)][i % (2 * RADIUS + 1)];
        if (*w != 0)
            *w /= *w > 0 ? positive : -negative;
    }
}

static void make_filters(void)
{
    const real deviation = 0.5L * 0.082L * pixels_per_degree, variance = deviation * deviation;
    ck_assert_int_eq((int)ceill(3 * sqrtl(0.04L / (2 * pi * pi)) * pixels_per_degree), RADIUS);
    ck_assert_int_eq((int)ceill(3 * deviation), FEATURE_RADIUS);
    for (int y = -RADIUS; y <= RADIUS; y++) {
        for (int x = -RADIUS; x <= RADIUS; x++) {
            const bool feature = abs(x) <= FEATURE_RADIUS && abs(y) <= FEATURE_RADIUS;
            const real square = x * x + y * y, g = expl(-square / (2 * variance));
            for (int c = 0; c < 3; c++)
                contrast_weight[c][y + RADIUS][x + RADIUS] =
                    contrast(c, square / (pixels_per_degree * pixels_per_degree));
            edge_weight[y + RADIUS][x + RADIUS] = feature ? -x * g : 0;
            point_weight[y + RADIUS][x + RADIUS] = feature ? (x * x / variance - 1) * g : 0;
        }
    }
    for (int c = 0; c < 3; c++)
        normalise(contrast_weight[c]);
    normalise(edge_weight);
    normalise(point_weight);
}

/* What a pixel's neighbourhood is: adjusted L*a*b*, and strengths of edge and point. */
struct seen {
    real lab[3], edge, point;
};

static void adjusted_lab(const real rgb[3], real out[3])
{
    real m[3][3], white[3], xyz[3], f[3];
    colour_matrix(m, white);
    multiply(m, rgb, xyz);
    for (int c = 0; c < 3; c++) {
        const real t = xyz[c] / white[c];
        f[c] = t > 216 / 24389.0L ? cbrtl(t) : (24389 / 27.0L * t + 16) / 116;
    }
    out[0] = 116 * f[1] - 16;
    out[1] = 0.01L * out[0] * 500 * (f[0] - f[1]);
    out[2] = 0.01L * out[0] * 200 * (f[1] - f[2]);
}

static void lab_of_ycxcz(const real v[3], real out[3])
{
    real m[3][3], white[3], rgb[3];
    colour_matrix(m, white);
    const real y = (v[0] + 16) / 116, x = v[1] / 500 + y, z = y - v[2] / 200,
               xyz[3] = {x * white[0], y * white[1], z * white[2]};
    solve(m, xyz, rgb);
    for (int c = 0; c < 3; c++)
        rgb[c] = clamp(rgb[c]);
    adjusted_lab(rgb, out);
}

static struct seen see(int x, int y)
{
    struct seen out;
    real colour[3] = {0, 0, 0}, edge[2] = {0, 0}, point[2] = {0, 0};
    for (int j = 0; j <= 2 * RADIUS; j++) {
        for (int i = 0; i <= 2 * RADIUS; i++) {
            const real *v = plane[y + j][x + i], lightness = (v[0] + 16) / 116;
            for (int c = 0; c < 3; c++)
                colour[c] += contrast_weight[c][j][i] * v[c];
            edge[0] += edge_weight[j][i] * lightness;
            edge[1] += edge_weight[i][j] * lightness;
            point[0] += point_weight[j][i] * lightness;
            point[1] += point_weight[i][j] * lightness;
        }
    }
    lab_of_ycxcz(colour, out.lab);
    out.edge = hypotl(edge[0], edge[1]);
    out.point = hypotl(point[0], point[1]);
    return out;
}

static real hyab(const real a[3], const real b[3])
{
    return fabsl(a[0] - b[0]) + hypotl(a[1] - b[1], a[2] - b[2]);
}

static real colour_error(const real a[3], const real b[3])
{
    static const real rgb_green[3] = {0, 1, 0}, rgb_blue[3] = {0, 0, 1};
    real green[3], blue[3];
    adjusted_lab(rgb_green, green);
    adjusted_lab(rgb_blue, blue);
    const real most = powl(hyab(green, blue), 0.7L), d = powl(hyab(a, b), 0.7L), knee = 0.4L * most;
    return d < knee ? 0.95L / knee * d : 0.95L + (d - knee) / (most - knee) * 0.05L;
}

static real error_of(const struct seen *a, const struct seen *b)
{
    const real feature =
        sqrtl(fmaxl(fabsl(a->edge - b->edge), fabsl(a->point - b->point)) / sqrtl(2));
    return powl(colour_error(a->lab, b->lab), 1 - feature);
}

static struct seen seen_a[PIXELS_MAX];

/* The largest difference of errors[] from the second implementation. */
static real largest_deviation(void)
{
    real largest = 0;
    make_filters();
    make_plane(pair.a);
    for (int i = 0; i < pixels(); i++)
        seen_a[i] = see(i % pair.width, i / pair.width);
    make_plane(pair.b);
    for (int i = 0; i < pixels(); i++) {
        const struct seen b = see(i % pair.width, i / pair.width);
        largest = fmaxl(largest, fabsl(error_of(&seen_a[i], &b) - (real)errors[i]));
    }
    return largest;
}

/* ---- Tests. */

/* Sizes below, at and above those of filters and of the strips in which pictures are taken. Errors
 * are rounded to binary32, which is within 3e-8. */
START_TEST(test_flip__agrees_with_the_definition)
{
    static const int sizes[][2] = {{1, 1},  {3, 2},  {2, 3},   {1, 40},  {40, 1},
                                   {21, 9}, {9, 25}, {256, 3}, {257, 4}, {300, 2}};
    struct random r = random_begin(17);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        make_pair(sizes[i][0], sizes[i][1], &r);
        flip(errors);
        const real deviation = largest_deviation();
        ck_assert_msg(deviation < 1e-7L, "%d x %d: %Lg, seed %llu", pair.width, pair.height,
                      deviation, (unsigned long long)r.seed);
    }
}
END_TEST

START_TEST(test_flip__equal_pictures_have_no_error)
{
    struct random r = random_begin(18);
    make_pair(60, 40, &r);
    memcpy(pair.b, pair.a, sizeof pair.b);
    const struct pen_flip f = flip(errors);
    for (int i = 0; i < pixels(); i++)
        ck_assert(errors[i] == 0);
    ck_assert(f.mean == 0 && f.min == 0 && f.max == 0 && f.weighted_median == 0);
    ck_assert(f.first_quartile == 0 && f.third_quartile == 0);
}
END_TEST

/* In a flat picture there are no features, and nothing is blurred. */
START_TEST(test_flip__flat_pictures_differ_by_their_colours)
{
    pair.width = 13;
    pair.height = 11;
    fill(pair.a, 0, 1, 0);
    fill(pair.b, 0, 0, 1);
    struct pen_flip f = flip(NULL);
    ck_assert(fabs(f.mean - 1) < 1e-6 && fabs(f.min - 1) < 1e-6 && f.max <= 1);
    fill(pair.a, 0, 0, 0);
    fill(pair.b, 1, 1, 1);
    static const real black[3] = {0, 0, 0}, white[3] = {1, 1, 1};
    real lab_black[3], lab_white[3];
    adjusted_lab(black, lab_black);
    adjusted_lab(white, lab_white);
    f = flip(NULL);
    ck_assert(fabsl(colour_error(lab_black, lab_white) - (real)f.mean) < 1e-6L);
    ck_assert(f.mean > 0.95 && f.mean < 1);
}
END_TEST

START_TEST(test_flip__exchanging_the_pictures_changes_no_bit)
{
    struct pen_status st;
    struct pen_flip there, back;
    struct random r = random_begin(19);
    make_pair(70, 50, &r);
    ck_assert(try_flip(errors, &there, false, &st) && try_flip(others, &back, true, &st));
    ck_assert_mem_eq(errors, others, (size_t)pixels() * sizeof *errors);
    ck_assert_mem_eq(&there, &back, sizeof there);
}
END_TEST

START_TEST(test_flip__more_noise_is_a_larger_error)
{
    double last = 0;
    pair.width = 64;
    pair.height = 48;
    fill(pair.a, 0.3, 0.4, 0.2);
    for (double amplitude = 0.01; amplitude < 0.3; amplitude *= 1.5) {
        struct random r = random_begin(20);
        for (int i = 0; i < 3 * pixels(); i++)
            pair.b[i] = pair.a[i] + (float)random_in(&r, -amplitude, amplitude);
        const struct pen_flip f = flip(NULL);
        ck_assert_msg(f.mean > 1.05 * last, "%g: %g after %g", amplitude, f.mean, last);
        last = f.mean;
    }
}
END_TEST

/* Rows of one colour: where a strip begins must not show. */
START_TEST(test_flip__strips_do_not_show)
{
    struct random r = random_begin(21);
    make_pair(1, 7, &r);
    flip(errors);
    const struct pair narrow = pair;
    pair.width = 560;
    for (int i = 0; i < 3 * pixels(); i++) {
        const int y = i / 3 / pair.width;
        pair.a[i] = narrow.a[3 * y + i % 3];
        pair.b[i] = narrow.b[3 * y + i % 3];
    }
    flip(others);
    for (int i = 0; i < pixels(); i++)
        ck_assert(others[i] == errors[i / pair.width]);
}
END_TEST

START_TEST(test_flip__values_outside_count_as_black_and_white)
{
    static const float odd[] = {-3, NAN, -INFINITY, INFINITY, 1e30f, 2},
                       even[] = {0, 0, 0, 1, 1, 1};
    struct random r = random_begin(22);
    pair.width = 30;
    pair.height = 20;
    for (int i = 0; i < 3 * pixels(); i++) {
        const uint32_t k = random_below(&r, 6);
        pair.a[i] = odd[k];
        pair.b[i] = even[k];
    }
    ck_assert(flip(NULL).max == 0);
    fill(pair.b, 0.5, NAN, 0.5);
    const struct pen_flip f = flip(errors);
    ck_assert(f.mean > 0 && f.mean < 1 && f.max <= 1 && f.min >= 0);
}
END_TEST

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Errors up to the quantile make up that share of the sum of all. */
START_TEST(test_flip__pooled_figures_are_those_of_the_errors)
{
    struct random r = random_begin(23);
    make_pair(64, 60, &r);
    for (int i = 0; i < 3 * pixels() / 2; i++)
        pair.b[i] = pair.a[i];
    const struct pen_flip f = flip(errors);
    qsort(errors, (size_t)pixels(), sizeof *errors, compare_floats);
    const double found[] = {f.first_quartile, f.weighted_median, f.third_quartile};
    real sum = 0, running = 0;
    for (int i = 0; i < pixels(); i++)
        sum += (real)errors[i];
    ck_assert(fabsl((real)f.mean - sum / pixels()) < 1e-15L);
    ck_assert(f.min == (double)errors[0] && f.max == (double)errors[pixels() - 1]);
    for (int i = 0, quarter = 1; quarter < 4; i++) {
        running += (real)errors[i];
        for (; quarter < 4 && running > quarter * sum / 4; quarter++)
            ck_assert_msg(found[quarter - 1] == (double)errors[i], "%d/4: %g, not %g", quarter,
                          found[quarter - 1], (double)errors[i]);
    }
}
END_TEST

START_TEST(test_flip__different_sizes_are_an_error)
{
    struct pen_status st;
    struct pen_flip f;
    pair.width = 4;
    pair.height = 3;
    fill(pair.a, 1, 1, 1);
    const struct pen_film film = {4, 3, pair.a}, transposed = {3, 4, pair.a};
    struct pen_picture *p = pen_picture_of_film(&film, PEN_TRANSFER_LINEAR, &st),
                       *q = pen_picture_of_film(&transposed, PEN_TRANSFER_LINEAR, &st);
    ck_assert(!pen_picture_flip(p, q, NULL, &f, &st) && st.code == PEN_INVALID);
    ck_assert_str_eq(st.msg, "pictures of 4 x 3 and 3 x 4 pixels do not compare");
    pen_picture_free(p);
    pen_picture_free(q);
}
END_TEST

START_TEST(test_flip__every_failed_allocation_is_reported)
{
    struct pen_status st = {0};
    struct pen_flip f;
    struct random r = random_begin(24);
    make_pair(5, 4, &r);
    long n = 0;
    for (bool refused = true; refused; n++) {
        alloc_fail_after(n);
        const bool ok = try_flip(NULL, &f, false, &st);
        refused = alloc_succeed();
        ck_assert(ok != refused && (ok || st.code == PEN_NO_MEMORY));
    }
    ck_assert_int_eq(n, 6); /* two pictures, the errors, a strip, sums; then none is refused */
}
END_TEST

PEN_SUITE("flip", test_flip__agrees_with_the_definition, test_flip__equal_pictures_have_no_error,
          test_flip__flat_pictures_differ_by_their_colours,
          test_flip__exchanging_the_pictures_changes_no_bit,
          test_flip__more_noise_is_a_larger_error, test_flip__strips_do_not_show,
          test_flip__values_outside_count_as_black_and_white,
          test_flip__pooled_figures_are_those_of_the_errors,
          test_flip__different_sizes_are_an_error, test_flip__every_failed_allocation_is_reported)
