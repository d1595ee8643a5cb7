/* SPDX-License-Identifier: MIT */
/* Primitives of any kind and one ray, in a mirror and with axes permuted. */
#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"
#include "property/shape.h"

static vec3 triangle_target(struct random *r, const struct shape *s)
{
    double a = random_unit(r), b = random_unit(r) * (1 - a);
    return pen_along(pen_along(s->p[0], pen_sub(s->p[1], s->p[0]), a), pen_sub(s->p[2], s->p[0]),
                     b);
}

/* Corners that mirrors and turns bring to each other, and needles. */
static void draw_corners(struct random *r, struct shape *s)
{
    static const int turns[] = {0, 1, 2, 1};
    struct shape_map m = shape_map_identity;
    bool lattice = random_below(r, 2) != 0;
    s->p[0] = lattice ? gen_dyadic3(r, 2) : random_vec(r, 2);
    for (int i = 1; i < 3; i++) {
        m.sign = pen_vec3(random_below(r, 2) ? -1 : 1, random_below(r, 2) ? -1 : 1,
                          random_below(r, 2) ? -1 : 1);
        m.turn = turns[random_below(r, 4)];
        s->p[i] = random_below(r, 3) ? shape_map_way(&m, s->p[0])
                  : lattice          ? gen_dyadic3(r, 2)
                                     : random_vec(r, 2);
    }
    if (random_below(r, 4) == 0)
        s->p[2] = pen_along(s->p[0], pen_sub(s->p[2], s->p[0]), gen_power(r, -12, 0));
    s->d = gen_toward(r, s->o, triangle_target(r, s));
}

/* Lets the ray pass through the primitive along d, times something. */
static void aim_along(struct random *r, struct shape *s)
{
    vec3 to = s->kind == SHAPE_TRIANGLE || s->kind == SHAPE_POLYGON
                  ? triangle_target(r, s)
                  : pen_along(s->p[0], random_direction(r), s->r * random_unit(r));
    s->d = pen_scale(s->d, gen_power(r, -1, 1));
    s->o = pen_along(to, s->d, -random_in(r, 0, 9));
}

/* A ray with two or three components of one size. */
static void draw_equals(struct random *r, struct shape *s)
{
    struct shape_map m = shape_map_identity;
    double third = random_below(r, 2) ? 1 : random_in(r, -1.5, 1.5);
    m.turn = (int)random_below(r, 3);
    s->d = pen_vec3(random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 1 : -1, third);
    s->d = shape_map_way(&m, s->d);
    aim_along(r, s);
}

static struct shape draw_aimed(struct random *r, enum shape_kind kind)
{
    struct shape s = shape_draw(r, kind, false);
    if (kind == SHAPE_TRIANGLE && random_below(r, 2))
        draw_corners(r, &s);
    if (random_below(r, 4) == 0)
        draw_equals(r, &s);
    return s;
}

/* H078: any coordinates negated. Triangles are a row of their own. Arguments: which (bits), plus
 * 8 times the order of a triangle's corners; the shape. */
static void draw_mirrored(struct row_draw *d, struct row_case *c)
{
    static const enum shape_kind kinds[] = {SHAPE_SPHERE, SHAPE_INFINITE_CYLINDER, SHAPE_CYLINDER,
                                            SHAPE_POLYGON, SHAPE_PLANE};
    struct shape s = draw_aimed(&d->random, kinds[d->index % 5]);
    row_fixed(c, 1 + random_below(&d->random, 7));
    shape_put(c, &s);
}

static void draw_mirrored_triangle(struct row_draw *d, struct row_case *c)
{
    struct shape s = draw_aimed(&d->random, SHAPE_TRIANGLE);
    row_fixed(c, random_below(&d->random, 48));
    shape_put(c, &s);
}

/* The corners of a triangle in another order; whether it is an odd one. */
static bool reorder(struct shape *s, int order)
{
    const vec3 p[3] = {s->p[0], s->p[1], s->p[2]};
    bool odd = order >= 3;
    for (int i = 0; i < 3; i++)
        s->p[i] = p[(order + (odd ? 3 - i : i)) % 3];
    return odd;
}

/* Where the intersections are, and the normals there, are each other's image. A flat primitive's
 * outline runs the other way round in a mirror. */
static void require_images(struct row_verdict *v, const struct shape_map *m, bool other_side,
                           vec3 a[2][2], vec3 b[2][2], int count)
{
    for (int i = 0; i < count; i++) {
        vec3 p = shape_map_way(m, a[i][0]), n = shape_map_way(m, a[i][1]);
        if (other_side)
            n = pen_neg(n);
        row_require(v, pen_norm1(pen_sub(p, b[i][0])) == 0, "the point is not the image");
        row_require(v, pen_norm1(pen_sub(n, b[i][1])) == 0, "the normal is not the image");
    }
}

static void judge_mirrored(const struct row_case *c, struct row_verdict *v)
{
    int at = 0, bits = (int)row_next(c, &at) & 63;
    struct shape_map m = shape_map_identity;
    struct shape s, t;
    struct pen_intersections a, b;
    vec3 there[2][2], here[2][2]; /* point and normal of each intersection */
    m.sign = pen_vec3(bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1);
    if (!shape_get(c, &at, &s) || !shape_cross(&s, &a) || shape_on_border(&s)) {
        row_skip(v);
        return;
    }
    for (int i = 0; i < a.count; i++)
        shape_at(&a, i, &here[i][0], &here[i][1]);
    t = shape_mapped(&m, &s);
    bool odd = m.sign.x * m.sign.y * m.sign.z < 0;
    if (s.kind == SHAPE_TRIANGLE)
        odd ^= reorder(&t, bits / 8 % 6);
    if (!row_require(v, shape_cross(&t, &b), "not made in the mirror"))
        return;
    shape_require_equal(v, s.kind, &a, &b, 1);
    for (int i = 0; i < b.count; i++)
        shape_at(&b, i, &there[i][0], &there[i][1]);
    if (!v->failed)
        require_images(v, &m, odd && (s.kind == SHAPE_TRIANGLE || s.kind == SHAPE_POLYGON), here,
                       there, a.count);
}

void rows_mirrored(struct pen_row_run *run)
{
    row_each(run, draw_mirrored, judge_mirrored);
}

void rows_mirrored_triangle(struct pen_row_run *run)
{
    row_each(run, draw_mirrored_triangle, judge_mirrored);
}

/* H079: (x, y, z) to (y, z, x) and on. */
static void draw_turned_kind(struct random *r, enum shape_kind kind, struct row_case *c)
{
    struct shape s = draw_aimed(r, kind);
    row_fixed(c, 1 + random_below(r, 2));
    shape_put(c, &s);
}

static void draw_turned(struct row_draw *d, struct row_case *c)
{
    static const enum shape_kind kinds[] = {SHAPE_SPHERE, SHAPE_INFINITE_CYLINDER, SHAPE_POLYGON};
    draw_turned_kind(&d->random, kinds[d->index % 3], c);
}

static void draw_turned_sums(struct row_draw *d, struct row_case *c)
{
    static const enum shape_kind kinds[] = {SHAPE_TRIANGLE, SHAPE_CYLINDER, SHAPE_PLANE};
    draw_turned_kind(&d->random, kinds[d->index % 3], c);
}

/* Rays that graze, or start near what they meet, lose more digits than the order of a sum. */
static bool well_conditioned(const struct shape *s)
{
    struct oracle_round b = {s->p[0], s->kind == SHAPE_SPHERE ? pen_vec3(0, 0, 0) : s->a, s->r,
                             s->h};
    struct oracle_ray line = {s->o, s->d};
    vec3 n = s->kind == SHAPE_PLANE
                 ? s->a
                 : pen_cross(pen_sub(s->p[1], s->p[0]), pen_sub(s->p[2], s->p[0]));
    if (s->kind <= SHAPE_CYLINDER)
        return oracle_distance(&b, line) > 2 && oracle_passing(&b, line) < .9;
    if (fabs(pen_dot(n, pen_sub(s->p[0], s->o))) <
        .5 * pen_length(n) * (pen_length(s->p[0]) + pen_length(s->o)))
        return false;
    if (s->kind == SHAPE_POLYGON && /* not flat */
        fabs(pen_dot(n, pen_sub(s->p[3], s->p[0]))) > 0x1p-48 * pen_length(n) * pen_norm1(s->p[3]))
        return false;
    return fabs(pen_dot(n, s->d)) > .1 * pen_length(n) * pen_length(s->d);
}

static bool same_sizes(vec3 a, vec3 b)
{
    double x[3] = {fabs(a.x), fabs(a.y), fabs(a.z)}, y[3] = {fabs(b.x), fabs(b.y), fabs(b.z)};
    for (int turn = 0; turn < 6; turn++) {
        int i = turn % 3, j = (i + 1 + turn / 3) % 3;
        if (x[0] == y[i] && x[1] == y[j] && x[2] == y[3 - i - j])
            return true;
    }
    return false;
}

/* Whether no axis is the ray's own, or no corner the triangle's. */
static bool is_tied(const struct shape *s)
{
    vec3 e = pen_sub(s->p[1], s->p[0]), f = pen_sub(s->p[2], s->p[1]),
         g = pen_sub(s->p[0], s->p[2]);
    if (s->kind == SHAPE_TRIANGLE && same_sizes(e, f) && same_sizes(f, g))
        return true;
    return fabs(s->d.x) == fabs(s->d.y) && fabs(s->d.y) == fabs(s->d.z);
}

static void judge_turned_or_tied(const struct row_case *c, struct row_verdict *v, bool tied)
{
    static const char *const name[] = {"sphere, t [ulp]",   "tube, t [ulp]",    "cylinder, t [ulp]",
                                       "triangle, t [ulp]", "polygon, t [ulp]", "plane, t [ulp]"};
    int at = 0;
    struct shape_map m = shape_map_identity;
    struct shape s, t;
    struct pen_intersections a, b;
    m.turn = (int)row_next(c, &at);
    if (!shape_get(c, &at, &s) || !shape_cross(&s, &a) || is_tied(&s) != tied ||
        (tied && (shape_on_border(&s) || !well_conditioned(&s)))) {
        row_skip(v);
        return;
    }
    t = shape_mapped(&m, &s);
    if (!row_require(v, shape_cross(&t, &b), "not made with axes permuted"))
        return;
    if (!row_require(v, a.count == b.count, "hit or miss changed with the axes"))
        return;
    for (int i = 0; i < a.count; i++)
        row_measure(v, name[s.kind], truth_ulps(b.t[i], (struct truth){a.t[i], 0}), 2);
}

static void judge_turned(const struct row_case *c, struct row_verdict *v)
{
    judge_turned_or_tied(c, v, false);
}

static void judge_tied(const struct row_case *c, struct row_verdict *v)
{
    judge_turned_or_tied(c, v, true);
}

/* Diagonal rays, and triangles whose edges turns bring to each other. */
static void draw_turned_tied(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    struct shape s = shape_draw(r, (enum shape_kind)(d->index % SHAPE_KINDS), false);
    if (s.kind == SHAPE_TRIANGLE && random_below(r, 2)) {
        vec3 p = random_vec(r, 2);
        s.p[0] = p;
        s.p[1] = pen_vec3(p.y, p.z, p.x);
        s.p[2] = pen_vec3(p.z, p.x, p.y);
        s.d = gen_toward(r, s.o, triangle_target(r, &s));
    } else {
        s.d = pen_vec3(random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 1 : -1, 1);
        aim_along(r, &s);
    }
    row_fixed(c, 1 + random_below(r, 2));
    shape_put(c, &s);
}

void rows_permuted(struct pen_row_run *run)
{
    row_each(run, draw_turned, judge_turned);
}

void rows_permuted_sums(struct pen_row_run *run)
{
    row_each(run, draw_turned_sums, judge_turned);
}

void rows_permuted_tied(struct pen_row_run *run)
{
    row_each(run, draw_turned_tied, judge_tied);
}
