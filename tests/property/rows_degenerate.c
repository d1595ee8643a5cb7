/* SPDX-License-Identifier: MIT */
/* Primitives without area, primitives seen edge-on, and planes at any angle. */
#include "property/flat.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"

/* H045: triangles without area are refused, all others made; none ever gives a t that is no number.
 * Exponents down to where products vanish. */
static void draw_degenerate(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    double scale = random_below(r, 2) ? 1 : ldexp(1, (int)random_below(r, 1300) - 650);
    vec3 p[3] = {random_below(r, 2) ? gen_dyadic3(r, 4) : random_vec(r, 1)}, e = gen_dyadic3(r, 1);
    for (int i = 1; i < 3; i++)
        p[i] = pen_along(p[0], e, gen_dyadic(r, 2));
    switch (random_below(r, 4)) {
    case 0:
        p[2] = p[random_below(r, 2)];
        break;
    case 1:
        p[2] = gen_nudged(r, p[2]);
        break;
    default:
        break;
    }
    for (int i = 0; i < 3; i++)
        p[i] = pen_scale(p[i], scale);
    vec3 o = pen_scale(random_vec(r, 2), scale < 1e100 ? scale : 1);
    flat_put(c, p, 3, o, gen_toward(r, o, p[random_below(r, 3)]));
}

static void judge_degenerate(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12];
    struct oracle_ray line;
    struct pen_ray ray;
    double t = 0;
    bool made = false;
    if (flat_case(c, p, &line) == 0) {
        row_skip(v);
        return;
    }
    bool flat = oracle_collinear(p[0], p[1], p[2]), in_range = true, huge = false;
    for (int i = 0; i < 9; i++) { /* where products of differences stay in range */
        double x = fabs(pen_component(p[i / 3], i % 3));
        in_range = in_range && (x == 0 || (x < 0x1p200 && x > 0x1p-150));
        huge = huge || x >= 0x1p200;
    }
    /* With a direction out of range only how the primitive is made can be judged. */
    bool shot = pen_ray_make(&ray, line.o, line.d);
    struct pen_triangle triangle;
    made = pen_triangle_make(&triangle, p[0], p[1], p[2]);
    if (in_range)
        row_require(v, made == !flat, flat ? "no area, but made" : "an area, but refused");
    else
        row_require(v, !(flat && made), "no area, but made");
    row_tally(v, made ? "made" : "refused");
    if (shot && made && pen_triangle_root(&triangle, &ray, &t) && !huge)
        row_require(v, isfinite(t), "t is not finite");
}

void rows_degenerate(struct pen_row_run *run)
{
    row_each(run, draw_degenerate, judge_degenerate);
}

/* H046: pbrt's bad case, vertices on a line; and with vertices moved by a few ulps, still missed.
 */
static void draw_pbrt(struct row_draw *d, struct row_case *c)
{
    vec3 p[3] = {{-1113.45459, -79.049614, -56.2431908},
                 {-1113.45459, -87.0922699, -56.2431908},
                 {-1113.45459, -79.2090149, -56.2431908}};
    for (int i = 0; i < 3 && d->index > 0; i++)
        p[i] = gen_nudged(&d->random, p[i]);
    flat_put(c, p, 3, pen_vec3(-1081.47925, 99.9999542, 87.7701111),
             pen_vec3(-32.1072998, -183.355865, -144.607635));
}

static void judge_pbrt(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12];
    struct oracle_ray line;
    struct pen_ray ray;
    bool made = false;
    double t;
    int count = flat_case(c, p, &line);
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool unsure, exact = oracle_winding(p, count, line, 0, &unsure) != 0;
    row_require(v, flat_cross(p, count, &ray, &t, &made) == exact, "hit");
    row_require(v, !oracle_collinear(p[0], p[1], p[2]) || !made, "no area, but made");
}

void rows_pbrt(struct pen_row_run *run)
{
    row_each(run, draw_pbrt, judge_pbrt);
}

/* H048: a ray in the triangle's own plane. Where the shear is exact the area seen is exactly 0 and
 * nothing is hit; elsewhere the ray is off the plane by rounding, and t must still be sane. */
static void draw_edge_on(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    struct lattice l = flat_lattice(r);
    vec3 p[3];
    for (int i = 0; i < 3; i++)
        p[i] = flat_lattice_point(&l, gen_dyadic(r, 1), gen_dyadic(r, 1));
    vec3 o = flat_lattice_point(&l, gen_dyadic(r, 8), gen_dyadic(r, 8));
    vec3 direction = pen_along(pen_scale(l.e, gen_dyadic(r, 1)), l.f, gen_dyadic(r, 1));
    row_fixed(c, 3);
    for (int i = 0; i < 3; i++)
        row_arg3(c, p[i]);
    row_arg3(c, o);
    row_arg3(c, direction);
}

static bool power_of_two(double x)
{
    int e;
    return fabs(frexp(x, &e)) == .5;
}

static void judge_edge_on(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12];
    struct oracle_ray line;
    struct pen_ray ray;
    bool made = false;
    double t = 0;
    int count = flat_case(c, p, &line);
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    struct truth truth;
    if (oracle_plane(p, line, &truth)) {
        row_skip(v); /* made smaller, it left the plane */
        return;
    }
    bool hit = flat_cross(p, count, &ray, &t, &made);
    if (!made) {
        row_skip(v);
        return;
    }
    if (power_of_two(pen_component(line.d, ray.kz)))
        row_require(v, !hit, "hit edge-on with an exact shear");
    if (hit) {
        row_tally(v, "hit off the plane by rounding");
        row_require(v, isfinite(t) && oracle_depth_between(p, count, line, t, 8),
                    "t is outside the vertices' depths");
    }
}

void rows_edge_on(struct pen_row_run *run)
{
    row_each(run, draw_edge_on, judge_edge_on);
}

/* Planes, and H087: met at angles down to 1e-300. */
static void draw_plane(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    bool steep = random_below(r, 2);
    vec3 n = random_below(r, 4) ? random_direction(r) : gen_axial(r), x, y;
    gen_frame(r, pen_normalize(n), &x, &y);
    vec3 p = random_below(r, 2) ? random_vec(r, 1) : gen_offset3(gen_offset(r));
    vec3 to = pen_along(pen_along(p, x, gen_power(r, -3, 3)), y, gen_power(r, -3, 3));
    vec3 direction =
        steep ? random_direction(r)
              : pen_along(x, pen_normalize(n), -gen_power(r, random_below(r, 2) ? -300 : -16, 0));
    row_arg3(c, p);
    row_arg3(c, pen_scale(n, random_below(r, 2) ? 1 : gen_power(r, -30, 30)));
    row_arg3(c, pen_along(to, random_direction(r), gen_power(r, -3, 6)));
    row_arg3(c, direction);
}

static void judge_plane(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    vec3 p = row_next3(c, &at), n = row_next3(c, &at), o = row_next3(c, &at);
    struct pen_plane plane;
    struct pen_ray ray;
    struct truth truth;
    double t = 0;
    if (!pen_plane_make(&plane, p, n) || !pen_ray_make(&ray, o, row_next3(c, &at))) {
        row_skip(v);
        return;
    }
    bool hit = pen_plane_root(&plane, &ray, &t);
    bool exact = oracle_plane_at(p, n, (struct oracle_ray){ray.o, ray.d}, &truth);
    /* The plane and the ray, moved by a few u: the share of that which the point is off. */
    double dn = fabs(pen_dot(ray.d, n)) / pen_length(n), d = pen_length(ray.d);
    bool along = dn <= 8 * 0x1p-53 * d;
    if (!along)
        row_require(v, hit == exact, hit ? "false hit" : "false miss");
    if (hit)
        row_require(v, t == t, "t is no number");
    if (!hit || !exact || !isfinite(t) || along)
        return;
    double scale = pen_norm1(o) + pen_norm1(p) + fabs(t) * d;
    row_measure(v, "plane, off it [u]", truth_error(t, truth) * dn / (0x1p-53 * scale), 8);
    if (pen_norm1(p) < 2)
        row_measure(v, "plane near the origin, t [ulp]", truth_ulps(t, truth), -1);
}

void rows_plane(struct pen_row_run *run)
{
    row_each(run, draw_plane, judge_plane);
}
