/* SPDX-License-Identifier: MIT */
/* Round primitives in 113 bits. A line crosses a sphere or an infinite cylinder where its distance
 * from the centre or the axis is r. The distance is computed from a cross product (Lagrange's
 * identity), so large squares are never subtracted. */
#include "property/oracle_quad.h"

const char *oracle_arithmetic(void)
{
#if LDBL_MANT_DIG == 113
    return "long double, 113 bits";
#else
    return "__float128, 113 bits";
#endif
}

double truth_error(double x, struct truth t)
{
    return fabs((x - t.hi) - t.lo);
}

double truth_ulps(double x, struct truth t)
{
    double size = fabs(t.hi);
    return truth_error(x, t) / (nextafter(size, (double)INFINITY) - size);
}

double truth_units(double x, struct truth t)
{
    return truth_error(x, t) / (0x1p-53 * fabs(t.hi));
}

/* A line and a circle or sphere around 0: positions f + t d, in the plane where that is so. */
struct planar {
    struct quad3 f, d;
    quad size; /* of lengths in this plane over lengths in space */
};

static bool is_tube(const struct oracle_round *b)
{
    return b->a.x != 0 || b->a.y != 0 || b->a.z != 0;
}

/* Across the axis (turned by a right angle, times |a|), or space itself. */
static struct planar planar_of(const struct oracle_round *b, struct oracle_ray ray)
{
    struct planar p = {q_sub(q3(ray.o), q3(b->c)), q3(ray.d), 1};
    if (is_tube(b)) {
        struct quad3 a = q3(b->a);
        p = (struct planar){q_cross(p.f, a), q_cross(p.d, a), q_length(a)};
    }
    return p;
}

/* Intersections with radius r; false if there are none. */
static bool planar_roots(const struct planar *p, quad r, quad t[2])
{
    struct quad3 cross = q_cross(p->f, p->d);
    quad a = q_dot(p->d, p->d), rr = r * p->size * (r * p->size);
    quad disc = rr * a - q_dot(cross, cross);
    if (!(disc > 0) || a == 0)
        return false;
    quad h = q_sqrt(disc) / a, tp = -q_dot(p->f, p->d) / a;
    t[0] = tp - h;
    t[1] = tp + h;
    return true;
}

static void give(struct oracle_roots *out, bool crossed, const quad t[2])
{
    out->count = crossed ? 2 : 0;
    for (int i = 0; i < out->count; i++) {
        out->t[i] = q_truth(t[i]);
        out->part[i] = ORACLE_SIDE;
    }
}

void oracle_sphere(const struct oracle_round *b, struct oracle_ray ray, struct oracle_roots *out)
{
    struct planar p = planar_of(b, ray);
    quad t[2];
    give(out, planar_roots(&p, b->r, t), t);
}

void oracle_tube(const struct oracle_round *b, struct oracle_ray ray, struct oracle_roots *out)
{
    oracle_sphere(b, ray, out);
}

struct interval {
    quad t[2];
    enum oracle_part part[2];
};

/* Between the planes (p - c).a = lo |a| and = hi |a|; false if there is nothing. */
static bool slab_of(const struct oracle_round *b, struct oracle_ray ray, quad lo, quad hi,
                    struct interval *in)
{
    struct quad3 a = q3(b->a);
    quad length = q_length(a), da = q_dot(q3(ray.d), a);
    quad fa = q_dot(q_sub(q3(ray.o), q3(b->c)), a);
    quad base = lo * length - fa, top = hi * length - fa;
    bool up = da > 0;
    if (da == 0) {
        *in = (struct interval){{-(quad)INFINITY, (quad)INFINITY}, {ORACLE_BASE, ORACLE_TOP}};
        return base < 0 && top > 0;
    }
    in->t[!up] = base / da;
    in->t[up] = top / da;
    in->part[!up] = ORACLE_BASE;
    in->part[up] = ORACLE_TOP;
    return true;
}

/* The inside of a capped cylinder whose radius and ends are moved outward by `grow`. */
static bool inside_of(const struct oracle_round *b, struct oracle_ray ray, quad grow,
                      struct interval *in)
{
    struct planar p = planar_of(b, ray);
    quad side[2], r = b->r + grow;
    if (!slab_of(b, ray, -grow, b->h + grow, in))
        return false;
    if (q_dot(p.d, p.d) == 0)
        return q_dot(p.f, p.f) < r * r * p.size * p.size;
    if (!planar_roots(&p, r, side))
        return false;
    for (int end = 0; end < 2; end++) {
        if (end ? side[1] < in->t[1] : side[0] > in->t[0]) {
            in->t[end] = side[end];
            in->part[end] = ORACLE_SIDE;
        }
    }
    return in->t[0] < in->t[1];
}

void oracle_cylinder(const struct oracle_round *b, struct oracle_ray ray, struct oracle_roots *out)
{
    struct interval in;
    bool crossed = inside_of(b, ray, 0, &in);
    give(out, crossed, in.t);
    for (int i = 0; i < out->count; i++)
        out->part[i] = in.part[i];
}

/* u (size of the primitive + distance + for an infinite cylinder the distance to the closest
 * approach). */
static quad looseness(const struct oracle_round *b, struct oracle_ray ray)
{
    struct planar p = planar_of(b, ray);
    struct quad3 f = q_sub(q3(ray.o), q3(b->c));
    quad a = q_dot(p.d, p.d), approach = 0;
    if (a > 0)
        approach = q_abs(q_dot(p.f, p.d)) / a * q_length(q3(ray.d));
    return U * (b->r + b->h + q_length(f) + (is_tube(b) ? approach : 0));
}

static int class_of(bool grown, bool shrunk)
{
    return shrunk ? 1 : grown ? 0 : -1;
}

int oracle_sphere_class(const struct oracle_round *b, struct oracle_ray ray, double k)
{
    struct planar p = planar_of(b, ray);
    quad slack = k * looseness(b, ray), t[2];
    bool shrunk = b->r > slack && planar_roots(&p, b->r - slack, t);
    return class_of(planar_roots(&p, b->r + slack, t), shrunk);
}

int oracle_tube_class(const struct oracle_round *b, struct oracle_ray ray, double k)
{
    return oracle_sphere_class(b, ray, k);
}

int oracle_cylinder_class(const struct oracle_round *b, struct oracle_ray ray, double k)
{
    quad slack = k * looseness(b, ray);
    struct interval in;
    bool shrunk = b->r > slack && b->h > 2 * slack && inside_of(b, ray, -slack, &in);
    return class_of(inside_of(b, ray, slack, &in), shrunk);
}

double oracle_passing(const struct oracle_round *b, struct oracle_ray ray)
{
    struct planar p = planar_of(b, ray);
    quad d = q_length(p.d), f = d == 0 ? q_length(p.f) : q_length(q_cross(p.f, p.d)) / d;
    return (double)(f / (p.size * b->r));
}

double oracle_distance(const struct oracle_round *b, struct oracle_ray ray)
{
    struct planar p = planar_of(b, ray);
    return (double)(q_length(p.f) / (p.size * b->r));
}

double oracle_round_residual(const struct oracle_round *b, struct oracle_ray ray, double t)
{
    struct planar p = planar_of(b, ray);
    quad off = q_abs(q_length(q_along(p.f, p.d, t)) / p.size - b->r);
    quad scale = q_length(q_sub(q3(ray.o), q3(b->c))) + b->r + q_abs(t) * q_length(q3(ray.d));
    return (double)(off / (U * scale));
}

static quad chord_of(const struct planar *p)
{
    quad a = q_dot(p->d, p->d);
    return a == 0 ? 0 : -2 * q_dot(p->f, p->d) / a;
}

struct truth oracle_chord(const struct oracle_round *b, struct oracle_ray ray)
{
    struct planar p = planar_of(b, ray);
    return q_truth(chord_of(&p));
}

bool oracle_way_out(const struct oracle_round *b, enum oracle_part part, struct oracle_ray ray,
                    struct truth *t, enum oracle_part *at)
{
    struct planar p = planar_of(b, ray);
    struct interval slab;
    quad side[2] = {0, 0}, da = q_dot(q3(ray.d), q3(b->a));
    bool between = slab_of(b, ray, 0, b->h, &slab);
    if (part == ORACLE_SIDE)
        side[1] = chord_of(&p);
    else if (part == ORACLE_BASE ? !(da > 0) : !(da < 0))
        return false;
    else if (q_dot(p.d, p.d) == 0)
        side[1] = (quad)INFINITY;
    else if (!planar_roots(&p, b->r, side))
        return false;
    if (side[1] <= 0 || (da == 0 && !between))
        return false;
    *at = side[1] < slab.t[1] ? ORACLE_SIDE : slab.part[1];
    *t = q_truth(*at == ORACLE_SIDE ? side[1] : slab.t[1]);
    return true;
}
