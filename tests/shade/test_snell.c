/* SPDX-License-Identifier: MIT */
/* Snell's law and Fresnel's reflectance against __float128. The result must be right, up to the
 * rounding of a few operations, for an angle of incidence within 4u of the given one. The given
 * directions do not determine the angle better. */
#include <math.h>

#include "shade/internal/snell.h"
#include "shade/optics.h"
#include "support/random.h"
#include "support/suite.h"

#define U 0x1p-53

typedef struct pen_vec3 vec3;

struct incidence {
    vec3 n, v;
    double n1, n2;
};

/* The same by the mathematics: n is unit, across is unit in the plane of incidence. */
struct frame {
    struct quad3 n, across;
    quad e, cosine, sine;
};

/* What is beyond the surface. */
struct truth {
    bool total;
    quad share;
    struct quad3 d;
};

static struct refracted refract(const struct incidence *in)
{
    const double nv = pen_dot(in->n, in->v);
    return lanes_refract(lanes3_splat(in->n), lanes3_splat(in->v), lanes_splat(nv),
                         lanes_splat(in->n1), lanes_splat(in->n2));
}

static bool is_total(const struct refracted *r)
{
    return lane_mask_bits(r->total) != 0;
}

/* Some unit vector at a right angle to n. */
static struct quad3 quad_beside(struct quad3 n)
{
    const struct quad3 x = {1, 0, 0}, y = {0, 1, 0};
    return quad_unit(quad_cross(n, quad_abs(n.x) < (quad)0.7 ? x : y));
}

static struct frame frame_of(const struct incidence *in)
{
    struct frame f = {.n = quad_unit(quad3(in->n)), .e = (quad)in->n1 / in->n2};
    const struct quad3 v = quad_unit(quad3(in->v));
    f.cosine = -quad_dot(f.n, v);
    const struct quad3 flat = quad_cross(quad_cross(f.n, v), f.n);
    f.sine = quad_length(flat);
    f.across = f.sine > 0 ? quad_scale(flat, 1 / f.sine) : quad_beside(f.n);
    return f;
}

/* Snell's law and Fresnel's equations at an angle of incidence that is larger by `more`. */
static struct truth truth_at(const struct frame *f, quad more)
{
    quad c = f->cosine * (1 - more * more / 2) - f->sine * more;
    quad s = f->sine * (1 - more * more / 2) + f->cosine * more;
    if (c < 0) {
        c = 0;
        s = 1;
    }
    if (f->e * quad_abs(s) >= 1)
        return (struct truth){.total = true, .share = 1, .d = f->across};
    const quad t = quad_sqrt(1 - f->e * f->e * s * s), e = f->e;
    const quad across = (e * c - t) / (e * c + t), along = (c - e * t) / (c + e * t);
    return (struct truth){.share = (across * across + along * along) / 2,
                          .d = quad_along(quad_scale(f->across, e * s), f->n, -t)};
}

/* The truth at the given angle, and within some distance to both sides of it. */
struct around {
    struct truth at, less, more;
    quad low, high; /* the least and the largest share there */
};

static void widen(struct around *a, quad share)
{
    a->low = share < a->low ? share : a->low;
    a->high = share > a->high ? share : a->high;
}

/* The share is monotonic on both sides of its least value, which is near Brewster's angle. */
static struct around around_of(const struct incidence *in, quad by)
{
    const struct frame f = frame_of(in);
    struct around a = {truth_at(&f, 0), truth_at(&f, -by), truth_at(&f, by), 2, 0};
    const quad brewster = (f.cosine - f.e * f.sine) / quad_sqrt(1 + f.e * f.e);
    widen(&a, a.at.share);
    widen(&a, a.less.share);
    widen(&a, a.more.share);
    if (quad_abs(brewster) < by)
        widen(&a, truth_at(&f, brewster).share);
    return a;
}

/* How far the reflectance is off, beyond what the angle does, in u of itself. */
static double share_off(double share, const struct around *a)
{
    const quad off = share < a->low ? a->low - share : share > a->high ? share - a->high : 0;
    return (double)(off / (U * a->at.share));
}

static double distance(struct quad3 a, struct quad3 b)
{
    return (double)quad_length(quad_sub(a, b));
}

/* The same for the direction, in u. The incident ray may also turn about the normal. */
static double direction_off(vec3 d, const struct around *a, double e)
{
    const double moved = fmax(distance(a->at.d, a->less.d), distance(a->at.d, a->more.d));
    return (distance(quad_unit(quad3(d)), a->at.d) - moved) / U - 4 * e;
}

/* What a few roundings may do. The refracted direction is a difference of vectors as long as e. */
static const double share_most = 24, direction_most = 8;

static double length_most(double e)
{
    return 16 * fmax(1, e);
}

static void assert_right(const struct incidence *in, const char *what)
{
    const struct around a = around_of(in, 4 * (quad)U);
    const struct refracted r = refract(in);
    const bool total = is_total(&r);
    const double share = lanes_at(r.fresnel, 0), e = in->n1 / in->n2;
    const vec3 d = lanes3_at(r.d, 0);
    ck_assert_msg(total || !a.less.total, "%s: %a / %a is not total", what, in->n1, in->n2);
    ck_assert_msg(!total || a.more.total, "%s: %a / %a is total", what, in->n1, in->n2);
    const double off = share_off(share, &a);
    ck_assert_msg(off <= share_most, "%s: %a / %a: %g is off by %g u", what, in->n1, in->n2, share,
                  off);
    if (total || a.at.total)
        return;
    const double turned = direction_off(d, &a, e);
    ck_assert_msg(turned <= direction_most, "%s: %a / %a: direction off by %g u", what, in->n1,
                  in->n2, turned);
    const double longer = fabs((double)(quad_length(quad3(d)) - 1)) / U;
    ck_assert_msg(longer <= length_most(e), "%s: %a / %a: length off by %g u", what, in->n1, in->n2,
                  longer);
}

/* An incidence with a cosine and a sine, in any orientation. */
static struct incidence incidence_at(struct random *r, double c, double s)
{
    struct incidence in = {.n = random_direction(r), .n1 = 1, .n2 = 1};
    const vec3 across = pen_normalize(pen_cross(in.n, random_direction(r)));
    in.v = pen_normalize(pen_along(pen_scale(across, s), in.n, -c));
    return in;
}

/* Common indices; nearly equal ones; extreme ones. */
static void set_indices(struct random *r, struct incidence *in, int kind)
{
    in->n1 = random_in(r, 1, 2.5);
    in->n2 = random_in(r, 1, 2.5);
    if (kind == 1) {
        const double off = pow(10, random_in(r, -13, -1));
        in->n2 = in->n1 * (random_bits(r) & 1 ? 1 + off : 1 - off);
    } else if (kind == 2) {
        in->n1 = pow(10, random_in(r, -3, 3));
        in->n2 = pow(10, random_in(r, -3, 3));
    }
    if (in->n1 == in->n2)
        in->n2 = random_nudge(in->n2, 1);
}

enum { ANGLES = 6, INDICES = 3 };
static const char *const angles[ANGLES] = {"any angle", "near normal", "normal",
                                           "grazing",   "Brewster",    "critical"};

/* An incidence of a kind of angle, between indices of a kind. */
static struct incidence any_incidence(struct random *r, int angle, int indices)
{
    struct incidence between;
    set_indices(r, &between, indices);
    const double e = between.n1 / between.n2, tiny = pow(10, random_in(r, -18, -1));
    double s = angle == 0 ? random_unit(r) : angle == 1 ? tiny : angle == 2 ? 0 : 1;
    double c = angle == 3 ? tiny : sqrt((1 - s) * (1 + s));
    if (angle == 4) {
        s = 1 / hypot(1, e);
        c = e * s;
    } else if (angle == 5 && e > 1) {
        s = random_nudge(1 / e, (int)random_below(r, 17) - 8);
        c = sqrt((1 - s) * (1 + s));
    }
    struct incidence in = incidence_at(r, c, s);
    in.n1 = between.n1;
    in.n2 = between.n2;
    return in;
}

START_TEST(test_snell__exact_for_an_angle_within_4u)
{
    struct random r = random_begin(501);
    for (int i = 0; i < random_cases(200000); i++) {
        const int angle = i / INDICES % ANGLES;
        const struct incidence in = any_incidence(&r, angle, i % INDICES);
        if (pen_dot(in.n, in.v) < 0)
            assert_right(&in, angles[angle]);
    }
}
END_TEST

/* H107: from glass into air with the sine k ulps from 1 / n. */
START_TEST(test_snell__h107_at_the_critical_angle)
{
    struct random r = random_begin(502);
    int totals = 0, others = 0;
    for (int k = -12; k <= 12; k++) {
        for (int i = 0; i < 2000; i++) {
            const double s = random_nudge(1 / 1.5, k);
            struct incidence in = incidence_at(&r, sqrt((1 - s) * (1 + s)), s);
            if (i == 0) {
                in.n = pen_vec3(0, 0, 1);
                in.v = pen_vec3(s, 0, -sqrt((1 - s) * (1 + s)));
            }
            in.n1 = 1.5;
            const struct refracted ray = refract(&in);
            assert_right(&in, "critical");
            ck_assert_int_eq(is_total(&ray), lanes_at(ray.fresnel, 0) == 1);
            ck_assert(is_total(&ray) || fabs(pen_dot(lanes3_at(ray.d, 0), in.n)) < 1e-6);
            totals += is_total(&ray);
            others += !is_total(&ray);
            ck_assert(k > -8 || !is_total(&ray));
            ck_assert(k < 8 || is_total(&ray));
        }
    }
    ck_assert_int_gt(totals, 10000);
    ck_assert_int_gt(others, 10000);
}
END_TEST

/* No more is reflected than there is, and what is refracted goes through the surface. */
START_TEST(test_snell__energy_is_kept)
{
    struct random r = random_begin(503);
    for (int i = 0; i < random_cases(1000000); i++) {
        const struct incidence in = any_incidence(&r, i / INDICES % ANGLES, i % INDICES);
        if (!(pen_dot(in.n, in.v) < 0))
            continue;
        const struct refracted ray = refract(&in);
        const double share = lanes_at(ray.fresnel, 0);
        const vec3 d = lanes3_at(ray.d, 0);
        ck_assert_msg(share >= 0 && share <= 1, "%a / %a: %a", in.n1, in.n2, share);
        ck_assert(!is_total(&ray) || share == 1);
        ck_assert(is_total(&ray) || (isfinite(d.x) && isfinite(d.y) && isfinite(d.z)));
        ck_assert(!is_total(&ray) || in.n1 > in.n2);
    }
}
END_TEST

/* A path and its reverse have one share. */
START_TEST(test_snell__shares_of_the_reversed_path)
{
    struct random r = random_begin(504);
    for (int i = 0; i < random_cases(100000); i++) {
        const struct incidence in = any_incidence(&r, i / INDICES % ANGLES, i % INDICES);
        const struct refracted ray = refract(&in);
        if (is_total(&ray) || !(pen_dot(in.n, in.v) < 0))
            continue;
        const vec3 back = pen_normalize(lanes3_at(ray.d, 0));
        const struct incidence reverse = {pen_neg(in.n), pen_neg(back), in.n2, in.n1};
        const struct refracted again = refract(&reverse);
        const struct around a = around_of(&in, 16 * (quad)U), b = around_of(&reverse, 16 * (quad)U);
        const double most = (double)(a.high - a.low + b.high - b.low);
        const double share = lanes_at(ray.fresnel, 0), other = lanes_at(again.fresnel, 0);
        ck_assert_msg(fabs(share - other) <= most + 2 * share_most * U * share,
                      "%a / %a, cosine %g: %a, reversed %a", in.n1, in.n2, -pen_dot(in.n, in.v),
                      share, other);
    }
}
END_TEST

PEN_SUITE("snell", test_snell__exact_for_an_angle_within_4u, test_snell__h107_at_the_critical_angle,
          test_snell__energy_is_kept, test_snell__shares_of_the_reversed_path)
