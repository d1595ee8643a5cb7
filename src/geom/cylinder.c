/* SPDX-License-Identifier: MIT */
/* Cylinders: the functions that are not hot. */
#include "geom/cylinder.h"

#include "geom/internal/cylinder_side.h"
#include "geom/internal/double_double.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"
#include "math/scale.h"

void pen_cylinder_set_rim(struct pen_cylinder *c, double rounding)
{
    struct dd3 a = dd_of3(c->round.a);
    struct dd top = dd_mul((struct dd){c->h, 0}, dd_sqrt(dd_dot(a, a)));
    double size = c->round.r + c->h, most = rounding < size ? rounding : size;
    double place = pen_norm1(c->round.q), near = place < 0x1p12 * size ? place : 0x1p12 * size;
    c->rim = c->caps ? 0 : 8 * (PEN_U * (place + size) + most);
    c->joint = c->caps ? 8 * (PEN_U * (near + size) + most) * c->round.length : 0;
    c->edge_on = c->caps ? PEN_EDGE_ON / 2 * c->round.length : 0; /* which is below 2 */
    struct dd end = dd_add(top, (struct dd){c->rim * c->round.length, 0});
    c->slab_base = -c->rim * c->round.length;
    c->slab_top = end.hi;
    c->slab_top_low = end.lo;
}

bool pen_cylinder_make(struct pen_cylinder *c, struct pen_vec3 base, struct pen_vec3 axis, double r,
                       double h, bool caps)
{
    if (!is_length(h) || !pen_cylinder_side_make(&c->round, base, axis, r))
        return false;
    struct dd3 a = dd_of3(c->round.a);
    struct dd top = dd_mul((struct dd){h, 0}, dd_sqrt(dd_dot(a, a)));
    c->top = top.hi;
    c->h = h;
    c->caps = caps;
    pen_cylinder_set_rim(c, 0);
    return true;
}

bool pen_cylinder_holds(const struct pen_cylinder *c, const struct pen_ray *ray)
{
    struct dd3 a = dd_of3(c->round.a), d = dd_of3(ray->d), f = dd_sub3(ray->o, c->round.q);
    struct dd da = dd_dot(d, a), height = dd_dot(f, a);
    struct pen_vec3 across = pen_permuted(ray, &c->round.a);
    if (da.hi != 0) { /* at the point of the line nearest the axis */
        struct dd3 m = dd_cross(d, a);
        double tp = -dd_dot(m, dd_cross(f, a)).hi / dd_dot(m, m).hi;
        height = dd_add(height, dd_mul(da, (struct dd){tp, 0}));
    }
    double above = dd_add(height, (struct dd){-c->slab_base, 0}).hi;
    double below = dd_add((struct dd){c->slab_top, c->slab_top_low}, dd_neg(height)).hi;
    bool up = across.x != 0 ? across.x > 0 : across.y > 0;
    if (!c->caps)
        return above > 0 && below > 0;
    return (up ? above >= -c->joint : above > 0) && (up ? below > 0 : below >= -c->joint);
}

void pen_cylinder_slab_refine(const struct pen_cylinder *c, const struct pen_ray *ray,
                              struct pen_interval *in)
{
    struct dd3 a = dd_of3(c->round.a);
    struct dd fa = dd_dot(dd_sub3(ray->o, c->round.q), a);
    struct dd rest = dd_add((struct dd){c->slab_top, c->slab_top_low}, dd_neg(fa));
    struct dd below = dd_add((struct dd){c->slab_base, 0}, dd_neg(fa));
    double da = dd_dot(dd_of3(ray->d), a).hi, base = below.hi / da, top = rest.hi / da;
    if (pen_cylinder_edge_on(c, ray, pen_cylinder_along(c, ray)))
        return;
    if (da > 0)
        *in = (struct pen_interval){base, top, PEN_PART_BASE, PEN_PART_TOP};
    else
        *in = (struct pen_interval){top, base, PEN_PART_TOP, PEN_PART_BASE};
}

bool pen_cylinder_slab_from(const struct pen_cylinder *c, const struct pen_ray *ray, unsigned on,
                            struct pen_interval *in)
{
    bool slab = pen_cylinder_slab(c, ray, in);
    double da = pen_cylinder_along(c, ray);
    if (on & (da > 0 ? PEN_ON_BASE : PEN_ON_TOP))
        in->lo = 0;
    if (on & (da > 0 ? PEN_ON_TOP : PEN_ON_BASE))
        in->hi = 0;
    return slab && !(da == 0 && on & (PEN_ON_BASE | PEN_ON_TOP));
}

/* The t-interval of the infinite side with one end at the origin. */
static bool side_from(const struct pen_cylinder_side *s, const struct pen_ray *ray, double side[2])
{
    double chord = pen_cylinder_side_chord(s, ray);
    side[0] = chord < 0 ? chord : 0;
    side[1] = chord < 0 ? 0 : chord;
    return chord != 0;
}

/* As pen_cylinder_interval for a ray whose origin lies on the parts `on`. */
static bool interval_from(const struct pen_cylinder *c, const struct pen_ray *ray, unsigned on,
                          struct pen_interval *in)
{
    double side[2];
    bool parallel = false;
    if (!pen_cylinder_slab_from(c, ray, on, in))
        return false;
    if (!(on & PEN_ON_SIDE ? side_from(&c->round, ray, side)
                           : pen_cylinder_side_roots(&c->round, ray, side, &parallel)))
        return parallel && pen_cylinder_side_contains(&c->round, ray->o) && in->lo < in->hi;
    return pen_interval_clip(in, side);
}

/* Whether a ray that starts on `part` of the cylinder goes inward. If so, in->hi, in->hi_part are
 * where it leaves again (hi <= 0: at once). */
static bool goes_inward(const struct pen_cylinder *c, const struct pen_ray *ray, uint8_t part,
                        struct pen_interval *in)
{
    double side[2] = {0, 0}, da = pen_cylinder_along(c, ray);
    if (part == PEN_PART_SIDE) {
        side[1] = pen_cylinder_side_chord(&c->round, ray);
        if (!(side[1] > 0))
            return false;
        pen_cylinder_slab(c, ray, in);
    } else {
        if (part == PEN_PART_BASE ? !(da > 0) : !(da < 0))
            return false;
        pen_cylinder_slab(c, ray, in);
        bool parallel;
        if (!pen_cylinder_side_roots(&c->round, ray, side, &parallel))
            side[1] = parallel && pen_cylinder_side_contains(&c->round, ray->o) ? INFINITY : 0;
    }
    pen_interval_clip(in, side);
    return true;
}

static struct pen_vec3 axis_unit(const struct pen_cylinder *c)
{
    struct pen_vec3 a = c->round.a;
    double length = c->round.length;
    return pen_vec3(a.x / length, a.y / length, a.z / length);
}

struct pen_vec3 pen_cylinder_normal(const struct pen_cylinder *c, uint8_t part, struct pen_vec3 p)
{
    if (part == PEN_PART_SIDE)
        return pen_cylinder_side_normal(&c->round, p);
    return part == PEN_PART_TOP ? axis_unit(c) : pen_neg(axis_unit(c));
}

struct pen_vec3 pen_cylinder_project(const struct pen_cylinder *c, uint8_t part, struct pen_vec3 p)
{
    if (part == PEN_PART_SIDE)
        return pen_cylinder_side_project(&c->round, p);
    struct pen_vec3 n = axis_unit(c);
    double height = pen_dot2(n, pen_sub(p, c->round.q));
    return pen_along(p, n, (part == PEN_PART_TOP ? c->h : 0) - height);
}

/* The parts that the cylinder has. */
static unsigned parts(const struct pen_cylinder *c)
{
    return c->caps ? PEN_ON_SIDE | PEN_ON_BASE | PEN_ON_TOP : PEN_ON_SIDE;
}

/* Adds both ends of the inside, except ends at caps of an open cylinder. */
static void add_ends(const struct pen_cylinder *c, const struct pen_interval *in,
                     struct pen_intersections *out)
{
    pen_intersections_add_end(out, parts(c), in->lo, in->lo_part);
    pen_intersections_add_end(out, parts(c), in->hi, in->hi_part);
}

static bool make(void *self, const struct pen_prim_source *from)
{
    if (!pen_cylinder_make(self, from->point, from->direction, from->length[PEN_RADIUS],
                           from->length[PEN_HEIGHT], from->caps))
        return false;
    pen_cylinder_set_rim(self, from->rounding);
    return true;
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    struct pen_interval in;
    if (pen_cylinder_interval(self, ray, &in))
        add_ends(self, &in, out);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    return pen_cylinder_normal(self, part, p);
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    return pen_cylinder_project(self, part, p);
}

static struct pen_box bounds(const void *self)
{
    const struct pen_cylinder *c = self;
    const struct pen_cylinder_side *s = &c->round;
    struct pen_vec3 a = s->a;
    double k = s->r / s->length;
    struct pen_vec3 reach =
        pen_vec3(k * sqrt(a.y * a.y + a.z * a.z), k * sqrt(a.z * a.z + a.x * a.x),
                 k * sqrt(a.x * a.x + a.y * a.y));
    double out = pen_cylinder_reaches_out(c);
    struct pen_vec3 base = pen_along(s->q, axis_unit(c), -out);
    struct pen_vec3 top = pen_along(s->q, axis_unit(c), c->h + out);
    struct pen_box b = pen_box_empty();
    b = pen_box_add_point(b, pen_sub(base, reach));
    b = pen_box_add_point(b, pen_add(base, reach));
    b = pen_box_add_point(b, pen_sub(top, reach));
    b = pen_box_add_point(b, pen_add(top, reach));
    return pen_box_grow(b, s->r + c->h);
}

static double scale(const void *self, struct pen_vec3 p)
{
    const struct pen_cylinder *c = self;
    (void)p;
    return c->round.r + c->h;
}

static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    const struct pen_cylinder *c = self;
    return pen_cylinder_side_reach(&c->round, c->round.q, c->h, n, p);
}

static double curvature(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)p;
    return part == PEN_PART_SIDE ? 1 / ((const struct pen_cylinder *)self)->round.r : 0;
}

static unsigned touches(const void *self, struct pen_vec3 p, double bound)
{
    return pen_cylinder_touches(self, p, bound);
}

static void intersect_own(const void *self, const struct pen_ray *ray, uint8_t part,
                          struct pen_intersections *out)
{
    const struct pen_cylinder *c = self;
    struct pen_interval in;
    if (goes_inward(c, ray, part, &in))
        pen_intersections_add_end(out, parts(c), pen_larger(in.hi, PEN_FIRST_T), in.hi_part);
}

/* A ray that only grazes the rim of two parts meets the cylinder nowhere else. */
static unsigned intersect_touching(const void *self, const struct pen_ray *ray, double bound,
                                   struct pen_intersections *out)
{
    const struct pen_cylinder *c = self;
    unsigned on = pen_cylinder_touches(c, ray->o, bound);
    struct pen_interval in;
    if (on == 0)
        return 0;
    out->count = 0;
    if (interval_from(c, ray, on, &in))
        add_ends(c, &in, out);
    bool rim = on & PEN_ON_SIDE && on & (PEN_ON_BASE | PEN_ON_TOP);
    return rim ? on & parts(c) : 0;
}

static bool passes_rim(const void *self, const struct pen_ray *ray, double bound, double *t,
                       uint8_t *part)
{
    const struct pen_cylinder *c = self;
    double side[2];
    bool parallel;
    *part = PEN_PART_SIDE;
    return !c->caps && pen_cylinder_side_roots(&c->round, ray, side, &parallel) &&
           pen_cylinder_passes_rim(c, ray, side, bound, t);
}

const struct pen_kind_functions pen_cylinder_functions = {
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
