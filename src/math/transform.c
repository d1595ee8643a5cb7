/* SPDX-License-Identifier: MIT */
/* Affine maps. They are built and applied while a scene is loaded, never per ray, so every sum of
 * products here is compensated. Before products of three entries are formed, each column of the
 * linear part is divided by a power of two near its size (which is exact), so that no scale of
 * scene over- or underflows. */
#include "math/transform.h"

#include <stdint.h>
#include <string.h>

#include "math/exact.h"
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

/* The linear part as columns near unit size times powers of two. */
struct columns {
    struct pen_vec3 c[3];
    int exponent[3];
};

static struct columns columns_of(const struct pen_transform *f)
{
    struct columns cols;
    for (int j = 0; j < 3; j++) {
        struct pen_vec3 c = column(f, j);
        cols.exponent[j] = vector_exponent(c);
        cols.c[j] = pen_scale(c, power_of_two(-cols.exponent[j]));
    }
    return cols;
}

static double columns_det(const struct columns *cols)
{
    return pen_dot2(cols->c[0], pen_cross(cols->c[1], cols->c[2]));
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

/* The cube root of 0.001 <= a < 1000: Newton's iteration, whose last step takes the residual from
 * an exact cube, so that cubes of short numbers give their roots exactly. */
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

/* Rodrigues' formula as a matrix: cos I + sin [k]x + (1 - cos) k k^T, with k = a / |a|. The axis
 * is divided, not multiplied with an inverse: along a coordinate axis k and k k^T are then exact,
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

/* The inverse transpose of N is its cofactor matrix over det N, and with M = N E, E the powers of
 * two taken out of the columns, that of M is that of N times the inverse of E. */
struct pen_vec3 pen_transform_normal(const struct pen_transform *f, struct pen_vec3 n)
{
    struct columns cols = columns_of(f);
    struct pen_vec3 cof[3];
    for (int j = 0; j < 3; j++)
        cof[j] = pen_cross(cols.c[(j + 1) % 3], cols.c[(j + 2) % 3]);
    struct pen_vec3 m =
        pen_vec3(n.x * power_of_two(-cols.exponent[0]), n.y * power_of_two(-cols.exponent[1]),
                 n.z * power_of_two(-cols.exponent[2]));
    m = pen_scale(m, power_of_two(-vector_exponent(m)));
    struct pen_vec3 out = pen_vec3(pen_dot2(pen_vec3(cof[0].x, cof[1].x, cof[2].x), m),
                                   pen_dot2(pen_vec3(cof[0].y, cof[1].y, cof[2].y), m),
                                   pen_dot2(pen_vec3(cof[0].z, cof[1].z, cof[2].z), m));
    return columns_det(&cols) < 0 ? pen_neg(out) : out;
}

double pen_transform_det(const struct pen_transform *f)
{
    struct columns cols = columns_of(f);
    double det = columns_det(&cols);
    for (int j = 0; j < 3; j++)
        det *= power_of_two(cols.exponent[j]);
    return det;
}

bool pen_transform_similarity(const struct pen_transform *f, double *scale)
{
    if (!pen_transform_invertible(f))
        return false;
    struct columns cols = columns_of(f);
    int e = cols.exponent[0];
    struct pen_vec3 c[3];
    for (int j = 0; j < 3; j++) {
        if (cols.exponent[j] < e - 1 || cols.exponent[j] > e + 1)
            return false; /* columns of equal length differ less in their largest entries */
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
    if (!all_finite(f))
        return false;
    struct columns cols = columns_of(f);
    double lengths = 1;
    for (int j = 0; j < 3; j++)
        lengths *= sqrt(pen_dot2(cols.c[j], cols.c[j]));
    return fabs(columns_det(&cols)) > 1e-12 * lengths;
}
