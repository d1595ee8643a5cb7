/* SPDX-License-Identifier: MIT */
/* Cones in 113 bits. With f(t) = o - q + t d, let x(t) = f.a / |a| be the height over the base and
 * y(t) = |f x a| / |a| the distance from the axis. Inside is where 0 <= x <= h and y <= r(x) = r_0
 * + (r_1 - r_0) x / h. */
#include "property/oracle_quad.h"

struct half {
    quad lo, hi;
};

/* Where c + t g >= 0. */
static struct half above(quad c, quad g)
{
    quad far = (quad)INFINITY;
    if (g == 0)
        return c >= 0 ? (struct half){-far, far} : (struct half){far, -far};
    return g > 0 ? (struct half){-c / g, far} : (struct half){-far, -c / g};
}

/* Where y^2 <= r^2 on the nappe with r >= 0: a t^2 + 2 b t + c <= 0, r = w + t k. */
static struct half inside_side(quad a, quad b, quad c, quad w, quad k)
{
    struct half nappe = above(w, k), none = {1, -1}, side = nappe;
    quad disc = b * b - a * c;
    if (disc < 0 && a > 0)
        return none;
    quad root = disc > 0 ? q_sqrt(disc) : 0, /* a line with a <= 0 meets the double cone */
        q = b < 0 ? root - b : -root - b;
    quad t[2] = {a == 0 ? -(quad)INFINITY : q / a, q == 0 ? 0 : c / q};
    quad lo = t[0] < t[1] ? t[0] : t[1], hi = t[0] < t[1] ? t[1] : t[0];
    if (a > 0)
        side = (struct half){lo, hi};
    else if (a == 0 && b == 0)
        return c < 0 ? nappe : none;
    else if (a == 0)
        side = b > 0 ? (struct half){nappe.lo, t[1]} : (struct half){t[1], nappe.hi};
    else if (k > 0)
        side = (struct half){hi, nappe.hi};
    else
        side = (struct half){nappe.lo, lo};
    side.lo = side.lo > nappe.lo ? side.lo : nappe.lo;
    side.hi = side.hi < nappe.hi ? side.hi : nappe.hi;
    return side;
}

/* The inside of a cone whose surfaces are moved outward by `grow`. */
static bool inside_of(const struct oracle_cone *b, struct oracle_ray ray, quad grow, quad t[2],
                      enum oracle_part part[2])
{
    struct quad3 a = q3(b->a), d = q3(ray.d), f = q_sub(q3(ray.o), q3(b->q));
    quad length = q_length(a), da = q_dot(d, a) / length, fa = q_dot(f, a) / length;
    quad slope = ((quad)b->r[1] - b->r[0]) / b->h;
    quad w = b->r[0] + slope * fa + grow * q_sqrt(1 + slope * slope), k = slope * da;
    struct quad3 m = q_cross(d, a), n = q_cross(f, a);
    quad square = length * length;
    struct half base = above(fa + grow, da), top = above(b->h + grow - fa, -da);
    struct half side = inside_side(q_dot(m, m) / square - k * k, q_dot(m, n) / square - k * w,
                                   q_dot(n, n) / square - w * w, w, k);
    struct half slab = {base.lo > top.lo ? base.lo : top.lo, base.hi < top.hi ? base.hi : top.hi};
    t[0] = side.lo > slab.lo ? side.lo : slab.lo;
    t[1] = side.hi < slab.hi ? side.hi : slab.hi;
    part[0] = side.lo > slab.lo ? ORACLE_SIDE : da > 0 ? ORACLE_BASE : ORACLE_TOP;
    part[1] = side.hi < slab.hi ? ORACLE_SIDE : da > 0 ? ORACLE_TOP : ORACLE_BASE;
    return t[0] < t[1];
}

void oracle_cone(const struct oracle_cone *b, struct oracle_ray ray, struct oracle_roots *out)
{
    quad t[2];
    out->count = inside_of(b, ray, 0, t, out->part) ? 2 : 0;
    for (int i = 0; i < out->count; i++)
        out->t[i] = q_truth(t[i]);
}

int oracle_cone_class(const struct oracle_cone *b, struct oracle_ray ray, double k)
{
    double r = b->r[0] > b->r[1] ? b->r[0] : b->r[1];
    quad t[2], slack = k * U * (r + b->h + q_length(q_sub(q3(ray.o), q3(b->q))));
    enum oracle_part part[2];
    if (b->h > 2 * slack && inside_of(b, ray, -slack, t, part))
        return 1;
    return inside_of(b, ray, slack, t, part) ? 0 : -1;
}

double oracle_cone_reach(const struct oracle_cone *b, struct pen_vec3 n)
{
    struct quad3 a = q3(b->a), m = q3(n);
    quad length = q_length(a), along = q_dot(m, a) / length;
    quad rim = q_length(q_cross(m, a)) / length, at = q_dot(m, q3(b->q));
    quad base = at + b->r[0] * rim, top = at + b->r[1] * rim + along * b->h;
    return (double)(base > top ? base : top);
}
