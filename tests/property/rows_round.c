/* SPDX-License-Identifier: MIT */
/* Intersections of spheres, infinite cylinders and cylinders against 113 bits: the error of t, the
 * distance of the point from the surface, and wrong hits and misses. Rays that pass the primitive
 * in the outer tenth of its radius have their own rows, because t is badly conditioned there. */
#include "geom/prims.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"

/* A case: c, axis (infinite cylinder, cylinder), r, h (cylinder), o, d. */
struct prim {
    struct oracle_round b;
    struct oracle_ray line;
    struct pen_ray ray;
};

enum kind { SPHERE, TUBE, CYLINDER };

/* Which rays a row is about. */
enum aim { WITHIN, GRAZING, FAR_OFF };

static bool primitive_of(const struct row_case *c, enum kind kind, struct prim *prim)
{
    int at = 0;
    struct oracle_round b = {.c = row_next3(c, &at)};
    if (kind != SPHERE)
        b.a = row_next3(c, &at);
    b.r = fabs(row_next(c, &at));
    if (kind == CYLINDER)
        b.h = fabs(row_next(c, &at));
    prim->b = b;
    prim->line.o = row_next3(c, &at);
    prim->line.d = row_next3(c, &at);
    if (kind != SPHERE && pen_norm1(b.a) == 0)
        return false;
    return pen_ray_make(&prim->ray, prim->line.o, prim->line.d);
}

static double distance_of(struct random *r)
{
    static const double near[] = {0, .5, 1 + 1e-9, 1 - 1e-12, 1.5};
    uint32_t what = random_below(r, 4);
    return what == 0   ? near[random_below(r, 5)]
           : what == 1 ? random_in(r, 0, 3)
                       : gen_power(r, .30103, 8);
}

static double radius_of(struct random *r)
{
    return random_below(r, 2) ? random_in(r, .1, 1) : gen_power(r, -6, 6);
}

/* Tubes anywhere have a row of their own: the others are within a few radii of the origin. */
static vec3 middle_of(struct random *r, enum kind kind, enum aim aim, double radius)
{
    if (kind == TUBE && aim != FAR_OFF)
        return random_vec(r, 4 * radius);
    return random_below(r, 2) ? random_vec(r, 1) : gen_offset3(gen_offset(r));
}

static double passing_of(struct random *r, enum aim aim)
{
    double b;
    do
        b = gen_passing(r);
    while ((b >= .9) != (aim == GRAZING));
    return b;
}

/* G6: nothing is of the size of anything else; the ray goes to a point of the primitive, or near
 * it. */
static vec3 draw_wide(struct random *r, double *radius, vec3 *o, vec3 *d)
{
    vec3 at = gen_wide3(r, 30);
    *radius = ldexp(1 + random_unit(r), (int)random_below(r, 61) - 30);
    *o = gen_wide3(r, 30);
    *d = gen_toward(r, *o, pen_along(at, random_vec(r, 1), *radius));
    return at;
}

static void draw_sphere(struct random *r, enum aim aim, struct row_case *c)
{
    double radius = radius_of(r);
    vec3 at = middle_of(r, SPHERE, aim, radius), o, d;
    if (random_below(r, 8) == 0)
        at = draw_wide(r, &radius, &o, &d);
    else
        gen_grazing(r, at, radius, distance_of(r), passing_of(r, aim), &o, &d);
    row_arg3(c, at);
    row_arg(c, radius);
    row_arg3(c, o);
    row_arg3(c, d);
}

/* A ray that passes the axis: in the plane across it as for a circle, and along it at any slope
 * (G4). */
static void draw_past_axis(struct random *r, vec3 at, vec3 axis, double radius, double b, vec3 *o,
                           vec3 *d)
{
    vec3 n = pen_normalize(axis), x, y;
    double far = distance_of(r), slope = random_below(r, 2) ? random_in(r, -2, 2) : 0;
    gen_frame(r, n, &x, &y);
    if (random_below(r, 3) == 0)
        slope = gen_power(r, 0, 9) * (random_below(r, 2) ? 1 : -1);
    double sine = b < far ? b / far : 1, cosine = sqrt((1 - sine) * (1 + sine));
    if (far < 1 && random_below(r, 2))
        cosine = -cosine;
    *o = pen_along(at, x, far * radius);
    vec3 across = pen_along(pen_scale(x, -cosine), y, sine);
    *d = gen_toward(r, pen_vec3(0, 0, 0), pen_along(across, n, slope));
}

static void draw_tube(struct random *r, enum aim aim, struct row_case *c)
{
    double radius = radius_of(r);
    vec3 at = middle_of(r, TUBE, aim, radius), o, d;
    vec3 axis = random_below(r, 4) ? random_direction(r) : gen_axial(r);
    if (aim == FAR_OFF && random_below(r, 8) == 0)
        at = draw_wide(r, &radius, &o, &d);
    else
        draw_past_axis(r, at, axis, radius, passing_of(r, aim), &o, &d);
    row_arg3(c, at);
    row_arg3(c, axis);
    row_arg(c, radius);
    row_arg3(c, o);
    row_arg3(c, d);
}

/* Rays at the rims, at the side, and at the caps, from outside and inside. */
static void draw_cylinder(struct random *r, enum aim aim, struct row_case *c)
{
    double radius = radius_of(r), h = radius * gen_power(r, -2, 2);
    vec3 at = middle_of(r, CYLINDER, aim, radius), o, d, x, y;
    vec3 axis = random_below(r, 4) ? random_direction(r) : gen_axial(r);
    vec3 n = pen_normalize(axis);
    gen_frame(r, n, &x, &y);
    if (random_below(r, 8) == 0) {
        at = draw_wide(r, &radius, &o, &d);
    } else if (aim == GRAZING || random_below(r, 2)) {
        draw_past_axis(r, pen_along(at, n, h * random_unit(r)), axis, radius, passing_of(r, aim),
                       &o, &d);
    } else {
        double out = random_below(r, 2) ? 1 : sqrt(random_unit(r));
        vec3 rim = pen_along(pen_along(at, n, random_below(r, 2) ? h : 0), x, out * radius);
        double far = distance_of(r) * (radius + h);
        o = pen_along(pen_along(at, n, h / 2), random_direction(r), far);
        d = gen_toward(r, o, gen_nudged(r, rim));
    }
    row_arg3(c, at);
    row_arg3(c, axis);
    row_arg(c, radius);
    row_arg(c, h);
    row_arg3(c, o);
    row_arg3(c, d);
}

/* The names of what is measured, and the bar in ulp of t from two radii away. */
struct bars {
    const char *far, *near, *residual;
    double ulps;
};

static const struct bars bars[] = {
    {"sphere, D >= 2r [ulp]", "sphere, D < 2r [u(|f|+r)]", "sphere, off the surface [u]", 5},
    {"tube, D >= 2r [ulp]", "tube, D < 2r [u(|f|+r)]", "tube, off the surface [u]", 16},
    {"cylinder side, D >= 2r [ulp]", "cylinder side, D < 2r [u(|f|+r)]", "", 16},
    {"cylinder cap, D >= 2r [ulp]", "cylinder cap, D < 2r [u(|f|+r)]", "", 16},
};

/* How fast the ray comes nearer to the part, per t: its speed in the plane across the axis, or
 * along the axis. */
static double speed(const struct prim *prim, enum oracle_part part)
{
    vec3 a = prim->b.a, d = prim->line.d;
    if (pen_norm1(a) == 0)
        return pen_length(d);
    if (part != ORACLE_SIDE)
        return fabs(pen_dot(d, a)) / pen_length(a);
    return pen_length(pen_cross(d, a)) / pen_length(a);
}

/* One intersection against its truth. Nearer than two radii the bar is 8u (|f| + r), across the
 * axis for a side and along it for a cap. A cap may be many radii away all the same, at the far end
 * of a long cylinder: where `ulps` of t are more than that, those count, since no double is
 * nearer. */
static void compare(struct row_verdict *v, const struct bars *bar, const struct prim *prim,
                    enum oracle_part part, double t, struct truth truth)
{
    double ulps = truth_ulps(t, truth), error = truth_error(t, truth) * speed(prim, part);
    if (oracle_distance(&prim->b, prim->line) >= 2) {
        row_measure(v, bar->far, ulps, bar->ulps);
        return;
    }
    double f = pen_length(pen_sub(prim->line.o, prim->b.c));
    double share = error / (0x1p-53 * (f + prim->b.r)), long_share = ulps * 8 / bar->ulps;
    row_measure(v, bar->near, part != ORACLE_SIDE && long_share < share ? long_share : share, 8);
}

/* Hit or miss: wrong only where BE(8) allows; true if there are roots to compare. */
static bool decided(struct row_verdict *v, bool hit, int class, bool exact)
{
    if (class != 0 && hit != (class > 0))
        row_fail(v, hit ? "false hit" : "false miss");
    else if (hit != exact)
        row_tally(v, hit ? "false hit within BE(8)" : "false miss within BE(8)");
    return hit && exact;
}

static void judge_pair(struct row_verdict *v, enum kind kind, const struct prim *prim, bool hit,
                       const double t[2])
{
    struct oracle_roots truth;
    oracle_sphere(&prim->b, prim->line, &truth);
    if (!decided(v, hit, oracle_sphere_class(&prim->b, prim->line, 8), truth.count == 2))
        return;
    for (int i = 0; i < 2; i++) {
        compare(v, &bars[kind], prim, ORACLE_SIDE, t[i], truth.t[i]);
        row_measure(v, bars[kind].residual, oracle_round_residual(&prim->b, prim->line, t[i]), 8);
    }
}

static void judge_sphere(const struct row_case *c, struct row_verdict *v)
{
    struct prim prim;
    struct pen_sphere s;
    double t[2];
    if (!primitive_of(c, SPHERE, &prim) || !pen_sphere_make(&s, prim.b.c, prim.b.r))
        row_skip(v);
    else
        judge_pair(v, SPHERE, &prim, pen_sphere_roots(&s, &prim.ray, t), t);
}

static void judge_tube(const struct row_case *c, struct row_verdict *v)
{
    struct prim prim;
    struct pen_infinite_cylinder infinite_cylinder;
    double t[2];
    bool parallel;
    if (!primitive_of(c, TUBE, &prim) ||
        !pen_infinite_cylinder_make(&infinite_cylinder, prim.b.c, prim.b.a, prim.b.r)) {
        row_skip(v);
        return;
    }
    judge_pair(v, TUBE, &prim,
               pen_cylinder_side_roots(&infinite_cylinder.round, &prim.ray, t, &parallel), t);
}

/* Which intersections of a cylinder a row measures. */
enum measured { SIDES_WITHIN, SIDES_GRAZING, CAPS };

static bool measures(enum measured what, const struct prim *prim, enum oracle_part part)
{
    if (part != ORACLE_SIDE || what == CAPS)
        return part != ORACLE_SIDE && what == CAPS;
    return (oracle_passing(&prim->b, prim->line) >= .9) == (what == SIDES_GRAZING);
}

static void judge_cylinder_parts(const struct row_case *c, struct row_verdict *v,
                                 enum measured what)
{
    struct prim prim;
    struct pen_cylinder cylinder;
    struct pen_interval in;
    struct oracle_roots truth;
    if (!primitive_of(c, CYLINDER, &prim) ||
        !pen_cylinder_make(&cylinder, prim.b.c, prim.b.a, prim.b.r, prim.b.h, true)) {
        row_skip(v);
        return;
    }
    bool hit = pen_cylinder_interval(&cylinder, &prim.ray, &in);
    oracle_cylinder(&prim.b, prim.line, &truth);
    if (!decided(v, hit, oracle_cylinder_class(&prim.b, prim.line, 8), truth.count == 2))
        return;
    for (int i = 0; i < 2; i++) {
        /* Where either says that it is a cap, it is one: at the rim both are right. */
        uint8_t said = i ? in.hi_part : in.lo_part;
        enum oracle_part part = said == PEN_PART_SIDE ? truth.part[i] : (enum oracle_part)said;
        if (measures(what, &prim, part))
            compare(v, &bars[what == CAPS ? 3 : 2], &prim, part, i ? in.hi : in.lo, truth.t[i]);
    }
}

static void judge_cylinder(const struct row_case *c, struct row_verdict *v)
{
    judge_cylinder_parts(c, v, SIDES_WITHIN);
}

static void judge_cylinder_grazing(const struct row_case *c, struct row_verdict *v)
{
    judge_cylinder_parts(c, v, SIDES_GRAZING);
}

static void judge_caps(const struct row_case *c, struct row_verdict *v)
{
    judge_cylinder_parts(c, v, CAPS);
}

typedef void kind_fn(struct random *r, enum aim aim, struct row_case *c);

static kind_fn *const draw_kind[3] = {draw_sphere, draw_tube, draw_cylinder};

static void draw_sphere_within(struct row_draw *d, struct row_case *c)
{
    draw_sphere(&d->random, WITHIN, c);
}

static void draw_sphere_grazing(struct row_draw *d, struct row_case *c)
{
    draw_sphere(&d->random, GRAZING, c);
}

static void draw_tube_within(struct row_draw *d, struct row_case *c)
{
    draw_tube(&d->random, WITHIN, c);
}

static void draw_tube_grazing(struct row_draw *d, struct row_case *c)
{
    draw_tube(&d->random, GRAZING, c);
}

static void draw_tube_far(struct row_draw *d, struct row_case *c)
{
    draw_tube(&d->random, FAR_OFF, c);
}

static void draw_cylinder_within(struct row_draw *d, struct row_case *c)
{
    draw_cylinder(&d->random, WITHIN, c);
}

static void draw_cylinder_grazing(struct row_draw *d, struct row_case *c)
{
    draw_cylinder(&d->random, GRAZING, c);
}

void rows_sphere_roots(struct pen_row_run *run)
{
    row_each(run, draw_sphere_within, judge_sphere);
}

void rows_sphere_grazing(struct pen_row_run *run)
{
    row_each(run, draw_sphere_grazing, judge_sphere);
}

void rows_tube_roots(struct pen_row_run *run)
{
    row_each(run, draw_tube_within, judge_tube);
}

void rows_tube_grazing(struct pen_row_run *run)
{
    row_each(run, draw_tube_grazing, judge_tube);
}

void rows_tube_far(struct pen_row_run *run)
{
    row_each(run, draw_tube_far, judge_tube);
}

void rows_cylinder_roots(struct pen_row_run *run)
{
    row_each(run, draw_cylinder_within, judge_cylinder);
}

void rows_cylinder_caps(struct pen_row_run *run)
{
    row_each(run, draw_cylinder_within, judge_caps);
}

void rows_cylinder_grazing(struct pen_row_run *run)
{
    row_each(run, draw_cylinder_grazing, judge_cylinder_grazing);
}

/* The oracle's 113 bits against 400, by another formula. */
static void draw_any(struct row_draw *d, struct row_case *c)
{
    uint32_t kind = random_below(&d->random, 2);
    row_fixed(c, kind);
    draw_kind[kind](&d->random, random_below(&d->random, 2) ? GRAZING : WITHIN, c);
}

static void judge_oracle(const struct row_case *c, struct row_verdict *v)
{
    struct row_case rest = {.count = c->count - 1};
    struct oracle_roots quad, mpfr;
    struct prim prim;
    for (int i = 0; i < rest.count; i++)
        rest.arg[i] = c->arg[i + 1];
    if (!primitive_of(&rest, c->arg[0] != 0 ? TUBE : SPHERE, &prim) || !(prim.b.r > 0)) {
        row_skip(v);
        return;
    }
    if (!oracle_mpfr_roots(&prim.b, prim.line, &mpfr)) {
        row_tally(v, "not compared: built without MPFR");
        return;
    }
    oracle_sphere(&prim.b, prim.line, &quad);
    if (oracle_sphere_class(&prim.b, prim.line, 0x1p-40) == 0)
        return; /* a tangent, to 2^-93 */
    row_require(v, quad.count == mpfr.count, "hit or miss");
    for (int i = 0; i < quad.count && i < mpfr.count; i++) {
        double off = (quad.t[i].hi - mpfr.t[i].hi) + (quad.t[i].lo - mpfr.t[i].lo);
        double size = fabs(mpfr.t[i].hi);
        double ulp = nextafter(size, INFINITY) - size;
        row_measure(v, "113 bits against 400 [ulp]", fabs(off) / ulp, 0x1p-6);
    }
}

void rows_oracle(struct pen_row_run *run)
{
    row_each(run, draw_any, judge_oracle);
}
