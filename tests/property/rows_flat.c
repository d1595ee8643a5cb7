/* SPDX-License-Identifier: MIT */
/* Triangles, polygons and planes one at a time: hit or miss against the exact winding, depth
 * against 113 bits. */
#include "geom/facet.h"
#include "property/flat.h"
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

/* t against its truth: in u of t where the primitive is seen from outside its own size, else in u
 * of the farthest vertex, with the bar of round primitives. */
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

/* By how many u of the depths t may be outside the vertices' depths. A line that is seen to pass
 * inside up to 8u may be as far outside, and meets the plane 8u over the sine of their angle beside
 * the outline. At less than a third of PEN_FACET_GRAZING t is always kept within the depths. */
static double depth_slack(const vec3 *p, struct oracle_ray line, bool unsure)
{
    double sine = oracle_flat_cosine(p, line);
    return unsure && sine > PEN_FACET_GRAZING / 3 ? 8 + 8 / sine : 8;
}

/* Whether t is the plane's, behind the line's origin, and no vertex is there. A line that grazes
 * the plane may be seen to pass inside an outline that it misses; but on which side of the plane it
 * starts is known exactly, so a ray away from the plane meets nothing. */
static bool away_from_outline(const vec3 *p, int count, struct oracle_ray line, double t)
{
    struct truth truth;
    if (!(t < 0) || !oracle_plane(p, line, &truth) || !(truth.hi < 0))
        return false;
    for (int i = 0; i < count; i++)
        if (pen_dot(pen_sub(p[i], line.o), line.d) < 0)
            return false;
    return oracle_flat_residual(p, line, t) <= 8;
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
    int count = flat_case(c, p, &line);
    double t = 0;
    bool made = false, unsure;
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool hit = flat_cross(p, count, &ray, &t, &made);
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
    row_require(v,
                oracle_depth_between(p, count, line, t, depth_slack(p, line, unsure)) ||
                    (unsure && away_from_outline(p, count, line, t)),
                "t is outside the vertices' depths");
    for (int i = 3; i < count; i++)
        if (oracle_above(p[0], p[1], p[2], p[i]) != 0)
            return; /* changed a little, it has no plane to be judged by */
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
    flat_put(c, p, count, o, gen_toward(r, o, gen_nudged(r, to)));
}

static void draw_ordinary(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 at = gen_offset3(gen_offset(r)), p[3];
    double size = random_below(r, 2) ? 1 : gen_power(r, -3, 3);
    bool wide = random_below(r, 8) == 0; /* G6: nothing is of the size of anything else */
    for (int i = 0; i < 3; i++)
        p[i] = wide ? gen_wide3(r, 30)
                    : pen_add(at, random_below(r, 2) ? random_vec(r, size) : gen_dyadic3(r, 2));
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
    vec3 direction =
        pen_along(pen_scale(flat, cos(.52 * 0.0174532925)), n, sin(.52 * 0.0174532925));
    vec3 o = pen_along(to, direction, -gen_power(r, 0, 4));
    flat_put(c, p, 3, o, gen_toward(r, o, to));
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

/* H052: a star of five tips, with every outline that such has: tips far out, notches deep. */
static int draw_star(struct random *r, const struct lattice *l, vec3 *p)
{
    static const double ring[10][2] = {{16, 0},  {9, 6},    {5, 15},   {-3, 9},  {-13, 10},
                                       {-11, 0}, {-13, -9}, {-3, -10}, {5, -15}, {9, -7}};
    for (int i = 0; i < 10; i++) {
        double s = i & 1 ? (double)(2 + random_below(r, 6)) / 128 : 1. / 16;
        p[i] = flat_lattice_point(l, s * ring[i][0], s * ring[i][1]);
    }
    return 10;
}

/* Rays at corners, edges and notches of planar outlines, with dyadic and other directions. */
static void draw_polygon(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    struct lattice l = flat_lattice(r);
    vec3 p[12];
    int count = draw_star(r, &l, p);
    uint32_t i = random_below(r, 10);
    vec3 a = p[i], b = p[(i + 1 + random_below(r, 2)) % 10];
    static const double part[] = {0, 0, .25, .5, .5, 1e-9, .999999};
    vec3 to =
        pen_along(a, pen_sub(b, a), random_below(r, 2) ? part[random_below(r, 7)] : random_unit(r));
    if (random_below(r, 3) == 0)
        to = flat_lattice_point(&l, random_in(r, -1, 1), random_in(r, -1, 1));
    vec3 away = random_below(r, 2) ? gen_dyadic3(r, 8)
                                   : pen_scale(random_direction(r), gen_power(r, -1, 4));
    vec3 o = pen_add(to, away);
    flat_put(c, p, count, o, gen_toward(r, o, gen_nudged(r, to)));
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

/* H042: an outline begun at another vertex, or run through the other way round, is the same
 * primitive: every vertex plays every role. */
static void judge_roles(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12], q[12];
    struct oracle_ray line;
    struct pen_ray ray;
    int count = flat_case(c, p, &line);
    double t = 0, s = 0;
    bool made = false, again;
    if (count == 0 || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool hit = flat_cross(p, count, &ray, &t, &made);
    for (int turn = 0; turn < 2 * count; turn++) {
        for (int i = 0; i < count; i++)
            q[i] = p[turn & 1 ? (turn / 2 + count - i) % count : (turn / 2 + i) % count];
        bool other = flat_cross(q, count, &ray, &s, &again);
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
