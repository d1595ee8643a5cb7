/* SPDX-License-Identifier: MIT */
/* The t at which a line meets a triangle of a block, with the bits of a stored facet. */
#ifndef PEN_ACCEL_INTERNAL_MESH_FACET_H
#define PEN_ACCEL_INTERNAL_MESH_FACET_H

#include "accel/internal/mesh_lanes.h"
#include "geom/triangle_plane.h"

/* Numbers in two doubles, three in lanes. */
struct mesh_dd {
    double4 hi, lo;
};

/* *to = a b - c. */
static inline void mesh_fms(double4 *to, const double4 *a, const double4 *b, const double4 *c)
{
#if MESH_FMA
    *to = (double4)_mm256_fmsub_pd((__m256d)*a, (__m256d)*b, (__m256d)*c);
#else
    for (int i = 0; i < 3; i++)
        (*to)[i] = fma((*a)[i], (*b)[i], -(*c)[i]);
#endif
}

static inline void mesh_two_prod(struct mesh_dd *to, const double4 *a, const double4 *b)
{
    to->hi = *a * *b;
    mesh_fms(&to->lo, a, b, &to->hi);
}

static inline void mesh_two_sum(struct mesh_dd *to, const double4 *a, const double4 *b)
{
    const double4 sum = *a + *b, part = sum - *a;
    to->hi = sum;
    to->lo = (*a - (sum - part)) + (*b - part);
}

static inline void mesh_two_sum_fast(struct mesh_dd *to, const double4 *a, const double4 *b)
{
    const double4 sum = *a + *b;
    to->lo = *b - (sum - *a);
    to->hi = sum;
}

typedef int64_t int64x4 __attribute__((vector_size(32)));
#define YZX(v) __builtin_shufflevector(v, v, 1, 2, 0, 3)
#define ZXY(v) __builtin_shufflevector(v, v, 2, 0, 1, 3)

/* *to = dd_cross(e, f), of edges without low parts. */
static inline void mesh_cross(struct mesh_dd *to, const double4 *e, const double4 *f)
{
    const double4 e1 = YZX(*e), e2 = ZXY(*e), f1 = YZX(*f), f2 = ZXY(*f);
    struct mesh_dd p, q, s, t;
    mesh_two_prod(&p, &e1, &f2);
    mesh_two_prod(&q, &e2, &f1);
    const double4 minus_hi = -q.hi, minus_lo = -q.lo;
    mesh_two_sum(&s, &p.hi, &minus_hi);
    mesh_two_sum(&t, &p.lo, &minus_lo);
    const double4 low = s.lo + t.hi;
    mesh_two_sum_fast(&s, &s.hi, &low);
    const double4 rest = s.lo + t.lo;
    mesh_two_sum_fast(to, &s.hi, &rest);
}

/* g.q in two doubles, as dd_dot. */
static inline struct dd mesh_plane_at(const struct mesh_dd *g, const double4 *q)
{
    struct mesh_dd m;
    mesh_two_prod(&m, &g->hi, q);
    const double4 low = m.lo + g->lo * *q;
    mesh_two_sum_fast(&m, &m.hi, &low);
    return dd_add(dd_add((struct dd){m.hi[0], m.lo[0]}, (struct dd){m.hi[1], m.lo[1]}),
                  (struct dd){m.hi[2], m.lo[2]});
}

/* Whether b + d = a exactly, in three lanes. Of the two sums one is exact, so it shows any error of
 * the other difference. */
static inline bool mesh_is_difference(const double4 *d, const double4 *a, const double4 *b)
{
    const int64x4 differs = (int64x4)(*a - *d != *b) | (int64x4)(*d + *b != *a);
    return !(differs[0] | differs[1] | differs[2]);
}

/* Sets *t to pen_outline_root of a triangle that the line enters. `v` begins with the distinguished
 * vertex. Returns false if the vertices are on one line.
 *
 * The scale of the facet does not change t, so it is left out. The operations of the stored facet
 * are done one by one in the rare cases: a rounded difference of vertices, a normal along an axis
 * or without digits, a grazing line, and where something could underflow. The range of the normal
 * and of d exclude that, because vertices are multiples of 2^-293 (pack_meshes.c). */
static inline bool mesh_facet_root(const double4 v[3], const struct pen_ray *ray, double *t)
{
    const double4 e = v[1] - v[0], f = v[2] - v[0];
    struct mesh_dd g;
    mesh_cross(&g, &e, &f);
    const double largest = double4_largest(&g.hi);
    const int zeros = (g.hi[0] == 0) + (g.hi[1] == 0) + (g.hi[2] == 0);
    bool rare = zeros > 1 || !(largest >= 0x1p-200 && largest <= 0x1p100) ||
                largest <= 0x1p-40 * double4_largest(&e) * double4_largest(&f) ||
                fabs(ray->permuted_d.z) < 0x1p-100 || !mesh_is_difference(&e, &v[1], &v[0]) ||
                !mesh_is_difference(&f, &v[2], &v[0]);
    if (!rare) {
        const struct dd c = mesh_plane_at(&g, &v[0]);
        const double power = pen_scale2(1, pen_exponent(largest));
        const struct pen_facet facet = {.g = {g.hi[0], g.hi[1], g.hi[2]},
                                        .g_low = {g.lo[0], g.lo[1], g.lo[2]},
                                        .c = c.hi,
                                        .c_low = c.lo,
                                        .grazing = PEN_FACET_GRAZING * power};
        *t = pen_facet_root(&facet, ray, &rare);
    }
    if (!rare)
        return true;
    struct pen_vec3 w[3];
    for (int i = 0; i < 3; i++)
        w[i] = pen_vec3(v[i][0], v[i][1], v[i][2]);
    return pen_triangle_plane_root(w, ray, t);
}

#endif
