/* SPDX-License-Identifier: MIT */
/* The sign of the orientation determinant. It is computed in floating-point arithmetic with an
 * error bound. If the bound does not decide, it is computed exactly, as a sum of doubles that do
 * not overlap.
 * Source: Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
 * predicates", Discrete & Computational Geometry 18, 1997: the bound of figure 21 (A), and
 * Grow-Expansion of figure 6. */
#include "math/orient2d.h"

#include <math.h>

/* The six products of the expanded determinant, each as a rounded value and its exact remainder. */
enum { TERMS = 12 };

static int sign(double x)
{
    return (x > 0) - (x < 0);
}

/* Adds b to an expansion of n terms, smallest first, which then has n + 1 terms. */
static void grow(double *expansion, int n, double b)
{
    double q = b;
    for (int i = 0; i < n; i++) {
        double sum = q + expansion[i];
        double part = sum - q;
        expansion[i] = (q - (sum - part)) + (expansion[i] - part);
        q = sum;
    }
    expansion[n] = q;
}

static int orient_exact(struct pen_point2 a, struct pen_point2 b, struct pen_point2 c)
{
    const double factors[TERMS / 2][2] = {{a.x, b.y},  {-a.y, b.x}, {b.x, c.y},
                                          {-b.y, c.x}, {c.x, a.y},  {-c.y, a.x}};
    double expansion[TERMS];
    for (int i = 0; i < TERMS / 2; i++) {
        double product = factors[i][0] * factors[i][1];
        grow(expansion, 2 * i, fma(factors[i][0], factors[i][1], -product));
        grow(expansion, 2 * i + 1, product);
    }
    for (int i = TERMS - 1; i >= 0; i--)
        if (expansion[i] != 0)
            return sign(expansion[i]);
    return 0;
}

int pen_orient2d(struct pen_point2 a, struct pen_point2 b, struct pen_point2 c)
{
    double left = (a.x - c.x) * (b.y - c.y);
    double right = (a.y - c.y) * (b.x - c.x);
    double det = left - right;
    double bound = (3.0 + 0x1p-49) * 0x1p-53 * (fabs(left) + fabs(right));
    if (fabs(det) > bound)
        return sign(det);
    if ((a.x == c.x && a.y == c.y) || (b.x == c.x && b.y == c.y))
        return 0; /* for example where edges of a polygon share an end */
    return orient_exact(a, b, c);
}
