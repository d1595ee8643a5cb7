/* SPDX-License-Identifier: MIT */
#include "property/gen.h"

#include "math/exact.h"

typedef struct pen_vec3 vec3;

vec3 gen_nudged(struct random *r, vec3 p)
{
    static const int step[] = {0, 0, 0, 0, 1, -1, 2, -2, 64, -64};
    if (random_below(r, 2))
        return p;
    int i = step[random_below(r, 10)], j = step[random_below(r, 10)], k = step[random_below(r, 10)];
    return pen_vec3(p.x == 0 ? 0 : random_nudge(p.x, i), p.y == 0 ? 0 : random_nudge(p.y, j),
                    p.z == 0 ? 0 : random_nudge(p.z, k));
}

vec3 gen_on_edge(struct random *r, vec3 a, vec3 b)
{
    const vec3 e = pen_sub(b, a);
    switch (random_below(r, 4)) {
    case 0:
        return a;
    case 1:
        return pen_along(a, e, random_unit(r));
    case 2:
        return pen_along(a, e, random_below(r, 17) / 16.);
    default:
        return gen_nudged(r, pen_along(a, e, random_below(r, 2) ? .5 : random_unit(r)));
    }
}

vec3 gen_toward(struct random *r, vec3 o, vec3 to)
{
    vec3 d = pen_sub(to, o);
    if (pen_norm1(d) == 0)
        return random_direction(r);
    switch (random_below(r, 3)) {
    case 0:
        return d;
    case 1:
        return pen_normalize(d);
    default:
        return pen_scale(d, exp2((int)random_below(r, 81) - 40));
    }
}

double gen_power(struct random *r, double lo, double hi)
{
    return pow(10, random_in(r, lo, hi));
}

double gen_passing(struct random *r)
{
    uint32_t what = random_below(r, 4);
    if (what == 0)
        return random_in(r, 0, 1.1);
    if (what == 1)
        return sqrt(random_unit(r)); /* uniform over the disc */
    double k = pow(10, -(double)(1 + random_below(r, 16)));
    return random_below(r, 2) ? 1 - k : 1 + k;
}

void gen_frame(struct random *r, vec3 n, vec3 *x, vec3 *y)
{
    vec3 c;
    do
        c = pen_cross(n, random_direction(r));
    while (pen_norm1(c) < 0.1);
    *x = pen_normalize(c);
    *y = pen_cross(n, *x);
}

void gen_grazing(struct random *r, vec3 c, double radius, double far, double passing, vec3 *o,
                 vec3 *d)
{
    vec3 u = random_direction(r), x, y;
    gen_frame(r, u, &x, &y);
    *o = pen_along(c, u, far * radius);
    double sine = passing < far ? passing / far : 1, cosine = sqrt((1 - sine) * (1 + sine));
    if (far < 1 && random_below(r, 2))
        cosine = -cosine;
    vec3 to = pen_along(pen_scale(u, -cosine), x, sine);
    *d = gen_toward(r, pen_vec3(0, 0, 0), to);
}

vec3 gen_near_parallel(struct random *r, vec3 a, double most)
{
    vec3 n = pen_normalize(a), x, y;
    gen_frame(r, n, &x, &y);
    double angle = pow(10, -random_in(r, 0, most));
    vec3 d = pen_along(pen_scale(n, random_below(r, 2) ? 1 : -1), x, angle);
    return pen_normalize(d);
}

double gen_dyadic(struct random *r, int half)
{
    return ((double)random_below(r, (uint32_t)(32 * half + 1)) - 16 * half) / 16;
}

vec3 gen_dyadic3(struct random *r, int half)
{
    double x = gen_dyadic(r, half), y = gen_dyadic(r, half);
    return pen_vec3(x, y, gen_dyadic(r, half));
}

double gen_wide(struct random *r, int most)
{
    double x = random_in(r, -1, 1);
    return ldexp(x, (int)random_below(r, (uint32_t)(2 * most + 1)) - most);
}

vec3 gen_wide3(struct random *r, int most)
{
    double x = gen_wide(r, most), y = gen_wide(r, most);
    return pen_vec3(x, y, gen_wide(r, most));
}

vec3 gen_axial(struct random *r)
{
    static const double value[] = {0.0, -0.0, 1, -1, 0.0, -0.0};
    for (;;) {
        double x = value[random_below(r, 6)], y = value[random_below(r, 6)];
        vec3 d = pen_vec3(x, y, value[random_below(r, 6)]);
        if (pen_norm1(d) > 0)
            return d;
    }
}

double gen_offset(struct random *r)
{
    static const double offset[] = {0, 1e3, 1e6, 1e9};
    return offset[random_below(r, 4)];
}

vec3 gen_offset3(double size)
{
    return pen_vec3(size, -.37 * size, 1.7 * size);
}
