/* SPDX-License-Identifier: MIT */
/* Affine maps. They are built and applied while a scene is loaded, never per ray. So every sum of
 * products here is compensated, and sums of products of three entries are exact. Whether a map can
 * be inverted, and whether it mirrors, has no tolerance and no range. */
#include "math/transform.h"

#include <stdint.h>
#include <string.h>

#include "math/exact.h"
#include "math/exact_sum.h"
#include "math/fn.h"

/* 2^e for -1022 <= e <= 1023. */
static double power_of_two(int e)
{
    uint64_t bits = (uint64_t)(e + 1023) << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The e with 2^e <= |value| < 2^(e+1), clamped to -1000..1000 so that both 2^e and 2^-e exist. */
static int exponent_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    int e = (int)(bits >> 52 & 0x7FF) - 1023;
    return e < -1000 ? -1000 : e > 1000 ? 1000 : e;
}

static int vector_exponent(struct pen_vec3 v)
{
    double largest = fabs(v.x);
    largest = fabs(v.y) > largest ? fabs(v.y) : largest;
    largest = fabs(v.z) > largest ? fabs(v.z) : largest;
    return exponent_of(largest);
}

static struct pen_vec3 column(const struct pen_transform *f, int j)
{
    return pen_vec3(f->m[0][j], f->m[1][j], f->m[2][j]);
}

static struct pen_vec3 row(const struct pen_transform *f, int i)
{
    return pen_vec3(f->m[i][0], f->m[i][1], f->m[i][2]);
}

static bool all_finite(const struct pen_transform *f)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            if (!isfinite(f->m[i][j]))
                return false;
        }
    }
    return true;
}

/* The cube root of 0.001 <= a < 1000, by Newton's iteration. Its last step takes the residual from
 * an exact cube, so cubes of short numbers give their roots exactly. */
static double cube_root(double a)
{
    double y = a < 1 ? 0.5 + 0.5 * a : 0.7 + 0.3 * a;
    for (int i = 0; i < 20; i++)
        y -= (y - a / (y * y)) / 3;
    double square = y * y;
    double cube = square * y;
    double low = fma(square, y, -cube) + fma(y, y, -square) * y;
    return y - ((cube - a) + low) / (3 * square);
}

struct pen_transform pen_transform_identity(void)
{
    return (struct pen_transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

/* Rodrigues' formula as a matrix: cos I + sin [k]x + (1 - cos) k k^T, with k = a / |a|. The axis is
 * divided rather than multiplied by an inverse. So along a coordinate axis k and k k^T are exact,
 * and all products are with 0 or 1. */
static struct pen_transform rotation(struct pen_vec3 axis, double degrees)
{
    struct pen_vec3 scaled = pen_scale(axis, power_of_two(-vector_exponent(axis)));
    const double a[3] = {scaled.x, scaled.y, scaled.z};
    double square = pen_dot2(scaled, scaled), length = sqrt(square);
    double sine, cosine;
    pen_sincos_deg(degrees, &sine, &cosine);
    struct pen_transform f = pen_transform_identity();
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        f.m[i][i] = fma(1 - cosine, a[i] * a[i] / square, cosine);
        f.m[i][j] = pen_dop(1 - cosine, a[i] * a[j] / square, sine, a[l] / length);
        f.m[j][i] = pen_sop(1 - cosine, a[i] * a[j] / square, sine, a[l] / length);
    }
    return f;
}

struct pen_transform pen_transform_make(double scale, struct pen_vec3 axis, double degrees,
                                        struct pen_vec3 translate)
{
    struct pen_transform f = rotation(axis, degrees);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            f.m[i][j] *= scale;
        f.m[i][3] = pen_component(translate, i);
    }
    return f;
}

struct pen_transform pen_transform_compose(const struct pen_transform *outer,
                                           const struct pen_transform *inner)
{
    struct pen_transform f;
    struct pen_vec3 moved = pen_transform_point(outer, column(inner, 3));
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            f.m[i][j] = pen_dot2(row(outer, i), column(inner, j));
        f.m[i][3] = pen_component(moved, i);
    }
    return f;
}

struct pen_vec3 pen_rotate(struct pen_vec3 v, struct pen_vec3 axis, double degrees)
{
    struct pen_transform f = rotation(axis, degrees);
    return pen_transform_vector(&f, v);
}

struct pen_vec3 pen_transform_point(const struct pen_transform *f, struct pen_vec3 p)
{
    return pen_add(pen_transform_vector(f, p), column(f, 3));
}

struct pen_vec3 pen_transform_vector(const struct pen_transform *f, struct pen_vec3 v)
{
    return pen_vec3(pen_dot2(row(f, 0), v), pen_dot2(row(f, 1), v), pen_dot2(row(f, 2), v));
}

/* The sum is exact if its rounding, below 2^-50 of the sum of the products' sizes, might hide its
 * sign. Subnormal products lose less than 2^-670 if entries are below 2^400. */
int pen_transform_orientation(const struct pen_transform *f)
{
    struct pen_exact_sum exact = {{0}};
    double det = 0, size = 0, most = 0;
    for (int j = 0; j < 3; j++) {
        int k = (j + 1) % 3, l = (j + 2) % 3;
        double plus = f->m[0][j] * f->m[1][k] * f->m[2][l];
        double minus = f->m[0][j] * f->m[1][l] * f->m[2][k];
        det += plus - minus;
        size += fabs(plus) + fabs(minus);
        for (int i = 0; i < 3; i++)
            most = fabs(f->m[i][j]) > most ? fabs(f->m[i][j]) : most;
    }
    if (fabs(det) > 0x1p-49 * size && fabs(det) > 0x1p-600 && most < 0x1p400)
        return det > 0 ? 1 : -1;
    for (int j = 0; j < 3; j++) {
        int k = (j + 1) % 3, l = (j + 2) % 3;
        pen_exact_add(&exact, f->m[0][j], f->m[1][k], f->m[2][l]);
        pen_exact_add(&exact, f->m[0][j], f->m[1][l], -f->m[2][k]);
    }
    return pen_exact_sign(&exact);
}

/* The inverse transpose is the cofactor matrix over the determinant. For a map that nearly flattens
 * space, sums of cofactors cancel to almost nothing, so they are computed exactly. */
struct pen_vec3 pen_transform_normal(const struct pen_transform *f, struct pen_vec3 n)
{
    struct pen_exact_sum sum[3] = {{{0}}};
    double sign = pen_transform_orientation(f) < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++) {
        const double *y = f->m[(i + 1) % 3], *z = f->m[(i + 2) % 3];
        for (int j = 0; j < 3; j++) {
            int k = (j + 1) % 3, l = (j + 2) % 3;
            double part = sign * pen_component(n, j);
            pen_exact_add(&sum[i], part, y[k], z[l]);
            pen_exact_add(&sum[i], part, y[l], -z[k]);
        }
    }
    return pen_exact_direction(sum);
}

bool pen_transform_similarity(const struct pen_transform *f, double *scale)
{
    if (!pen_transform_invertible(f))
        return false;
    int e = vector_exponent(column(f, 0));
    struct pen_vec3 c[3];
    for (int j = 0; j < 3; j++) {
        int exponent = vector_exponent(column(f, j));
        if (exponent < e - 1 || exponent > e + 1)
            return false; /* lengths differ: columns of equal length differ less in their largest
                             entries */
        c[j] = pen_scale(column(f, j), power_of_two(-e));
    }
    double square = pen_dot2(c[0], c[0]), slack = 1e-6 * square;
    for (int j = 0; j < 3; j++) {
        struct pen_vec3 next = c[(j + 1) % 3];
        if (fabs(pen_dot2(c[j], next)) > slack || fabs(pen_dot2(next, next) - square) > slack)
            return false;
    }
    double det = fabs(pen_dot2(c[0], pen_cross(c[1], c[2])));
    *scale = cube_root(det) * power_of_two(e);
    return true;
}

bool pen_transform_invertible(const struct pen_transform *f)
{
    return all_finite(f) && pen_transform_orientation(f) != 0;
}
