/* SPDX-License-Identifier: MIT */
/* The methods with AVX2 and FMA, and plain tests of 8 floats or 4 doubles at a time. */
#include <stddef.h>

#include "property/price_methods.h"

#if defined(__AVX2__)
#include <immintrin.h>

#define PRICE_VARIANT "fma"
#include "property/price_kernel.h"

typedef float float8 __attribute__((vector_size(32)));
typedef int int8 __attribute__((vector_size(32)));
typedef double double4 __attribute__((vector_size(32)));
typedef long long long4 __attribute__((vector_size(32)));

static inline float8 sqrt_f(float8 x)
{
    return (float8)_mm256_sqrt_ps((__m256)x);
}

static inline double4 sqrt_d(double4 x)
{
    return (double4)_mm256_sqrt_pd((__m256d)x);
}

/* The same text for floats and doubles: vec is the vector, mask its comparisons, lanes its width.
 */
#define AT(vec, columns, k) (*(const vec *)&columns[k][i])

#define MOELLER_TRUMBORE(vec, mask, scalar, lanes, columns)                                        \
    const scalar ox = (scalar)ray->o.x, oy = (scalar)ray->o.y, oz = (scalar)ray->o.z;              \
    const scalar dx = (scalar)ray->d.x, dy = (scalar)ray->d.y, dz = (scalar)ray->d.z;              \
    vec best = {0};                                                                                \
    best += (scalar)1e30;                                                                          \
    for (int i = 0; i < PRICE_PRIMS; i += lanes) {                                                 \
        const vec x = AT(vec, columns, 0), y = AT(vec, columns, 1), z = AT(vec, columns, 2);       \
        const vec ex = AT(vec, columns, 3) - x, ey = AT(vec, columns, 4) - y;                      \
        const vec ez = AT(vec, columns, 5) - z, fx = AT(vec, columns, 6) - x;                      \
        const vec fy = AT(vec, columns, 7) - y, fz = AT(vec, columns, 8) - z;                      \
        const vec px = dy * fz - dz * fy, py = dz * fx - dx * fz, pz = dx * fy - dy * fx;          \
        const vec sx = ox - x, sy = oy - y, sz = oz - z;                                           \
        const vec qx = sy * ez - sz * ey, qy = sz * ex - sx * ez, qz = sx * ey - sy * ex;          \
        const vec inv = 1 / (ex * px + ey * py + ez * pz);                                         \
        const vec u = (sx * px + sy * py + sz * pz) * inv,                                         \
                  w = (dx * qx + dy * qy + dz * qz) * inv;                                         \
        const vec t = (fx * qx + fy * qy + fz * qz) * inv;                                         \
        const mask hit = (u >= 0) & (w >= 0) & (u + w <= 1) & (t > 0) & (t < best);                \
        best = (vec)((hit & (mask)t) | (~hit & (mask)best));                                       \
    }                                                                                              \
    double nearest = INFINITY;                                                                     \
    for (int k = 0; k < lanes; k++)                                                                \
        nearest = nearer((double)best[k], nearest);                                                \
    return nearest < 1e29 ? nearest : INFINITY;

#define SPHERES(vec, mask, scalar, lanes, columns, root)                                           \
    const scalar ox = (scalar)ray->o.x, oy = (scalar)ray->o.y, oz = (scalar)ray->o.z;              \
    const scalar dx = (scalar)ray->d.x, dy = (scalar)ray->d.y, dz = (scalar)ray->d.z;              \
    const scalar a = dx * dx + dy * dy + dz * dz, inv = 1 / a;                                     \
    vec best = {0};                                                                                \
    best += (scalar)1e30;                                                                          \
    for (int i = 0; i < PRICE_PRIMS; i += lanes) {                                                 \
        const vec fx = ox - AT(vec, columns, 0), fy = oy - AT(vec, columns, 1);                    \
        const vec fz = oz - AT(vec, columns, 2), r = AT(vec, columns, 3);                          \
        const vec b = fx * dx + fy * dy + fz * dz, c = fx * fx + fy * fy + fz * fz - r * r;        \
        const vec disc = b * b - a * c, h = root(disc), near = (-b - h) * inv,                     \
                  far = (-b + h) * inv;                                                            \
        const mask front = near > 0;                                                               \
        const vec t = (vec)((front & (mask)near) | (~front & (mask)far));                          \
        const mask hit = (disc > 0) & (t > 0) & (t < best);                                        \
        best = (vec)((hit & (mask)t) | (~hit & (mask)best));                                       \
    }                                                                                              \
    double nearest = INFINITY;                                                                     \
    for (int k = 0; k < lanes; k++)                                                                \
        nearest = nearer((double)best[k], nearest);                                                \
    return nearest < 1e29 ? nearest : INFINITY;

static double wide_triangle(const struct price_set *set, const struct pen_ray *ray)
{
    MOELLER_TRUMBORE(double4, long4, double, 4, set->triangle_soa)
}

static double wide_triangle_f(const struct price_set *set, const struct pen_ray *ray)
{
    MOELLER_TRUMBORE(float8, int8, float, 8, set->triangle_soa_f)
}

static double wide_sphere(const struct price_set *set, const struct pen_ray *ray)
{
    SPHERES(double4, long4, double, 4, set->sphere_soa, sqrt_d)
}

static double wide_sphere_f(const struct price_set *set, const struct pen_ray *ray)
{
    SPHERES(float8, int8, float, 8, set->sphere_soa_f, sqrt_f)
}

static const struct price_method wide[] = {
    {"triangle", "plain Moeller-Trumbore, 4 doubles at a time", wide_triangle},
    {"triangle", "plain Moeller-Trumbore, 8 floats at a time", wide_triangle_f},
    {"sphere", "plain b^2 - a c, 4 doubles at a time", wide_sphere},
    {"sphere", "plain b^2 - a c, 8 floats at a time", wide_sphere_f},
};

const struct price_method *price_method_avx2(int i)
{
    int own = (int)(sizeof methods / sizeof methods[0]);
    if (i < own)
        return &methods[i];
    return i - own < (int)(sizeof wide / sizeof wide[0]) ? &wide[i - own] : NULL;
}
#else
const struct price_method *price_method_avx2(int i)
{
    (void)i;
    return NULL;
}
#endif
