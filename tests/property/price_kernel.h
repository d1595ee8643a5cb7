/* SPDX-License-Identifier: MIT */
/* The primitives of the methods. The including file defines PRICE_VARIANT, the variant's name.
 * Plain tests are the textbook's: for triangles Moeller and Trumbore ("Fast, minimum storage
 * ray/triangle intersection", 1997); for round primitives b^2 - a c; for polygons the plane, then
 * intersections of the projected outline. */
#include "property/price_methods.h"

typedef struct pen_vec3 vec3;

static inline double nearer(double t, double best)
{
    return t > 0 && t < best ? t : best;
}

#define EACH(set, kind, prim)                                                                      \
    double best = INFINITY, t;                                                                     \
    const struct world *w = &(set)->world[kind];                                                   \
    for (uint32_t i = 0; i < PRICE_PRIMS; i++) {                                                   \
        prim                                                                                       \
    }                                                                                              \
    return best;

static double robust_triangle(const struct price_set *set, const struct pen_ray *ray)
{
    EACH(set, PEN_PRIM_TRIANGLE,
         if (pen_triangle_root(&w->triangle[i], ray, &t)) best = nearer(t, best);)
}

static double robust_polygon(const struct price_set *set, const struct pen_ray *ray)
{
    EACH(set, PEN_PRIM_POLYGON,
         if (pen_polygon_root(&w->polygon[i], ray, &t)) best = nearer(t, best);)
}

static double robust_plane(const struct price_set *set, const struct pen_ray *ray)
{
    EACH(set, PEN_PRIM_PLANE, if (pen_plane_root(&w->plane[i], ray, &t)) best = nearer(t, best);)
}

static double robust_sphere(const struct price_set *set, const struct pen_ray *ray)
{
    double r[2];
    EACH(set, PEN_PRIM_SPHERE, (void)t;
         if (pen_sphere_roots(&w->sphere[i], ray, r)) best = nearer(r[0] > 0 ? r[0] : r[1], best);)
}

static double robust_tube(const struct price_set *set, const struct pen_ray *ray)
{
    double r[2];
    bool parallel;
    EACH(set, PEN_PRIM_INFINITE_CYLINDER, (void)t;
         if (pen_cylinder_side_roots(&w->infinite_cylinder[i].round, ray, r, &parallel)) best =
             nearer(r[0] > 0 ? r[0] : r[1], best);)
}

static double robust_cylinder(const struct price_set *set, const struct pen_ray *ray)
{
    struct pen_interval in;
    EACH(set, PEN_PRIM_CYLINDER, (void)t; if (pen_cylinder_interval(&w->cylinder[i], ray, &in))
                                              best = nearer(in.lo > 0 ? in.lo : in.hi, best);)
}

static double plain_triangle(const struct price_set *set, const struct pen_ray *ray)
{
    double best = INFINITY;
    for (int i = 0; i < PRICE_PRIMS; i++) {
        const vec3 *v = set->triangle[i];
        vec3 e = pen_sub(v[1], v[0]), f = pen_sub(v[2], v[0]), d = ray->d;
        vec3 p = pen_vec3(d.y * f.z - d.z * f.y, d.z * f.x - d.x * f.z, d.x * f.y - d.y * f.x);
        double det = pen_dot(e, p), inv = 1 / det;
        vec3 s = pen_sub(ray->o, v[0]);
        double u = pen_dot(s, p) * inv;
        if (!(u >= 0 && u <= 1))
            continue;
        vec3 q = pen_vec3(s.y * e.z - s.z * e.y, s.z * e.x - s.x * e.z, s.x * e.y - s.y * e.x);
        double w = pen_dot(d, q) * inv;
        if (w >= 0 && u + w <= 1)
            best = nearer(pen_dot(f, q) * inv, best);
    }
    return best;
}

static inline struct plain3 f3(vec3 v)
{
    return (struct plain3){(float)v.x, (float)v.y, (float)v.z};
}

static inline struct plain3 sub3(struct plain3 a, struct plain3 b)
{
    return (struct plain3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline float dot3(struct plain3 a, struct plain3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct plain3 cross3(struct plain3 a, struct plain3 b)
{
    return (struct plain3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline float nearer_f(float t, float best)
{
    return t > 0 && t < best ? t : best;
}

static double float_triangle(const struct price_set *set, const struct pen_ray *ray)
{
    struct plain3 o = f3(ray->o), d = f3(ray->d);
    float best = INFINITY;
    for (int i = 0; i < PRICE_PRIMS; i++) {
        const struct plain3 *v = set->triangle_f[i];
        struct plain3 e = sub3(v[1], v[0]), f = sub3(v[2], v[0]), p = cross3(d, f);
        float inv = 1 / dot3(e, p);
        struct plain3 s = sub3(o, v[0]);
        float u = dot3(s, p) * inv;
        if (!(u >= 0 && u <= 1))
            continue;
        struct plain3 q = cross3(s, e);
        float w = dot3(d, q) * inv;
        if (w >= 0 && u + w <= 1)
            best = nearer_f(dot3(f, q) * inv, best);
    }
    return (double)best;
}

/* Solves a t^2 + 2 b t + c by the textbook. */
static inline double quadratic(double a, double b, double c, double best)
{
    double disc = b * b - a * c;
    if (!(disc > 0))
        return best;
    double h = sqrt(disc), t = (-b - h) / a;
    return nearer(t > 0 ? t : (-b + h) / a, best);
}

static inline float quadratic_f(float a, float b, float c, float best)
{
    float disc = b * b - a * c;
    if (!(disc > 0))
        return best;
    float h = sqrtf(disc), t = (-b - h) / a;
    return nearer_f(t > 0 ? t : (-b + h) / a, best);
}

static double plain_sphere(const struct price_set *set, const struct pen_ray *ray)
{
    double best = INFINITY, a = pen_dot(ray->d, ray->d);
    for (int i = 0; i < PRICE_PRIMS; i++) {
        vec3 f = pen_sub(ray->o, set->center[i]);
        double r = set->radius[i];
        best = quadratic(a, pen_dot(f, ray->d), pen_dot(f, f) - r * r, best);
    }
    return best;
}

static double float_sphere(const struct price_set *set, const struct pen_ray *ray)
{
    struct plain3 o = f3(ray->o), d = f3(ray->d);
    float best = INFINITY, a = dot3(d, d);
    for (int i = 0; i < PRICE_PRIMS; i++) {
        struct plain3 f = sub3(o, set->center_f[i]);
        float r = set->radius_f[i];
        best = quadratic_f(a, dot3(f, d), dot3(f, f) - r * r, best);
    }
    return (double)best;
}

static double plain_tube(const struct price_set *set, const struct pen_ray *ray)
{
    double best = INFINITY, dd = pen_dot(ray->d, ray->d);
    for (int i = 0; i < PRICE_PRIMS; i++) {
        vec3 f = pen_sub(ray->o, set->center[i]), a = set->axis[i];
        double da = pen_dot(ray->d, a), fa = pen_dot(f, a), r = set->radius[i];
        best = quadratic(dd - da * da, pen_dot(f, ray->d) - da * fa,
                         pen_dot(f, f) - fa * fa - r * r, best);
    }
    return best;
}

static double float_tube(const struct price_set *set, const struct pen_ray *ray)
{
    struct plain3 o = f3(ray->o), d = f3(ray->d);
    float best = INFINITY, dd = dot3(d, d);
    for (int i = 0; i < PRICE_PRIMS; i++) {
        struct plain3 f = sub3(o, set->center_f[i]), a = set->axis_f[i];
        float da = dot3(d, a), fa = dot3(f, a), r = set->radius_f[i];
        best = quadratic_f(dd - da * da, dot3(f, d) - da * fa, dot3(f, f) - fa * fa - r * r, best);
    }
    return (double)best;
}

/* The side by the textbook, where only intersections between the ends count; then the discs. */
static double plain_cylinder(const struct price_set *set, const struct pen_ray *ray)
{
    double best = INFINITY, dd = pen_dot(ray->d, ray->d);
    for (int i = 0; i < PRICE_PRIMS; i++) {
        vec3 f = pen_sub(ray->o, set->center[i]), axis = set->axis[i];
        double da = pen_dot(ray->d, axis), fa = pen_dot(f, axis), r = set->radius[i];
        double a = dd - da * da, b = pen_dot(f, ray->d) - da * fa;
        double c = pen_dot(f, f) - fa * fa - r * r, disc = b * b - a * c;
        if (!(disc > 0))
            continue;
        double h = sqrt(disc), side[2] = {(-b - h) / a, (-b + h) / a};
        for (int k = 0; k < 2; k++) {
            double high = fa + side[k] * da, cap = (k * PRICE_HEIGHT - fa) / da;
            if (high > 0 && high < PRICE_HEIGHT)
                best = nearer(side[k], best);
            if (a * cap * cap + 2 * b * cap + c < 0)
                best = nearer(cap, best);
        }
    }
    return best;
}

static double float_cylinder(const struct price_set *set, const struct pen_ray *ray)
{
    struct plain3 o = f3(ray->o), d = f3(ray->d);
    float best = INFINITY, dd = dot3(d, d), height = (float)PRICE_HEIGHT;
    for (int i = 0; i < PRICE_PRIMS; i++) {
        struct plain3 f = sub3(o, set->center_f[i]), axis = set->axis_f[i];
        float da = dot3(d, axis), fa = dot3(f, axis), r = set->radius_f[i];
        float a = dd - da * da, b = dot3(f, d) - da * fa;
        float c = dot3(f, f) - fa * fa - r * r, disc = b * b - a * c;
        if (!(disc > 0))
            continue;
        float h = sqrtf(disc), side[2] = {(-b - h) / a, (-b + h) / a};
        for (int k = 0; k < 2; k++) {
            float high = fa + side[k] * da, cap = ((float)k * height - fa) / da;
            if (high > 0 && high < height)
                best = nearer_f(side[k], best);
            if (a * cap * cap + 2 * b * cap + c < 0)
                best = nearer_f(cap, best);
        }
    }
    return (double)best;
}

static double plain_plane(const struct price_set *set, const struct pen_ray *ray)
{
    double best = INFINITY;
    for (int i = 0; i < PRICE_PRIMS; i++)
        best = nearer(pen_dot(set->axis[i], pen_sub(set->center[i], ray->o)) /
                          pen_dot(set->axis[i], ray->d),
                      best);
    return best;
}

static double float_plane(const struct price_set *set, const struct pen_ray *ray)
{
    struct plain3 o = f3(ray->o), d = f3(ray->d);
    float best = INFINITY;
    for (int i = 0; i < PRICE_PRIMS; i++)
        best = nearer_f(dot3(set->axis_f[i], sub3(set->center_f[i], o)) / dot3(set->axis_f[i], d),
                        best);
    return (double)best;
}

/* The plane, then intersections of the outline without one coordinate. */
static double plain_polygon(const struct price_set *set, const struct pen_ray *ray)
{
    double best = INFINITY;
    const struct world *w = &set->world[PEN_PRIM_POLYGON];
    for (int i = 0; i < PRICE_PRIMS; i++) {
        const struct pen_polygon *p = &w->polygon[i];
        double t = pen_dot(p->facet.n, pen_sub(p->v[0], ray->o)) / pen_dot(p->facet.n, ray->d);
        double nx = fabs(p->facet.n.x), ny = fabs(p->facet.n.y), nz = fabs(p->facet.n.z);
        int drop = nx > ny ? (nx > nz ? 0 : 2) : (ny > nz ? 1 : 2), a = drop == 0,
            b = 2 - (drop == 2);
        bool inside = false;
        vec3 at = pen_along(ray->o, ray->d, t);
        double x = (&at.x)[a], y = (&at.x)[b];
        for (uint32_t k = 0, j = p->count - 1; k < p->count; j = k++) {
            double xk = (&p->v[k].x)[a], yk = (&p->v[k].x)[b];
            double xj = (&p->v[j].x)[a], yj = (&p->v[j].x)[b];
            if ((yk > y) != (yj > y) && x < (xj - xk) * (y - yk) / (yj - yk) + xk)
                inside = !inside;
        }
        if (inside)
            best = nearer(t, best);
    }
    return best;
}

static const struct price_method methods[] = {
    {"triangle", "robust: half-open winding, exact signs, " PRICE_VARIANT, robust_triangle},
    {"triangle", "plain Moeller-Trumbore in double, " PRICE_VARIANT, plain_triangle},
    {"triangle", "plain Moeller-Trumbore in float, " PRICE_VARIANT, float_triangle},
    {"polygon of 4", "robust: half-open winding, exact signs, " PRICE_VARIANT, robust_polygon},
    {"polygon of 4", "plain: plane, then even-odd, in double, " PRICE_VARIANT, plain_polygon},
    {"sphere", "robust, " PRICE_VARIANT, robust_sphere},
    {"sphere", "plain b^2 - a c in double, " PRICE_VARIANT, plain_sphere},
    {"sphere", "plain b^2 - a c in float, " PRICE_VARIANT, float_sphere},
    {"tube", "robust, " PRICE_VARIANT, robust_tube},
    {"tube", "plain d.d - (d.a)^2 in double, " PRICE_VARIANT, plain_tube},
    {"tube", "plain d.d - (d.a)^2 in float, " PRICE_VARIANT, float_tube},
    {"cylinder", "robust, capped, " PRICE_VARIANT, robust_cylinder},
    {"cylinder", "plain side and discs in double, " PRICE_VARIANT, plain_cylinder},
    {"cylinder", "plain side and discs in float, " PRICE_VARIANT, float_cylinder},
    {"plane", "robust, " PRICE_VARIANT, robust_plane},
    {"plane", "plain in double, " PRICE_VARIANT, plain_plane},
    {"plane", "plain in float, " PRICE_VARIANT, float_plane},
};
