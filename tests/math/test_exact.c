/* SPDX-License-Identifier: MIT */
/* Exact signs, and the build flag on which they depend: the compiler fuses a product into a sum
 * only where fma() is written. The fused variants are compiled for a processor with fma, because
 * otherwise a compiler cannot fuse. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "math/exact.h"
#include "support/random.h"
#include "support/suite.h"

__extension__ typedef __float128 quad;
quad fabsq(quad x);

static const double U = 0x1p-53;

enum { N = 1000000 };

static bool same_bits(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* A coordinate as scenes have them: in [-1, 1], on a coarse grid where ties are frequent, or of any
 * size from 2^-31 to 2^30. */
static double coordinate(struct random *r)
{
    switch (random_below(r, 3)) {
    case 0:
        return random_in(r, -1, 1);
    case 1:
        return (random_below(r, 65) - 32.0) / 16;
    default:
        return ldexp(random_in(r, -1, 1), (int)random_below(r, 61) - 30);
    }
}

/* H041 */
START_TEST(test_exact__h041_dop_is_antisymmetric)
{
    struct random r = random_begin(41);
    for (int i = 0; i < N; i++) {
        double px = coordinate(&r), py = coordinate(&r), qx = coordinate(&r), qy = coordinate(&r);
        if (i % 4 == 0) { /* on one line through 0, within rounding */
            double t = random_in(&r, -2, 2);
            qx = t * px, qy = t * py;
        }
        double pq = pen_dop(px, qy, py, qx), qp = pen_dop(qx, py, qy, px);
        if (!((pq > 0) == (qp < 0) && (pq < 0) == (qp > 0) && fabs(pq + qp) <= 4 * U * fabs(pq)))
            ck_abort_msg("seed %llu, pair %d: %a %a", (unsigned long long)r.seed, i, pq, qp);
    }
}
END_TEST

START_TEST(test_exact__dop_is_within_two_roundings)
{
    struct random r = random_begin(1);
    double worst = 0;
    for (int i = 0; i < N; i++) {
        double a = coordinate(&r), b = coordinate(&r), c = coordinate(&r), d = coordinate(&r);
        if (i % 2 && c != 0) /* nearly equal products */
            d = a * b / c * (1 + U * random_below(&r, 4));
        quad exact = (quad)a * b - (quad)c * d;
        double got = pen_dop(a, b, c, d), error = (double)fabsq(got - exact);
        double sum = pen_sop(a, b, c, d),
               sum_error = (double)fabsq(sum - ((quad)a * b + (quad)c * d));
        double size = (double)fabsq(exact), sum_size = (double)fabsq((quad)a * b + (quad)c * d);
        if (!(error <= 2 * U * size && sum_error <= 2 * U * sum_size))
            ck_abort_msg("seed %llu: dop(%a, %a, %a, %a) = %a, sop %a", (unsigned long long)r.seed,
                         a, b, c, d, got, sum);
        if (size > 0 && error / size > worst)
            worst = error / size;
    }
    ck_assert_msg(worst > U, "the test met no hard case: %g u", worst / U);
}
END_TEST

START_TEST(test_exact__dot2_is_as_if_in_twice_the_precision)
{
    struct random r = random_begin(2);
    for (int i = 0; i < N; i++) {
        struct pen_vec3 a = pen_vec3(coordinate(&r), coordinate(&r), coordinate(&r));
        struct pen_vec3 b = pen_vec3(coordinate(&r), coordinate(&r), coordinate(&r));
        if (i % 2 && b.z != 0) /* nearly orthogonal */
            a.z = -(a.x * b.x + a.y * b.y) / b.z;
        quad exact = (quad)a.x * b.x + (quad)a.y * b.y + (quad)a.z * b.z;
        quad sizes = fabsq((quad)a.x * b.x) + fabsq((quad)a.y * b.y) + fabsq((quad)a.z * b.z);
        double got = pen_dot2(a, b);
        if (!(fabsq(got - exact) <= U * fabsq(exact) + 16 * U * U * sizes))
            ck_abort_msg("seed %llu: (%a %a %a).(%a %a %a) = %a", (unsigned long long)r.seed, a.x,
                         a.y, a.z, b.x, b.y, b.z, got);
    }
}
END_TEST

/* H035: the classroom tracer threw an exception here; the result is an ordinary value. */
START_TEST(test_exact__h035_cross_of_parallels_is_zero)
{
    struct random r = random_begin(3);
    struct pen_vec3 zero = pen_vec3(0, 0, 0);
    for (int i = 0; i < N; i++) {
        struct pen_vec3 a = pen_vec3(coordinate(&r), coordinate(&r), coordinate(&r));
        a = pen_vec3((float)a.x, (float)a.y, (float)a.z);
        struct pen_vec3 b = pen_scale(a, (random_below(&r, 2001) - 1000.0) / 8); /* exact */
        struct pen_vec3 c = pen_cross(a, b), z = pen_cross(a, zero), d = pen_sub(a, a);
        if (!(c.x == 0 && c.y == 0 && c.z == 0 && z.x == 0 && z.y == 0 && z.z == 0 && d.x == 0 &&
              d.y == 0 && d.z == 0))
            ck_abort_msg("seed %llu: %a %a %a", (unsigned long long)r.seed, a.x, a.y, a.z);
    }
}
END_TEST

START_TEST(test_exact__cross_follows_the_right_hand)
{
    struct pen_vec3 c = pen_cross(pen_vec3(1, 0, 0), pen_vec3(0, 1, 0));
    ck_assert(c.x == 0 && c.y == 0 && c.z == 1);
    c = pen_cross(pen_vec3(1, 2, 3), pen_vec3(-4, 5, 7));
    ck_assert(c.x == -1 && c.y == -19 && c.z == 13);
}
END_TEST

struct sheared {
    double x[3], y[3], edge[3];
};

/* The shear of a watertight triangle test and its edge functions in plain products. Nothing in
 * the source distinguishes the three vertices; a compiler that fuses some products does. */
static inline __attribute__((always_inline)) struct sheared shear(const struct pen_vec3 v[3],
                                                                  double sx, double sy)
{
    double ax = v[0].x - sx * v[0].z, ay = v[0].y - sy * v[0].z;
    double bx = v[1].x - sx * v[1].z, by = v[1].y - sy * v[1].z;
    double cx = v[2].x - sx * v[2].z, cy = v[2].y - sy * v[2].z;
    return (struct sheared){
        {ax, bx, cx}, {ay, by, cy}, {cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax}};
}

static __attribute__((noinline)) struct sheared shear_base(const struct pen_vec3 v[3], double sx,
                                                           double sy)
{
    return shear(v, sx, sy);
}

#ifdef __x86_64__
__attribute__((noinline, target("avx2,fma"))) static struct sheared
shear_fma(const struct pen_vec3 v[3], double sx, double sy)
{
    return shear(v, sx, sy);
}
#endif

/* H042: the same vertex in roles A, B and C. Also against the rounded steps one by one. */
static void check_roles(struct sheared (*f)(const struct pen_vec3 *, double, double))
{
    struct random r = random_begin(42);
    for (int i = 0; i < N; i++) {
        struct pen_vec3 v[3];
        for (int j = 0; j < 3; j++)
            v[j] = pen_vec3(coordinate(&r), coordinate(&r), coordinate(&r));
        double sx = random_in(&r, -1, 1), sy = random_in(&r, -1, 1);
        const struct pen_vec3 turned[3] = {v[1], v[2], v[0]}, flipped[3] = {v[1], v[0], v[2]};
        struct sheared a = f(v, sx, sy), b = f(turned, sx, sy), c = f(flipped, sx, sy);
        volatile double product = sx * v[0].z;
        if (!(same_bits(a.x[0], v[0].x - product) && same_bits(a.x[0], b.x[2]) &&
              same_bits(a.x[0], c.x[1]) && same_bits(a.y[0], b.y[2]) && same_bits(a.y[0], c.y[1])))
            ck_abort_msg("seed %llu, triangle %d: a vertex depends on its role",
                         (unsigned long long)r.seed, i);
        for (int j = 0; j < 3; j++) {
            int other = j == 2 ? 2 : 1 - j; /* the same edge, run through backwards */
            if (!(a.edge[j] == -c.edge[other]))
                ck_abort_msg("seed %llu, triangle %d: edge %d is %a and backwards %a",
                             (unsigned long long)r.seed, i, j, a.edge[j], c.edge[other]);
        }
    }
}

START_TEST(test_exact__h042_a_vertex_in_every_role)
{
    check_roles(shear_base);
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        check_roles(shear_fma);
#endif
}
END_TEST

/* The guarantees of pen_dop come from its written fma; they hold for products rounded once only. */
START_TEST(test_exact__plain_products_lose_the_sign)
{
    double a = 1 + 0x1p-30, b = 1 - 0x1p-30;
    ck_assert(pen_dop(a, b, 1, 1) == -0x1p-60);
    ck_assert(pen_dop(1, 1, a, b) == 0x1p-60);
    volatile double plain = a * b;
    ck_assert(plain - 1 == 0);
}
END_TEST

PEN_SUITE("exact", test_exact__h041_dop_is_antisymmetric, test_exact__dop_is_within_two_roundings,
          test_exact__dot2_is_as_if_in_twice_the_precision,
          test_exact__h035_cross_of_parallels_is_zero, test_exact__cross_follows_the_right_hand,
          test_exact__h042_a_vertex_in_every_role, test_exact__plain_products_lose_the_sign)
