/* SPDX-License-Identifier: MIT */
/* Polygons around projections. Points around a primitive are projected. Their convex hull is
 * computed by Andrew's monotone chain (Information Processing Letters 9(5), 1979), and its part in
 * a strip by Sutherland and Hodgman's method (CACM 17(1), 1974). */
#include "render/internal/projection.h"

#include <math.h>
#include <stdlib.h>

#include "math/fn.h"

/* The width in pixels by which polygons exceed their primitives, to allow for rounding. */
static const double MARGIN = 1e-7;

/* A polygon around a round outline exceeds it by at most about this number of pixels. */
static const double ROUND_OFF = 0.005;

/* Points around a primitive. */
struct points {
    int count;
    struct pen_vec3 p[PEN_HULL_MAX];
};

/* The corners of a regular polygon around a circle. `axis` is across it, of any length. */
static void add_circle(struct points *points, struct pen_vec3 center, struct pen_vec3 axis,
                       double radius, int corners)
{
    struct pen_vec3 n = pen_normalize(axis), any = {0, 0, 0}, u, v;
    double sine, cosine;
    if (fabs(n.x) < 0.6)
        any.x = 1;
    else
        any.y = 1;
    u = pen_normalize(pen_cross(n, any));
    v = pen_cross(n, u);
    pen_sincos_deg(180.0 / corners, &sine, &cosine);
    radius /= cosine;
    for (int i = 0; i < corners && points->count < PEN_HULL_MAX; i++) {
        pen_sincos_deg(360.0 * i / corners, &sine, &cosine);
        points->p[points->count++] =
            pen_along(pen_along(center, u, radius * cosine), v, radius * sine);
    }
}

/* The circle of a sphere that the eye sees as its outline. */
static bool add_sphere(const struct pen_kernel_input *input, struct points *points,
                       const struct pen_sphere *s)
{
    const struct pen_pinhole *pinhole = &input->pinhole;
    const struct pen_vec3 to = pen_sub(s->c, pinhole->eye);
    const double dd = pen_dot(to, to), part = 1 - s->rr / dd;
    if (!(part > 0))
        return false;
    const double pixels =
        s->r * pen_length(pinhole->middle) / sqrt(dd * part) / pen_length(pinhole->dx);
    double corners = ceil(3.15 * sqrt(pixels / (2 * ROUND_OFF)));
    corners = corners < 12 ? 12 : corners < PEN_HULL_MAX ? corners : PEN_HULL_MAX;
    add_circle(points, pen_along(pinhole->eye, to, part), to, s->r * sqrt(part), (int)corners);
    return true;
}

static void add_rims(struct points *points, const struct pen_cylinder *c, double base_radius,
                     double top_radius)
{
    enum { CORNERS = 24 };
    const double height = (c->h + c->rim) / c->round.length;
    add_circle(points, pen_along(c->round.q, c->round.a, -c->rim / c->round.length), c->round.a,
               base_radius, CORNERS);
    add_circle(points, pen_along(c->round.q, c->round.a, height), c->round.a, top_radius, CORNERS);
}

static void add_box(struct points *points, struct pen_vec3 center, const struct pen_vec3 half[3])
{
    for (int i = 0; i < 8; i++) {
        struct pen_vec3 p = center;
        for (int k = 0; k < 3; k++)
            p = pen_along(p, half[k], i >> k & 1 ? 1 : -1);
        points->p[points->count++] = p;
    }
}

/* A box along the camera's axes around a sphere. */
static void add_camera_box(const struct pen_kernel_input *input, struct points *points,
                           const struct pen_sphere *s)
{
    const struct pen_vec3 half[] = {pen_scale(pen_normalize(input->pinhole.dx), s->r),
                                    pen_scale(pen_normalize(input->pinhole.dy), s->r),
                                    pen_scale(pen_normalize(input->pinhole.middle), s->r)};
    add_box(points, s->c, half);
}

static bool add_around_sphere(const struct pen_kernel_input *input, struct points *points,
                              const struct pen_sphere *s)
{
    if (!input->lens.open)
        return add_sphere(input, points, s);
    add_camera_box(input, points, s);
    return true;
}

static void add_bounds(struct points *points, struct pen_box b)
{
    for (int i = 0; i < 8; i++)
        points->p[points->count++] =
            pen_vec3(i & 1 ? b.hi.x : b.lo.x, i & 2 ? b.hi.y : b.lo.y, i & 4 ? b.hi.z : b.lo.z);
}

static bool points_around(const struct pen_kernel_input *input, uint32_t prim,
                          struct points *points)
{
    struct pen_triangle room;
    const struct pen_prims *prims = &input->scene->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    const struct pen_outline outline = pen_prim_outline(prims, prim, &room);
    points->count = 0;
    if (ref.kind == PEN_PRIM_SPHERE)
        return add_around_sphere(input, points, &prims->sphere[ref.index]);
    if (ref.kind == PEN_PRIM_CYLINDER)
        add_rims(points, &prims->cylinder[ref.index], prims->cylinder[ref.index].round.r,
                 prims->cylinder[ref.index].round.r);
    else if (ref.kind == PEN_PRIM_CONE)
        add_rims(points, &prims->cone[ref.index].hull, prims->cone[ref.index].base_radius,
                 prims->cone[ref.index].top_radius);
    else if (outline.count > 0 && outline.count <= PEN_HULL_MAX)
        for (uint32_t i = 0; i < outline.count; i++)
            points->p[points->count++] = outline.v[i];
    else
        add_bounds(points, pen_prim_bounds(prims, prim));
    return true;
}

static int by_place(const void *a, const void *b)
{
    const struct pen_point2 *p = a, *q = b;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    return p->y < q->y ? -1 : p->y > q->y;
}

static double turn(struct pen_point2 a, struct pen_point2 b, struct pen_point2 c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static void hull_of(struct pen_point2 *p, int count, struct pen_hull *hull)
{
    struct pen_point2 chain[2 * PEN_HULL_MAX + 1];
    int n = 0;
    qsort(p, (size_t)count, sizeof *p, by_place);
    for (int i = 0; i < count; i++) {
        while (n >= 2 && turn(chain[n - 2], chain[n - 1], p[i]) <= 0)
            n--;
        chain[n++] = p[i];
    }
    for (int i = count - 2, lower = n + 1; i >= 0; i--) {
        while (n >= lower && turn(chain[n - 2], chain[n - 1], p[i]) <= 0)
            n--;
        chain[n++] = p[i];
    }
    hull->count = n > 1 ? n - 1 : n;
    for (int i = 0; i < hull->count; i++)
        hull->p[i] = chain[i];
}

/* Makes the polygon wider by MARGIN, away from its middle. */
static void widen(struct pen_hull *hull)
{
    const struct pen_point2 lo = pen_hull_least(hull), hi = pen_hull_largest(hull);
    for (int i = 0; i < hull->count; i++) {
        hull->p[i].x += hull->p[i].x > 0.5 * (lo.x + hi.x) ? MARGIN : -MARGIN;
        hull->p[i].y += hull->p[i].y > 0.5 * (lo.y + hi.y) ? MARGIN : -MARGIN;
    }
}

/* The rectangle around a polygon, extended by more_x and more_y. */
static void to_rectangle(struct pen_hull *hull, double more_x, double more_y)
{
    const struct pen_point2 lo = pen_hull_least(hull), hi = pen_hull_largest(hull);
    hull->count = 4;
    hull->p[0] = (struct pen_point2){lo.x - more_x, lo.y - more_y};
    hull->p[1] = (struct pen_point2){hi.x + more_x, lo.y - more_y};
    hull->p[2] = (struct pen_point2){hi.x + more_x, hi.y + more_y};
    hull->p[3] = (struct pen_point2){lo.x - more_x, hi.y + more_y};
}

/* A ray from aside = a right + b up has the direction focus d - aside. It meets the point at depth
 * t, in lengths of `middle`, at s = t / focus times that direction. So d is that of the pinhole's
 * ray minus aside (1 - s) / t. */
static struct pen_shear shear_at(const struct pen_kernel_input *input, double t)
{
    const struct pen_pinhole *p = &input->pinhole;
    const double off = (1 - t / input->lens.focus) / t;
    return (struct pen_shear){-off * pen_dot(input->lens.right, p->dx) / pen_dot(p->dx, p->dx),
                              -off * pen_dot(input->lens.up, p->dy) / pen_dot(p->dy, p->dy)};
}

static bool project(const struct pen_kernel_input *input, const struct points *points,
                    struct pen_hull *hull, struct pen_shear *shear)
{
    const struct pen_pinhole *pinhole = &input->pinhole;
    const double mm = pen_dot(pinhole->middle, pinhole->middle);
    struct pen_point2 at[PEN_HULL_MAX];
    double nearest = INFINITY, farthest = 0;
    for (int i = 0; i < points->count; i++) {
        const struct pen_vec3 q = pen_sub(points->p[i], pinhole->eye);
        const double t = pen_dot(q, pinhole->middle) / mm;
        if (!(t > 1e-9))
            return false;
        nearest = t < nearest ? t : nearest;
        farthest = t > farthest ? t : farthest;
        at[i].x =
            pinhole->half_width + pen_dot(q, pinhole->dx) / pen_dot(pinhole->dx, pinhole->dx) / t;
        at[i].y =
            pinhole->half_height + pen_dot(q, pinhole->dy) / pen_dot(pinhole->dy, pinhole->dy) / t;
    }
    hull_of(at, points->count, hull);
    widen(hull);
    *shear = (struct pen_shear){0, 0};
    if (!input->lens.open)
        return true;
    const struct pen_shear a = shear_at(input, nearest), b = shear_at(input, farthest);
    *shear = (struct pen_shear){0.5 * (a.x + b.x), 0.5 * (a.y + b.y)};
    to_rectangle(hull, 0.5 * fabs(a.x - b.x), 0.5 * fabs(a.y - b.y));
    return true;
}

bool pen_project(const struct pen_kernel_input *input, uint32_t prim, struct pen_hull *hull,
                 struct pen_shear *shear)
{
    struct points points;
    return points_around(input, prim, &points) && project(input, &points, hull, shear);
}

bool pen_project_sphere(const struct pen_kernel_input *input, const struct pen_sphere *sphere,
                        struct pen_hull *hull, struct pen_shear *shear)
{
    struct points points = {.count = 0};
    return add_around_sphere(input, &points, sphere) && project(input, &points, hull, shear);
}

bool pen_project_box(const struct pen_kernel_input *input, struct pen_vec3 center,
                     const struct pen_vec3 half[3], struct pen_hull *hull, struct pen_shear *shear)
{
    struct points points = {.count = 0};
    add_box(&points, center, half);
    return project(input, &points, hull, shear);
}

/* The part of a polygon on one side of a line across x or y: where sign (coordinate - at) >= 0. */
static void clip_side(const struct pen_hull *hull, bool along_y, double at, double sign,
                      struct pen_hull *part)
{
    part->count = 0;
    for (int i = 0; i < hull->count; i++) {
        const struct pen_point2 a = hull->p[i], b = hull->p[(i + 1) % hull->count];
        const double da = sign * ((along_y ? a.y : a.x) - at),
                     db = sign * ((along_y ? b.y : b.x) - at);
        if (da >= 0)
            part->p[part->count++] = a;
        if ((da >= 0) != (db >= 0)) {
            const double s = da / (da - db);
            struct pen_point2 cut = {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)};
            *(along_y ? &cut.y : &cut.x) = at;
            part->p[part->count++] = cut;
        }
    }
}

void pen_hull_clip(const struct pen_hull *hull, bool along_y, double lo, double hi,
                   struct pen_hull *part)
{
    struct pen_hull above;
    clip_side(hull, along_y, lo, 1, &above);
    clip_side(&above, along_y, hi, -1, part);
}

struct pen_point2 pen_hull_least(const struct pen_hull *hull)
{
    struct pen_point2 least = hull->p[0];
    for (int i = 1; i < hull->count; i++) {
        least.x = hull->p[i].x < least.x ? hull->p[i].x : least.x;
        least.y = hull->p[i].y < least.y ? hull->p[i].y : least.y;
    }
    return least;
}

struct pen_point2 pen_hull_largest(const struct pen_hull *hull)
{
    struct pen_point2 largest = hull->p[0];
    for (int i = 1; i < hull->count; i++) {
        largest.x = hull->p[i].x > largest.x ? hull->p[i].x : largest.x;
        largest.y = hull->p[i].y > largest.y ? hull->p[i].y : largest.y;
    }
    return largest;
}

double pen_hull_area(const struct pen_hull *hull)
{
    double sum = 0;
    for (int i = 2; i < hull->count; i++)
        sum += turn(hull->p[0], hull->p[i - 1], hull->p[i]);
    return 0.5 * fabs(sum);
}
