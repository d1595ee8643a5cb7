/* SPDX-License-Identifier: MIT */
/* Cones. Let f = o - q be relative to the base's middle q, n(t) = (f + t d) x a, and w(t) = |a|
 * times the radius at the height of o + t d. The side is where |n|^2 = w^2, a quadratic equation
 *   A t^2 + 2 B t + C = 0,   A = m.m - k^2,   B = m.n - k w,   C = n.n - w^2,
 * with m = d x a, k = slope d.a, and n, w at t = 0. It is negative inside.
 *   A > 0  the line meets one nappe twice, or none: inside is between the roots.
 *   A <= 0 the line meets both nappes, or runs along one: inside, on the nappe that counts, is
 *          beyond the root on the side where w grows. */
#include "geom/cone.h"

#include "geom/internal/double_double.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"
#include "math/frame.h"
#include "math/scale.h"

/* (top_radius - base_radius) / height */
static struct dd slope_of(double r, double top_r, double h)
{
    struct dd rise = two_sum(top_r, -r);
    double slope = rise.hi / h;
    return two_sum_fast(slope, (fma(-slope, h, rise.hi) + rise.lo) / h);
}

/* Removes a rim that would extend beyond the apex, to the other nappe. */
static void end_before_apex(struct pen_cone *c)
{
    struct pen_cylinder *hull = &c->hull;
    if (c->base_radius < c->slope * hull->rim)
        hull->slab_base = 0;
    if (c->top_radius == 0 || c->top_radius < -c->slope * hull->rim)
        hull->slab_top = hull->top;
}

/* Removes extensions that are too long: a rim beyond the apex (end_before_apex), and `joint` of a
 * very flat side, where a line along a cap would be met at more than seven times that distance from
 * it. */
static void join_within_rounding(struct pen_cone *c)
{
    end_before_apex(c);
    if (fabs(c->slope) > 7)
        c->hull.joint *= 7 / fabs(c->slope);
}

bool pen_cone_make(struct pen_cone *c, struct pen_vec3 base, struct pen_vec3 axis, double r,
                   double top_r, double h, bool caps)
{
    if (!is_length(r) || !(top_r == 0 || is_length(top_r)) ||
        !pen_cylinder_make(&c->hull, base, axis, pen_larger(r, top_r), h, caps))
        return false;
    struct dd3 a = dd_of3(c->hull.round.a);
    struct dd slope = slope_of(r, top_r, h);
    struct dd width = dd_mul((struct dd){r, 0}, dd_sqrt(dd_dot(a, a)));
    c->base_radius = r;
    c->top_radius = top_r;
    c->slope = slope.hi;
    c->slope_low = slope.lo;
    c->width = width.hi;
    c->width_low = width.lo;
    c->slant = sqrt(1 + slope.hi * slope.hi);
    join_within_rounding(c);
    return slope.hi == 0 || (fabs(slope.hi) >= 0x1p-200 && fabs(slope.hi) <= 0x1p200);
}

/* The equation of the side for one ray. */
struct equation {
    struct dd a, b, c;
    double grows; /* the sign of w's growth along the ray */
};

/* The equation of a line in direction d through a point that is f from the base's middle. */
static struct equation equation_from(const struct pen_cone *cone, struct dd3 f, struct pen_vec3 d)
{
    struct dd slope = {cone->slope, cone->slope_low}, width = {cone->width, cone->width_low};
    struct dd3 a = dd_of3(cone->hull.round.a), m = dd_cross(dd_of3(d), a), n = dd_cross(f, a);
    struct dd k = dd_mul(slope, dd_dot(dd_of3(d), a)),
              w = dd_add(width, dd_mul(slope, dd_dot(f, a)));
    return (struct equation){.a = dd_add(dd_dot(m, m), dd_neg(dd_mul(k, k))),
                             .b = dd_add(dd_dot(m, n), dd_neg(dd_mul(k, w))),
                             .c = dd_add(dd_dot(n, n), dd_neg(dd_mul(w, w))),
                             .grows = k.hi};
}

static struct equation equation_of(const struct pen_cone *cone, const struct pen_ray *ray)
{
    return equation_from(cone, dd_sub3(ray->o, cone->hull.round.q), ray->d);
}

/* B^2 - A C */
static double discriminant(const struct equation *e)
{
    return dd_add(dd_mul(e->b, e->b), dd_neg(dd_mul(e->a, e->c))).hi;
}

/* The interval inside the side for a line that is as steep as the side, or steeper: beyond the root
 * on the side where w grows. If w does not grow, the line is parallel to the side and the slope is
 * 0. */
static bool steep_side(const struct equation *e, double side[2])
{
    double square = discriminant(e), root = square > 0 ? sqrt(square) : 0;
    double q = e->b.hi < 0 ? root - e->b.hi : -root - e->b.hi;
    double first = q / e->a.hi, second = q == 0 ? 0 : e->c.hi / q;
    side[0] = -INFINITY;
    side[1] = INFINITY;
    if (e->grows == 0 || (e->a.hi == 0 && q == 0))
        return e->c.hi < 0;
    if (e->a.hi == 0)
        side[q < 0] = second;
    else if (e->grows > 0)
        side[0] = pen_larger(first, second);
    else
        side[1] = first < second ? first : second;
    return side[0] < side[1];
}

static bool side_of(const struct equation *e, double side[2])
{
    if (e->a.hi <= 0)
        return steep_side(e, side);
    dd_roots(e->a, e->b, e->c, side);
    return side[0] < side[1];
}

/* The interval of the ray's line inside the side, in double-double. If the roots are close
 * together, compared with their distance from the origin, they are computed relative to the point
 * between them. A line that is nearly as steep as the side and passes near the apex loses digits in
 * A, B and C, and again in B^2 - A C. From afar, that loss exceeds double-double precision. */
static bool side_refined(const struct pen_cone *c, const struct pen_ray *ray, double side[2])
{
    struct equation e = equation_of(c, ray);
    double middle = -e.b.hi / e.a.hi;
    if (!(4 * discriminant(&e) < e.b.hi * e.b.hi) || isinf(middle))
        return side_of(&e, side);
    struct dd3 f = dd_sub3(ray->o, c->hull.round.q);
    struct dd3 moved = {two_prod(ray->d.x, middle), two_prod(ray->d.y, middle),
                        two_prod(ray->d.z, middle)};
    e = equation_from(c, dd_add3(f, moved), ray->d);
    bool inside = side_of(&e, side);
    side[0] += middle;
    side[1] += middle;
    return inside && side[0] < side[1];
}

/* The interval of the ray's line inside the side; false if there is none; a tangent is a miss. As
 * for cylinders, the roots are computed relative to the point at tp, where the equation has its
 * minimum. They are computed in double-double if this would lose digits:
 *  - the line is steep: k^2 is a quarter of m.m or more;
 *  - it passes near the apex: the radius at tp is less than an eighth of the largest radius;
 *  - the ray starts near the side, or grazes it: as for cylinders. */
static bool side_interval(const struct pen_cone *c, const struct pen_ray *ray, double side[2])
{
    struct pen_vec3 q = pen_permuted(ray, &c->hull.round.q),
                    a = pen_permuted(ray, &c->hull.round.a);
    struct pen_vec3 m = pen_cross(ray->permuted_d, a);
    struct pen_vec3 n = pen_axis_across(ray->permuted_o, q, a);
    double k = c->slope * pen_dot_guarded(ray->permuted_d, a), mm = pen_dot(m, m);
    double w = c->width + c->slope * pen_dot2(pen_sub(ray->permuted_o, q), a);
    if (!(4 * (k * k) < mm))
        return side_refined(c, ray, side);
    double inv = 1 / (mm - k * k), tp = (k * w - pen_dot(m, n)) * inv;
    struct pen_vec3 l = pen_along_once(n, m, tp);
    double wp = fma(k, tp, w), rest = (k * wp - pen_dot(l, m)) * inv;
    double disc = wp * wp - pen_dot(l, l), h = sqrt(disc * inv); /* NaN for a miss */
    side[0] = tp + (rest - h);
    side[1] = tp + (rest + h);
    double widest = c->hull.round.r * c->hull.round.length;
    if (8 * fabs(wp) < widest || fabs(disc) < PEN_GRAZING * (wp * wp) ||
        fabs(fabs(tp) - h) < ray->near * h)
        return side_refined(c, ray, side);
    return side[0] < side[1];
}

bool pen_cone_interval(const struct pen_cone *c, const struct pen_ray *ray, struct pen_interval *in)
{
    double side[2];
    if (!pen_cylinder_slab(&c->hull, ray, in) || !side_interval(c, ray, side) ||
        !pen_interval_clip(in, side))
        return false;
    if (!pen_cylinder_slab_loses(&c->hull, ray))
        return true;
    pen_cylinder_slab_refine(&c->hull, ray, in);
    return pen_interval_clip(in, side);
}

/* The place of a point in the half plane through the axis and the point. */
struct place {
    double outside; /* distance from the side, negative inside */
    double height;  /* over the base */
    double axis;    /* distance from the axis */
    double radius;  /* of the cone at that height; negative beyond an apex */
};

static struct place place_of(const struct pen_cone *c, struct pen_vec3 p)
{
    const struct pen_cylinder_side *round = &c->hull.round;
    struct place at;
    at.height = pen_dot2(pen_sub(p, round->q), round->a) / round->length;
    at.axis = pen_length(pen_cylinder_side_across(round, p)) / round->length;
    at.radius = c->base_radius + c->slope * at.height;
    at.outside = (at.axis - at.radius) / c->slant;
    return at;
}

static double own_rounding(const struct pen_cone *c)
{
    return 8 * PEN_U * (c->hull.round.r + c->hull.h);
}

/* The distance by which a point that was projected on the side may miss it, as pen_prim_rounding.
 */
static double rounding_at(const struct pen_cone *c, struct pen_vec3 p)
{
    return 16 * PEN_U * pen_norm1(p) + 2 * own_rounding(c);
}

/* The parts that the cone has. */
static unsigned parts(const struct pen_cone *c)
{
    unsigned caps = c->top_radius > 0 ? PEN_ON_BASE | PEN_ON_TOP : PEN_ON_BASE;
    return c->hull.caps ? PEN_ON_SIDE | caps : PEN_ON_SIDE;
}

/* The parts that p lies on, up to b; open ends as pen_cylinder_touches. */
static unsigned parts_at(const struct pen_cone *c, struct pen_vec3 p, double b)
{
    struct place at = place_of(c, p);
    double length = c->hull.round.length, above_base = at.height - c->hull.slab_base / length;
    double below_top = c->hull.h - at.height + (c->hull.slab_top - c->hull.top) / length;
    if (!(-b <= above_base && -b <= below_top && at.outside <= b))
        return 0;
    unsigned on = at.outside >= -b ? PEN_ON_SIDE : 0;
    if (on == 0 && !c->hull.caps)
        return 0;
    if (above_base <= b)
        on |= PEN_ON_BASE;
    if (c->top_radius > 0 && below_top <= b)
        on |= PEN_ON_TOP;
    return on;
}

/* Whether p is the apex, up to b: the side has no tangent plane there. */
static bool at_apex(const struct pen_cone *c, struct pen_vec3 p, double b)
{
    struct place at = place_of(c, p);
    return c->top_radius == 0 && fabs(at.height - c->hull.h) <= b && at.axis <= b;
}

/* The interval inside the side of a line through the ray's origin, which is on the side: C = 0, and
 * one end is exactly there. Returns false if the line only touches the side. */
static bool side_from(const struct pen_cone *c, const struct pen_ray *ray, double b, double side[2])
{
    struct equation e = equation_of(c, ray);
    bool steep = e.a.hi <= 0, apex = at_apex(c, ray->o, b);
    if (apex ? !steep || e.grows == 0 : e.b.hi == 0)
        return false;
    bool inward = apex ? e.grows > 0 : e.b.hi < 0;
    double other = apex || steep ? INFINITY : fabs(2 * e.b.hi / e.a.hi);
    side[0] = inward ? 0 : -other;
    side[1] = inward ? other : 0;
    return true;
}

/* As pen_cone_interval for a ray whose origin lies on the parts `on`, within b. */
static bool interval_from(const struct pen_cone *c, const struct pen_ray *ray, unsigned on,
                          double b, struct pen_interval *in)
{
    double side[2];
    if (!pen_cylinder_slab_from(&c->hull, ray, on, in))
        return false;
    bool inside = on & PEN_ON_SIDE ? side_from(c, ray, b, side) : side_interval(c, ray, side);
    return inside && pen_interval_clip(in, side);
}

/* Whether a ray that leaves the cone at `part` goes inward. If so, in->hi is where it leaves again
 * (hi <= 0: at once). */
static bool goes_inward(const struct pen_cone *c, const struct pen_ray *ray, uint8_t part,
                        struct pen_interval *in)
{
    double side[2] = {0, 0}, da = pen_cylinder_along(&c->hull, ray);
    if (part == PEN_PART_SIDE && !(side_from(c, ray, rounding_at(c, ray->o), side) && side[1] > 0))
        return false;
    if ((part == PEN_PART_BASE && !(da > 0)) || (part == PEN_PART_TOP && !(da < 0)))
        return false;
    if (part != PEN_PART_SIDE && !side_interval(c, ray, side))
        side[1] = 0;
    pen_cylinder_slab(&c->hull, ray, in);
    pen_interval_clip(in, side);
    return true;
}

/* Adds an end of the inside. The slab ends a pointed cone at its apex, which belongs to the side.
 */
static void add_end(const struct pen_cone *c, double t, uint8_t part, struct pen_intersections *out)
{
    if (part == PEN_PART_TOP && c->top_radius == 0)
        part = PEN_PART_SIDE;
    pen_intersections_add_end(out, parts(c), t, part);
}

static void add_ends(const struct pen_cone *c, const struct pen_interval *in,
                     struct pen_intersections *out)
{
    add_end(c, in->lo, in->lo_part, out);
    add_end(c, in->hi, in->hi_part, out);
}

static bool make(void *self, const struct pen_prim_source *from)
{
    struct pen_cone *c = self;
    if (!pen_cone_make(c, from->point, from->direction, from->length[PEN_RADIUS],
                       from->length[PEN_TOP_RADIUS], from->length[PEN_HEIGHT], from->caps))
        return false;
    pen_cylinder_set_rim(&c->hull, from->rounding);
    join_within_rounding(c);
    return true;
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    struct pen_interval in;
    if (pen_cone_interval(self, ray, &in))
        add_ends(self, &in, out);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    const struct pen_cone *c = self;
    const struct pen_cylinder_side *round = &c->hull.round;
    if (part != PEN_PART_SIDE)
        return pen_cylinder_normal(&c->hull, part, p);
    struct pen_vec3 axis = pen_cylinder_normal(&c->hull, PEN_PART_TOP, p);
    if (at_apex(c, p, rounding_at(c, p)))
        return axis;
    struct pen_vec3 away = pen_cylinder_side_normal(round, p);
    return pen_normalize(pen_along(away, axis, -c->slope));
}

bool pen_cone_apex_normal(const struct pen_cone *c, struct pen_vec3 p, struct pen_vec3 d,
                          struct pen_vec3 *n)
{
    if (!at_apex(c, p, rounding_at(c, p)))
        return false;
    const struct pen_vec3 axis = pen_cylinder_normal(&c->hull, PEN_PART_TOP, p);
    const struct pen_vec3 across = pen_along(pen_neg(d), axis, pen_dot(d, axis));
    const bool on_axis = pen_length(across) <= 64 * PEN_U * pen_length(d);
    const struct pen_vec3 away = on_axis ? pen_across(axis).u : pen_normalize(across);
    *n = pen_normalize(pen_along(away, axis, -c->slope));
    return pen_dot(*n, d) < 0;
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    const struct pen_cone *c = self;
    if (part != PEN_PART_SIDE)
        return pen_cylinder_project(&c->hull, part, p);
    return pen_along(p, normal(c, part, p), -place_of(c, p).outside);
}

static struct pen_box bounds(const void *self)
{
    const struct pen_cone *c = self;
    const struct pen_cylinder_side *round = &c->hull.round;
    struct pen_vec3 axis = pen_cylinder_normal(&c->hull, PEN_PART_TOP, round->q);
    struct pen_vec3 rim =
        pen_vec3(sqrt(axis.y * axis.y + axis.z * axis.z), sqrt(axis.z * axis.z + axis.x * axis.x),
                 sqrt(axis.x * axis.x + axis.y * axis.y));
    double out = pen_cylinder_reaches_out(&c->hull), wider = fabs(c->slope) * out;
    double base_radius = c->base_radius + wider, top_radius = c->top_radius + wider;
    struct pen_vec3 base = pen_along(round->q, axis, -out);
    struct pen_vec3 top = pen_along(round->q, axis, c->hull.h + out);
    struct pen_box b = pen_box_empty();
    b = pen_box_add_point(b, pen_along(base, rim, -base_radius));
    b = pen_box_add_point(b, pen_along(base, rim, base_radius));
    b = pen_box_add_point(b, pen_along(top, rim, -top_radius));
    b = pen_box_add_point(b, pen_along(top, rim, top_radius));
    return pen_box_grow(b, round->r + c->hull.h);
}

static double scale(const void *self, struct pen_vec3 p)
{
    const struct pen_cone *c = self;
    (void)p;
    return c->hull.round.r + c->hull.h;
}

static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_cone *c = self;
    const struct pen_cylinder_side *round = &c->hull.round;
    double along = pen_dot(n, round->a) / round->length;
    double rim = pen_length(pen_cross(n, round->a)) / round->length;
    return pen_dot(n, pen_sub(round->q, p)) +
           pen_larger(c->base_radius * rim, c->top_radius * rim + along * c->hull.h);
}

static double curvature(const void *self, uint8_t part, struct pen_vec3 p)
{
    return part == PEN_PART_SIDE ? 1 / place_of(self, p).axis : 0;
}

static unsigned touches(const void *self, struct pen_vec3 p, double bound)
{
    return parts_at(self, p, bound + own_rounding(self));
}

static void intersect_own(const void *self, const struct pen_ray *ray, uint8_t part,
                          struct pen_intersections *out)
{
    struct pen_interval in;
    if (goes_inward(self, ray, part, &in))
        add_end(self, pen_larger(in.hi, PEN_FIRST_T), in.hi_part, out);
}

/* A ray that only grazes the rim of two parts, or the apex, meets the cone nowhere else. */
static unsigned intersect_touching(const void *self, const struct pen_ray *ray, double bound,
                                   struct pen_intersections *out)
{
    const struct pen_cone *c = self;
    double b = bound + own_rounding(c);
    unsigned on = parts_at(c, ray->o, b);
    struct pen_interval in;
    if (on == 0)
        return 0;
    out->count = 0;
    if (interval_from(c, ray, on, b, &in))
        add_ends(c, &in, out);
    bool rim = on & PEN_ON_SIDE && (on & (PEN_ON_BASE | PEN_ON_TOP) || at_apex(c, ray->o, b));
    return rim ? on & parts(c) : 0;
}

/* Whether the ray passes the rim of a cap, `height` above the base, within `bound`; *t is where it
 * passes the cap's plane. x is that point relative to the cap's middle; it is `beyond` the rim. The
 * ray's distance from the rim is that from the rim's tangent there. */
static bool passes_cap_rim(const struct pen_cone *c, const struct pen_ray *ray, double height,
                           double bound, double *t)
{
    struct pen_vec3 a = pen_cylinder_normal(&c->hull, PEN_PART_TOP, ray->o);
    struct pen_vec3 f = pen_sub(ray->o, c->hull.round.q);
    double da = pen_dot(ray->d, a);
    *t = (height - pen_dot2(f, a)) / da;
    if (!(*t > 0) || isinf(*t))
        return false;
    struct pen_vec3 x = pen_along(pen_along(f, a, -height), ray->d, *t);
    double beyond = pen_length(x) - (c->base_radius + c->slope * height);
    struct pen_vec3 across = pen_cross(ray->d, pen_cross(a, pen_normalize(x)));
    double off = beyond * da;
    return off * off <= bound * bound * pen_dot(across, across);
}

/* The side is inclined. So a ray that enters a cap within rounding of its rim may seem to pass
 * outside the cone, between its side and a neighbour that ends at the same rim. */
static bool passes_rim(const void *self, const struct pen_ray *ray, double bound, double *t,
                       uint8_t *part)
{
    const struct pen_cone *c = self;
    double side[2];
    *part = PEN_PART_BASE;
    if (c->hull.caps && passes_cap_rim(c, ray, 0, bound, t))
        return true;
    *part = PEN_PART_TOP;
    if (c->hull.caps)
        return c->top_radius > 0 && passes_cap_rim(c, ray, c->hull.h, bound, t);
    *part = PEN_PART_SIDE;
    return side_interval(c, ray, side) && pen_cylinder_passes_rim(&c->hull, ray, side, bound, t);
}

const struct pen_kind_functions pen_cone_functions = {
    .make = make,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .bounds = bounds,
    .scale = scale,
    .reach = reach,
    .curvature = curvature,
    .touches = touches,
    .intersect_own = intersect_own,
    .intersect_touching = intersect_touching,
    .passes_rim = passes_rim,
};
