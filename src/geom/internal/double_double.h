/* SPDX-License-Identifier: MIT */
/* Double-double arithmetic: numbers hi + lo with |lo| <= ulp(hi)/2. It serves values that are
 * computed once at load or once per secondary ray, and refinement. The relative error of each
 * operation is a few 2^-104.
 * Source: Dekker, "A floating-point technique for extending the available precision", Numer. Math.
 * 18, 1971; Joldes, Muller, Popescu, "Tight and rigorous error bounds for basic building blocks of
 * double-word arithmetic", ACM TOMS 44(2), 2017. */
#ifndef PEN_GEOM_INTERNAL_DOUBLE_DOUBLE_H
#define PEN_GEOM_INTERNAL_DOUBLE_DOUBLE_H

#include "math/vec3.h"

struct dd {
    double hi, lo;
};

struct dd3 {
    struct dd x, y, z;
};

/* a + b exactly. */
static inline struct dd two_sum(double a, double b)
{
    double s = a + b, part = s - a;
    return (struct dd){s, (a - (s - part)) + (b - part)};
}

/* a + b exactly, given |a| >= |b| or a = 0. */
static inline struct dd two_sum_fast(double a, double b)
{
    double s = a + b;
    return (struct dd){s, b - (s - a)};
}

/* a b exactly, unless it underflows. */
static inline struct dd two_prod(double a, double b)
{
    double p = a * b;
    return (struct dd){p, fma(a, b, -p)};
}

static inline struct dd dd_add(struct dd a, struct dd b)
{
    struct dd s = two_sum(a.hi, b.hi), t = two_sum(a.lo, b.lo);
    s = two_sum_fast(s.hi, s.lo + t.hi);
    return two_sum_fast(s.hi, s.lo + t.lo);
}

static inline struct dd dd_neg(struct dd a)
{
    return (struct dd){-a.hi, -a.lo};
}

static inline struct dd dd_mul(struct dd a, struct dd b)
{
    struct dd p = two_prod(a.hi, b.hi);
    return two_sum_fast(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

/* a - b exactly. */
static inline struct dd3 dd_sub3(struct pen_vec3 a, struct pen_vec3 b)
{
    return (struct dd3){two_sum(a.x, -b.x), two_sum(a.y, -b.y), two_sum(a.z, -b.z)};
}

static inline struct dd3 dd_of3(struct pen_vec3 a)
{
    return (struct dd3){{a.x, 0}, {a.y, 0}, {a.z, 0}};
}

static inline struct dd3 dd_add3(struct dd3 a, struct dd3 b)
{
    return (struct dd3){dd_add(a.x, b.x), dd_add(a.y, b.y), dd_add(a.z, b.z)};
}

static inline struct dd dd_dot(struct dd3 a, struct dd3 b)
{
    return dd_add(dd_add(dd_mul(a.x, b.x), dd_mul(a.y, b.y)), dd_mul(a.z, b.z));
}

static inline struct dd3 dd_cross(struct dd3 a, struct dd3 b)
{
    return (struct dd3){dd_add(dd_mul(a.y, b.z), dd_neg(dd_mul(a.z, b.y))),
                        dd_add(dd_mul(a.z, b.x), dd_neg(dd_mul(a.x, b.z))),
                        dd_add(dd_mul(a.x, b.y), dd_neg(dd_mul(a.y, b.x)))};
}

/* sqrt(a) by one step of Newton's method from the root of a.hi; a > 0. */
static inline struct dd dd_sqrt(struct dd a)
{
    double root = sqrt(a.hi);
    return two_sum_fast(root, (fma(-root, root, a.hi) + a.lo) / (2 * root));
}

/* The roots of a t^2 + 2 b t + c, a > 0, t[0] <= t[1]; NaN if there are none. */
static inline void dd_roots(struct dd a, struct dd b, struct dd c, double t[2])
{
    double root = sqrt(dd_add(dd_mul(b, b), dd_neg(dd_mul(a, c))).hi);
    double q = b.hi < 0 ? root - b.hi : -root - b.hi;
    double first = q / a.hi, second = c.hi / q;
    t[0] = b.hi < 0 ? second : first;
    t[1] = b.hi < 0 ? first : second;
}

static inline struct pen_vec3 dd_round3(struct dd3 a)
{
    return pen_vec3(a.x.hi, a.y.hi, a.z.hi);
}

#endif
