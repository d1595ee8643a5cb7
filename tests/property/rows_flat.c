/* SPDX-License-Identifier: MIT */
/* Triangles, polygons and planes one at a time: hit or miss against the exact winding, depth
 * against 113 bits. */
#include "pen/geom/prims.h"
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"

struct flat_names {
    const char *error, *near, *residual;
    double bar; /* of the error, in u of t */
};

/* Below this cosine of the angle to the normal a ray grazes: t is badly conditioned, and such rays
 * are rows of their own. */
#define GRAZING 0.1

/* A case: count (fixed), vertices, o, d. */
static int outline_of(const struct row_case *c, vec3 *v, struct oracle_ray *line)
{
    int at = 0, count = (int)row_next(c, &at);
    if (count < 3 || count > 12)
        return 0;
    for (int i = 0; i < count; i++)
        v[i] = row_next3(c, &at);
    line->o = row_next3(c, &at);
    line->d = row_next3(c, &at);
    return count;
}

static void draw_outline(struct row_case *c, const vec3 *v, int count, vec3 o, vec3 d)
{
    row_fixed(c, count);
    for (int i = 0; i < count; i++)
        row_arg3(c, v[i]);
    row_arg3(c, o);
    row_arg3(c, d);
}

static bool crossed(const vec3 *v, int count, const struct pen_ray *ray, double *t, bool *made)
{
    struct pen_triangle triangle;
    struct pen_polygon polygon;
    if (count == 3) {
        *made = pen_triangle_make(&triangle, v[0], v[1], v[2]);
        return *made && pen_triangle_root(&triangle, ray, t);
    }
    *made = pen_polygon_make(&polygon, v, (uint32_t)count);
    return *made && pen_polygon_root(&polygon, ray, t);
}

/* t against its truth: in u of t where the body is seen from outside its own size, else in u of the
 * farthest vertex, with the bar of round bodies. */
static void compare(struct row_verdict *v, const struct flat_names *names, const vec3 *p, int count,
                    struct oracle_ray line, double t, struct truth truth)
{
    double reach = 0, d = pen_length(line.d);
    for (int i = 0; i < count; i++)
        reach = fmax(reach, pen_length(pen_sub(p[i], line.o)));
    row_measure(v, names->residual, oracle_flat_residual(p, line, t), 8);
    if (reach <= 2 * fabs(truth.hi) * d)
        row_measure(v, names->error, truth_units(t, truth), names->bar);
    else
        row_measure(v, names->near, truth_error(t, truth) * d / (0x1p-53 * reach),
                    names->bar < 0 ? -1 : 8);
}

/* Hit or miss by the exact winding, BE(8); the depth among the vertices' depths; t and the plane.
 */
static void judge_flat(const struct row_case *c, struct row_verdict *v,
                       const struct flat_names *names, bool grazing)
{
    vec3 p[12];
    struct oracle_ray line;
    struct pen_ray ray;
    struct truth truth;
    int count = outline_of(c, p, &line);
    double t = 0;
    bool made = false, unsure;
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool hit = crossed(p, count, &ray, &t, &made);
    if (!made) {
        row_skip(v);
        return;
    }
    bool exact = oracle_winding(p, count, line, 8, &unsure) != 0;
    if (hit != exact && !unsure)
        row_fail(v, hit ? "false hit" : "false miss");
    else if (hit != exact)
        row_tally(v, hit ? "false hit within BE(8)" : "false miss within BE(8)");
    if (!hit)
        return;
    row_require(v, isfinite(t), "t is not finite");
    row_require(v, oracle_depth_between(p, count, line, t, 8), "t is outside the vertices' depths");
    if (exact && oracle_plane(p, line, &truth) &&
        (oracle_flat_cosine(p, line) < GRAZING) == grazing)
        compare(v, names, p, count, line, t, truth);
}

/* Shoots from around at a point inside a triangle, an edge of it, or near it. */
static void shoot_at(struct random *r, const vec3 *p, int count, double away, struct row_case *c)
{
    double s = random_unit(r), t = random_below(r, 4) ? random_unit(r) * (1 - s) : 0;
    vec3 to = pen_along(pen_along(p[0], pen_sub(p[1], p[0]), s), pen_sub(p[2], p[0]), t);
    vec3 o = pen_along(to, random_direction(r), away);
    draw_outline(c, p, count, o, gen_toward(r, o, gen_nudged(r, to)));
}

static void draw_ordinary(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 at = gen_offset3(gen_offset(r)), p[3];
    double size = random_below(r, 2) ? 1 : gen_power(r, -3, 3);
    for (int i = 0; i < 3; i++)
        p[i] = pen_add(at, random_below(r, 2) ? random_vec(r, size) : gen_dyadic3(r, 2));
    shoot_at(r, p, 3, size * gen_power(r, -2, 6), c);
}

static void judge_triangle(const struct row_case *c, struct row_verdict *v)
{
    static const struct flat_names names = {"triangle, t [u]", "triangle near, t [u|v-o|]",
                                            "triangle, off the plane [u]", 16};
    judge_flat(c, v, &names, false);
}

static void judge_triangle_grazed(const struct row_case *c, struct row_verdict *v)
{
    static const struct flat_names names = {"triangle grazed, t [u]",
                                            "triangle grazed near, t [u|v-o|]",
                                            "triangle grazed, off the plane [u]", 16};
    judge_flat(c, v, &names, true);
}

void rows_triangle_grazed(struct pen_row_run *run)
{
    row_each(run, draw_ordinary, judge_triangle_grazed);
}

void rows_triangle(struct pen_row_run *run)
{
    row_each(run, draw_ordinary, judge_triangle);
}

/* H043: an edge of length 1 and a third vertex at 10^-k beside it, k up to 12. */
static void draw_needle(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    static const double aspect[] = {1e-6, 1e-9, 1e-12};
    vec3 e = random_direction(r), x, y, p[3];
    gen_frame(r, e, &x, &y);
    p[0] = random_vec(r, 1);
    p[1] = pen_add(p[0], e);
    double k = random_below(r, 2) ? aspect[random_below(r, 3)] : gen_power(r, -12, 0);
    p[2] = pen_along(pen_along(p[0], e, random_in(r, -.5, 1.5)), x, k);
    shoot_at(r, p, 3, gen_power(r, -1, 3), c);
}

static void judge_needle(const struct row_case *c, struct row_verdict *v)
{
    static const struct flat_names names = {"needle, t [u]", "needle near, t [u|v-o|]",
                                            "needle, off the plane [u]", 16};
    judge_flat(c, v, &names, false);
}

static void judge_needle_grazed(const struct row_case *c, struct row_verdict *v)
{
    static const struct flat_names names = {"needle grazed, t [u]",
                                            "needle grazed near, t [u|v-o|]",
                                            "needle grazed, off the plane [u]", 16};
    judge_flat(c, v, &names, true);
}

void rows_needle_grazed(struct pen_row_run *run)
{
    row_each(run, draw_needle, judge_needle_grazed);
}

void rows_needle(struct pen_row_run *run)
{
    row_each(run, draw_needle, judge_needle);
}

/* H047: edges that round to 11.2, 9.7 and 1.4, seen at 0.52 degrees to their plane. */
static void draw_grazed(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    const double a = 11.16, b = 9.74, e = 1.44, along = (a * a + b * b - e * e) / (2 * a);
    vec3 n = random_direction(r), x, y, p[3], at = random_vec(r, 100);
    gen_frame(r, n, &x, &y);
    double high = sqrt(b * b - along * along);
    p[0] = at;
    p[1] = pen_along(at, x, a);
    p[2] = pen_along(pen_along(at, x, along), y, high);
    double s = random_unit(r), t = random_unit(r) * (1 - s), turn = random_in(r, 0, 6.2831853);
    vec3 to = pen_along(pen_along(at, pen_sub(p[1], p[0]), s), pen_sub(p[2], p[0]), t);
    vec3 flat = pen_along(pen_scale(x, cos(turn)), y, sin(turn));
    vec3 way = pen_along(pen_scale(flat, cos(.52 * 0.0174532925)), n, sin(.52 * 0.0174532925));
    vec3 o = pen_along(to, way, -gen_power(r, 0, 4));
    draw_outline(c, p, 3, o, gen_toward(r, o, to));
}

static void judge_grazed(const struct row_case *c, struct row_verdict *v)
{
    static const struct flat_names names = {"thin and grazed, t [u]", "grazed near, t [u|v-o|]",
                                            "grazed, off the plane [u]", -1};
    judge_flat(c, v, &names, true);
}

void rows_grazed(struct pen_row_run *run)
{
    row_each(run, draw_grazed, judge_grazed);
}

/* A plane whose lattice coordinates i, j give points that are exact: multiples of 1/256. */
struct lattice {
    vec3 at, e, f;
};

static struct lattice draw_lattice(struct random *r)
{
    struct lattice l;
    l.at = gen_dyadic3(r, 4);
    do {
        l.e = gen_dyadic3(r, 2);
        l.f = gen_dyadic3(r, 2);
    } while (pen_norm1(pen_cross(l.e, l.f)) < .25);
    return l;
}

static vec3 lattice_point(const struct lattice *l, double i, double j)
{
    return pen_along(pen_along(l->at, l->e, i), l->f, j);
}

/* H052: a star of five tips, with every outline that such has: tips far out, notches deep. */
static int draw_star(struct random *r, const struct lattice *l, vec3 *p)
{
    static const double ring[10][2] = {{16, 0},  {9, 6},    {5, 15},   {-3, 9},  {-13, 10},
                                       {-11, 0}, {-13, -9}, {-3, -10}, {5, -15}, {9, -7}};
    for (int i = 0; i < 10; i++) {
        double s = i & 1 ? (double)(2 + random_below(r, 6)) / 128 : 1. / 16;
        p[i] = lattice_point(l, s * ring[i][0], s * ring[i][1]);
    }
    return 10;
}

/* Rays at corners, edges and notches of planar outlines, with dyadic and other directions. */
static void draw_polygon(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    struct lattice l = draw_lattice(r);
    vec3 p[12];
    int count = draw_star(r, &l, p);
    uint32_t i = random_below(r, 10);
    vec3 a = p[i], b = p[(i + 1 + random_below(r, 2)) % 10];
    static const double part[] = {0, 0, .25, .5, .5, 1e-9, .999999};
    vec3 to =
        pen_along(a, pen_sub(b, a), random_below(r, 2) ? part[random_below(r, 7)] : random_unit(r));
    if (random_below(r, 3) == 0)
        to = lattice_point(&l, random_in(r, -1, 1), random_in(r, -1, 1));
    vec3 away = random_below(r, 2) ? gen_dyadic3(r, 8)
                                   : pen_scale(random_direction(r), gen_power(r, -1, 4));
    vec3 o = pen_add(to, away);
    draw_outline(c, p, count, o, gen_toward(r, o, gen_nudged(r, to)));
}

static void judge_polygon(const struct row_case *c, struct row_verdict *v)
{
    static const struct flat_names names = {"polygon, t [u]", "polygon near, t [u|v-o|]",
                                            "polygon, off the plane [u]", 16};
    judge_flat(c, v, &names, false);
}

void rows_polygon(struct pen_row_run *run)
{
    row_each(run, draw_polygon, judge_polygon);
}

/* H042: an outline begun at another vertex, or run through the other way round, is the same body:
 * every vertex plays every role. */
static void judge_roles(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12], q[12];
    struct oracle_ray line;
    struct pen_ray ray;
    int count = outline_of(c, p, &line);
    double t = 0, s = 0;
    bool made = false, again;
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool hit = crossed(p, count, &ray, &t, &made);
    for (int turn = 0; turn < 2 * count; turn++) {
        for (int i = 0; i < count; i++)
            q[i] = p[turn & 1 ? (turn / 2 + count - i) % count : (turn / 2 + i) % count];
        bool other = crossed(q, count, &ray, &s, &again);
        row_require(v, again == made && other == hit, "hit or miss depends on the role");
        row_require(v, !hit || t == s, "t depends on the role");
    }
}

static void draw_any_flat(struct row_draw *d, struct row_case *c)
{
    if (random_below(&d->random, 2))
        draw_polygon(d, c);
    else
        draw_ordinary(d, c);
}

void rows_roles(struct pen_row_run *run)
{
    row_each(run, draw_any_flat, judge_roles);
}

/* H041 */
static void draw_pair(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    for (int i = 0; i < 2; i++)
        row_arg(c, random_below(r, 2) ? gen_wide(r, 30) : gen_dyadic(r, 2));
    bool near = random_below(r, 2);
    double t = random_in(r, -2, 2);
    for (int i = 0; i < 2; i++)
        row_arg(c, near ? t * c->arg[i] : random_below(r, 2) ? gen_wide(r, 30) : gen_dyadic(r, 2));
}

static void judge_pair(const struct row_case *c, struct row_verdict *v)
{
    const double *x = c->arg;
    const vec3 o = {0, 0, 0}, p = {x[0], x[1], 0}, q = {x[2], x[3], 0};
    double pq = pen_dop(x[0], x[3], x[1], x[2]), qp = pen_dop(x[2], x[1], x[3], x[0]);
    int sign = oracle_side((struct oracle_ray){o, {0, 0, 1}}, p, q);
    row_require(v, ((pq > 0) - (pq < 0)) == -((qp > 0) - (qp < 0)), "signs are not opposite");
    row_require(v, ((pq > 0) - (pq < 0)) == sign, "the sign is wrong");
    if (pq != 0)
        row_measure(v, "|dop(P,Q) + dop(Q,P)| [u]", fabs(pq + qp) / (0x1p-53 * fabs(pq)), 4);
}

void rows_antisymmetry(struct pen_row_run *run)
{
    row_each(run, draw_pair, judge_pair);
}

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
    draw_outline(c, p, 3, o, gen_toward(r, o, p[random_below(r, 3)]));
}

static void judge_degenerate(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12];
    struct oracle_ray line;
    struct pen_ray ray;
    double t = 0;
    bool made = false;
    if (outline_of(c, p, &line) == 0) {
        row_skip(v);
        return;
    }
    double size = fmax(pen_norm1(p[0]), fmax(pen_norm1(p[1]), pen_norm1(p[2])));
    bool flat = oracle_collinear(p[0], p[1], p[2]), in_range = size < 0x1p200 && size > 0x1p-150;
    if (!pen_ray_make(&ray, line.o, line.d))
        ray.inv_dd = 0; /* a direction out of range: only how the body is made can be judged */
    struct pen_triangle triangle;
    made = pen_triangle_make(&triangle, p[0], p[1], p[2]);
    if (in_range)
        row_require(v, made == !flat, flat ? "no area, but made" : "an area, but refused");
    else
        row_require(v, !(flat && made), "no area, but made");
    row_tally(v, made ? "made" : "refused");
    if (ray.inv_dd > 0 && made && pen_triangle_root(&triangle, &ray, &t) && in_range)
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
    draw_outline(c, p, 3, pen_vec3(-1081.47925, 99.9999542, 87.7701111),
                 pen_vec3(-32.1072998, -183.355865, -144.607635));
}

static void judge_pbrt(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12];
    struct oracle_ray line;
    struct pen_ray ray;
    bool made = false;
    double t;
    int count = outline_of(c, p, &line);
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool unsure, exact = oracle_winding(p, count, line, 0, &unsure) != 0;
    row_require(v, crossed(p, count, &ray, &t, &made) == exact, "hit");
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
    struct lattice l = draw_lattice(r);
    vec3 p[3];
    for (int i = 0; i < 3; i++)
        p[i] = lattice_point(&l, gen_dyadic(r, 1), gen_dyadic(r, 1));
    vec3 o = lattice_point(&l, gen_dyadic(r, 8), gen_dyadic(r, 8));
    vec3 way = pen_along(pen_scale(l.e, gen_dyadic(r, 1)), l.f, gen_dyadic(r, 1));
    row_fixed(c, 3);
    for (int i = 0; i < 3; i++)
        row_arg3(c, p[i]);
    row_arg3(c, o);
    row_arg3(c, way);
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
    int count = outline_of(c, p, &line);
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    struct truth truth;
    if (oracle_plane(p, line, &truth)) {
        row_skip(v); /* made smaller, it left the plane */
        return;
    }
    bool hit = crossed(p, count, &ray, &t, &made);
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
    vec3 way =
        steep ? random_direction(r)
              : pen_along(x, pen_normalize(n), -gen_power(r, random_below(r, 2) ? -300 : -16, 0));
    row_arg3(c, p);
    row_arg3(c, pen_scale(n, random_below(r, 2) ? 1 : gen_power(r, -30, 30)));
    row_arg3(c, pen_along(to, random_direction(r), gen_power(r, -3, 6)));
    row_arg3(c, way);
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
