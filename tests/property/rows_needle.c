/* SPDX-License-Identifier: MIT */
/* Needles far thinner than a double resolves beside their length. Two shapes have such an aspect in
 * doubles. In one, a vertex is next to the origin and the others are on a line through it. In the
 * other, vertices differ by almost nothing along one axis, at 0. */
#include "property/flat.h"
#include "property/gen.h"
#include "property/rows.h"

/* Across: two vertices on a line through the origin, the third beside it; for four, one on either
 * side. The ray goes anywhere near. */
static void draw_across(struct random *r, double thin, int count, vec3 *p)
{
    vec3 e = random_direction(r), x, y;
    gen_frame(r, e, &x, &y);
    p[0] = pen_scale(x, thin);
    p[1] = e;
    p[count - 1] = pen_scale(e, -ldexp(1, (int)random_below(r, 9) - 4));
    if (count == 4)
        p[2] = pen_scale(p[0], -ldexp(1, (int)random_below(r, 9) - 4));
}

/* Along an axis. The ray is along another, and passes the needle inside or beside it by a share of
 * its width. */
static vec3 draw_along(struct random *r, double thin, int count, vec3 *p)
{
    p[0] = pen_vec3(random_in(r, -1, 0), 0, 0);
    p[1] = pen_vec3(random_in(r, -1, 1), -thin, 0);
    p[count - 1] = pen_vec3(p[1].x, thin * random_unit(r), 0);
    p[count - 2] = count == 4 ? pen_vec3(random_in(r, 1, 2), 0, 0) : p[1];
    double s = random_in(r, -.2, 1.2), t = random_in(r, -.2, 1.2);
    return pen_vec3(p[0].x + s * (p[1].x - p[0].x), s * (t * p[1].y + (1 - t) * p[count - 1].y), 0);
}

static vec3 turned(vec3 v, uint32_t by)
{
    return by == 0 ? v : by == 1 ? pen_vec3(v.y, v.z, v.x) : pen_vec3(v.z, v.x, v.y);
}

/* H043: aspects of 1e-10 ... 1e-60. */
static void draw_thin(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    int count = 3 + (int)random_below(r, 2);
    double thin = gen_power(r, -60, -10);
    vec3 p[4], o, direction;
    if (random_below(r, 2)) {
        draw_across(r, thin, count, p);
        o = pen_scale(random_direction(r), gen_power(r, -1, 3));
        direction = gen_toward(r, o, pen_scale(p[1], random_unit(r)));
    } else {
        uint32_t by = random_below(r, 3);
        vec3 to = draw_along(r, thin, count, p), away = {0, 0, gen_power(r, -3, 3)};
        o = turned(pen_add(to, away), by);
        direction = turned(pen_vec3(0, 0, -gen_power(r, -3, 3)), by);
        for (int i = 0; i < count; i++)
            p[i] = turned(p[i], by);
    }
    flat_put(c, p, count, o, direction);
}

/* Whether the ray is along an axis and not in the needle's plane, and 1e-9 of its origin's
 * coordinates do not matter: no shear rounds, so hit or miss must be exact, however thin the
 * needle.
 */
static bool decided(const vec3 *p, int count, struct oracle_ray line, vec3 n)
{
    bool unsure;
    if ((line.d.x != 0) + (line.d.y != 0) + (line.d.z != 0) != 1 ||
        fabs(pen_dot(line.d, n)) < .1 * pen_length(line.d))
        return false;
    bool exact = oracle_winding(p, count, line, 0, &unsure) != 0;
    for (int i = 0; i < 8; i++) {
        vec3 by = {i & 1 ? 1 + 1e-9 : 1 - 1e-9, i & 2 ? 1 + 1e-9 : 1 - 1e-9,
                   i & 4 ? 1 + 1e-9 : 1 - 1e-9};
        struct oracle_ray moved = {pen_mul(line.o, by), line.d};
        if ((oracle_winding(p, count, moved, 0, &unsure) != 0) != exact)
            return false;
    }
    return true;
}

static bool in_range(const vec3 *p, int count)
{
    for (int i = 0; i < 3 * count; i++) {
        double x = fabs(pen_component(p[i / 3], i % 3));
        if (x != 0 && !(x > 1e-60 * 0x1p-60 && x < 0x1p60))
            return false;
    }
    return true;
}

static vec3 normal_of(const vec3 *p, int count)
{
    struct pen_triangle triangle;
    struct pen_polygon polygon;
    if (count == 3 && pen_triangle_make(&triangle, p[0], p[1], p[2]))
        return triangle.facet.n;
    return count == 4 && pen_polygon_make(&polygon, p, 4) ? polygon.facet.n : pen_vec3(0, 0, 0);
}

static void judge_thin(const struct row_case *c, struct row_verdict *v)
{
    vec3 p[12], exact;
    struct oracle_ray line;
    struct pen_ray ray;
    int count = flat_case(c, p, &line);
    bool made, unsure;
    double t;
    if (count == 0 || count > 4 || !in_range(p, count) || !pen_ray_make(&ray, line.o, line.d)) {
        row_skip(v);
        return;
    }
    bool hit = flat_cross(p, count, &ray, &t, &made), area = oracle_normal(p, count, &exact);
    row_require(v, made == area, area ? "an area, but refused" : "no area, but made");
    if (!made || !area)
        return;
    row_measure(v, "normal [u]", pen_norm1(pen_sub(normal_of(p, count), exact)) / 0x1p-53, 16);
    bool inside = oracle_winding(p, count, line, 8, &unsure) != 0;
    if (!decided(p, count, line, exact) && unsure)
        return;
    row_tally(v, inside ? "hits" : "misses");
    row_require(v, hit == inside, hit ? "false hit" : "false miss");
}

void rows_thin(struct pen_row_run *run)
{
    row_each(run, draw_thin, judge_thin);
}
