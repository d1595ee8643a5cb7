/* SPDX-License-Identifier: MIT */
/* Exact signs by expansions: sums of doubles that do not overlap, smallest first.
 * Source: Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
 * predicates", Discrete & Computational Geometry 18, 1997. Exact while nothing over- or
 * underflows: inputs between 2^-200 and 2^200 in size, or 0. */
#include "property/oracle.h"

enum { PARTS = 512 };

struct expansion {
    int count;
    double part[PARTS];
};

static void clear(struct expansion *e)
{
    e->count = 0;
}

/* e += x */
static void grow(struct expansion *e, double x)
{
    int kept = 0;
    for (int i = 0; i < e->count; i++) {
        double sum = x + e->part[i], part = sum - x;
        double lost = (x - (sum - part)) + (e->part[i] - part);
        if (lost != 0)
            e->part[kept++] = lost;
        x = sum;
    }
    if (x != 0)
        e->part[kept++] = x;
    e->count = kept;
}

static void grow_product(struct expansion *e, double a, double b)
{
    double p = a * b;
    grow(e, fma(a, b, -p));
    grow(e, p);
}

/* e += s a b */
static void add_product(struct expansion *e, double s, const struct expansion *a,
                        const struct expansion *b)
{
    for (int i = 0; i < a->count; i++)
        for (int k = 0; k < b->count; k++)
            grow_product(e, s * a->part[i], b->part[k]);
}

static void difference(struct expansion *e, double a, double b)
{
    clear(e);
    grow(e, a);
    grow(e, -b);
}

static int sign_of(const struct expansion *e)
{
    if (e->count == 0)
        return 0;
    return e->part[e->count - 1] > 0 ? 1 : -1;
}

struct expansion3 {
    struct expansion c[3];
};

static void difference3(struct expansion3 *e, struct pen_vec3 a, struct pen_vec3 b)
{
    difference(&e->c[0], a.x, b.x);
    difference(&e->c[1], a.y, b.y);
    difference(&e->c[2], a.z, b.z);
}

static void cross(struct expansion3 *out, const struct expansion3 *a, const struct expansion3 *b)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        clear(&out->c[i]);
        add_product(&out->c[i], 1, &a->c[j], &b->c[k]);
        add_product(&out->c[i], -1, &a->c[k], &b->c[j]);
    }
}

/* The sign of d.(p x q). */
static int triple_of(const struct expansion3 *d, const struct expansion3 *p,
                     const struct expansion3 *q)
{
    struct expansion3 n;
    struct expansion sum;
    cross(&n, p, q);
    clear(&sum);
    for (int i = 0; i < 3; i++)
        add_product(&sum, 1, &d->c[i], &n.c[i]);
    return sign_of(&sum);
}

static int triple(struct pen_vec3 d, const struct expansion3 *p, const struct expansion3 *q)
{
    struct expansion3 direction;
    difference3(&direction, d, pen_vec3(0, 0, 0));
    return triple_of(&direction, p, q);
}

/* The determinant in doubles and a bound on its error, 2^-53 times this. */
static double estimate(struct oracle_ray ray, struct pen_vec3 p, struct pen_vec3 q, double *bound)
{
    struct pen_vec3 a = pen_sub(p, ray.o), b = pen_sub(q, ray.o), d = ray.d;
    *bound = 24 * (fabs(d.x) * (fabs(a.y * b.z) + fabs(a.z * b.y)) +
                   fabs(d.y) * (fabs(a.z * b.x) + fabs(a.x * b.z)) +
                   fabs(d.z) * (fabs(a.x * b.y) + fabs(a.y * b.x)));
    return d.x * (a.y * b.z - a.z * b.y) + d.y * (a.z * b.x - a.x * b.z) +
           d.z * (a.x * b.y - a.y * b.x);
}

int oracle_side(struct oracle_ray ray, struct pen_vec3 p, struct pen_vec3 q)
{
    double bound, det = estimate(ray, p, q, &bound);
    if (fabs(det) > 0x1p-53 * bound)
        return det > 0 ? 1 : -1;
    struct expansion3 a, b;
    difference3(&a, p, ray.o);
    difference3(&b, q, ray.o);
    return triple(ray.d, &a, &b);
}

/* The side of p as seen along the ray with respect to direction e across it: the sign of
 * det [d, e, p - o]. */
static int side_of_direction(struct oracle_ray ray, struct pen_vec3 e, struct pen_vec3 p)
{
    struct expansion3 a, b;
    difference3(&a, e, pen_vec3(0, 0, 0));
    difference3(&b, p, ray.o);
    return triple(ray.d, &a, &b);
}

/* Whether the ray passes an edge so near that moving its ends by k u of their distance from o
 * would change the side, between its ends or near them. */
static bool too_near(struct oracle_ray ray, struct pen_vec3 p, struct pen_vec3 q, double k)
{
    struct pen_vec3 a = pen_sub(p, ray.o), b = pen_sub(q, ray.o), e = pen_sub(q, p);
    double d = pen_length(ray.d), u = 0x1p-53, bound;
    double slack = k * u * (pen_length(a) + pen_length(b));
    if (pen_length(e) == 0)
        return false;
    double det = estimate(ray, p, q, &bound);
    /* |det| = |d| |e| times the distance between the ray and the edge, across the view. */
    struct pen_vec3 across = pen_sub(e, pen_scale(ray.d, pen_dot(e, ray.d) / (d * d)));
    if (fabs(det) > slack * d * pen_length(across) + 2 * u * bound)
        return false;
    /* Seen along the ray: is 0 within the segment, slack allowed? */
    struct pen_vec3 pa = pen_sub(a, pen_scale(ray.d, pen_dot(a, ray.d) / (d * d)));
    double along = -pen_dot(pa, across), length = pen_length(across);
    return along >= -slack * length * 4 && along <= length * length + slack * length * 4;
}

int oracle_winding(const struct pen_vec3 *v, int count, struct oracle_ray ray, double k,
                   bool *unsure)
{
    struct pen_vec3 d = ray.d;
    struct pen_vec3 e = fabs(d.x) <= fabs(d.y) && fabs(d.x) <= fabs(d.z) ? pen_vec3(1, 0, 0)
                        : fabs(d.y) <= fabs(d.z)                         ? pen_vec3(0, 1, 0)
                                                                         : pen_vec3(0, 0, 1);
    int winding = 0;
    *unsure = false;
    for (int i = 0; i < count; i++) {
        struct pen_vec3 p = v[i], q = v[(i + 1) % count];
        bool below = side_of_direction(ray, e, p) <= 0, next = side_of_direction(ray, e, q) <= 0;
        *unsure = *unsure || too_near(ray, p, q, k);
        if (below == next)
            continue;
        int side = oracle_side(ray, p, q);
        winding += below && side > 0 ? 1 : !below && side < 0 ? -1 : 0;
    }
    return winding;
}

/* The sign of a / b - c / e for b, e > 0. */
static int compare(const struct expansion *a, double b, const struct expansion *c, double e)
{
    struct expansion left, eb, ee;
    clear(&eb);
    grow(&eb, b);
    clear(&ee);
    grow(&ee, e);
    clear(&left);
    add_product(&left, 1, a, &ee);
    add_product(&left, -1, c, &eb);
    return sign_of(&left);
}

/* An end of a range of t: n / d, d > 0. */
struct end {
    struct expansion n;
    double d;
};

static void narrow(struct end *to, double bound, double o, double d, int keep)
{
    struct end e;
    e.d = fabs(d);
    difference(&e.n, d > 0 ? bound : o, d > 0 ? o : bound);
    if (compare(&e.n, e.d, &to->n, to->d) == keep)
        *to = e;
}

bool oracle_slab(struct pen_vec3 lo, struct pen_vec3 hi, struct oracle_ray ray, double tmax)
{
    struct end near = {.d = 1}, far = {.d = 1};
    grow(&near.n, 0);
    clear(&far.n);
    grow(&far.n, tmax < 0x1p200 ? tmax : 0x1p200); /* as good as infinite */
    for (int axis = 0; axis < 3; axis++) {
        double o = pen_component(ray.o, axis), d = pen_component(ray.d, axis);
        double a = pen_component(lo, axis), b = pen_component(hi, axis);
        if (d == 0) {
            if (o < a || o > b)
                return false;
            continue;
        }
        narrow(&near, d > 0 ? a : b, o, d, 1);
        narrow(&far, d > 0 ? b : a, o, d, -1);
    }
    return compare(&near.n, near.d, &far.n, far.d) <= 0;
}

bool oracle_collinear(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c)
{
    struct expansion3 e, f, n;
    difference3(&e, b, a);
    difference3(&f, c, a);
    cross(&n, &e, &f);
    return sign_of(&n.c[0]) == 0 && sign_of(&n.c[1]) == 0 && sign_of(&n.c[2]) == 0;
}

static double value_of(const struct expansion *e, double scale)
{
    double sum = 0;
    for (int i = 0; i < e->count; i++)
        sum += e->part[i] * scale;
    return sum;
}

/* The unit vector along three sums; false if they are zero. */
static bool direction_of(const struct expansion3 *sum, struct pen_vec3 *out)
{
    double largest = 0;
    for (int i = 0; i < 3; i++)
        largest = fmax(largest, fabs(value_of(&sum->c[i], 1)));
    if (largest == 0)
        return false;
    double scale = ldexp(1, -ilogb(largest));
    *out = pen_vec3(value_of(&sum->c[0], scale), value_of(&sum->c[1], scale),
                    value_of(&sum->c[2], scale));
    *out = pen_scale(*out, 1 / pen_length(*out));
    return true;
}

bool oracle_normal(const struct pen_vec3 *v, int count, struct pen_vec3 *n)
{
    struct expansion3 e, f, area;
    difference3(&e, v[count == 4 ? 2 : 1], v[0]);
    difference3(&f, v[count == 4 ? 3 : 2], v[count == 4 ? 1 : 0]);
    cross(&area, &e, &f);
    return direction_of(&area, n);
}

bool oracle_moved_normal(const struct pen_vec3 row[3], struct pen_vec3 n, struct pen_vec3 *out)
{
    const struct pen_vec3 zero = {0, 0, 0};
    struct expansion3 a, b, cofactors, factor, sum;
    difference3(&factor, n, zero);
    for (int i = 0; i < 3; i++) {
        difference3(&a, row[(i + 1) % 3], zero);
        difference3(&b, row[(i + 2) % 3], zero);
        cross(&cofactors, &a, &b);
        clear(&sum.c[i]);
        for (int j = 0; j < 3; j++)
            add_product(&sum.c[i], 1, &cofactors.c[j], &factor.c[j]);
    }
    return direction_of(&sum, out);
}

int oracle_above(struct pen_vec3 a, struct pen_vec3 b, struct pen_vec3 c, struct pen_vec3 p)
{
    struct expansion3 e, f, g;
    difference3(&e, b, a);
    difference3(&f, c, a);
    difference3(&g, p, a);
    return triple_of(&g, &e, &f);
}
