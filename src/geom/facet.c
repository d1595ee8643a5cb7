/* SPDX-License-Identifier: MIT */
/* Facets seen at a grazing angle. */
#include "geom/facet.h"

/* An edge that intersects y = 0 in ray space: there x = s / h, and the depth is w / h. */
struct edge_depth {
    double s, w, h; /* h > 0; 0 if there is none yet */
    double error;   /* of the depth */
};

/* Twice the area of (ray, P, Q), as pen_edge, with equal magnitude for PQ and QP.
 * Source: Jeannerod, "A radix-independent error analysis of the Cornea-Harrison-Tang method",
 * ACM TOMS 42(3), 2016. */
static double edge_even(struct pen_sheared p, struct pen_sheared q)
{
    double a = p.x * q.y, b = p.y * q.x;
    return (a - b) + (fma(p.x, q.y, -a) - fma(p.y, q.x, -b));
}

static double larger_size(double a, double b)
{
    return fabs(a) > fabs(b) ? fabs(a) : fabs(b);
}

/* An upward edge, or a downward one reversed: up = -1. */
static struct edge_depth edge_depth_of(struct pen_sheared a, struct pen_sheared b, double up)
{
    return (struct edge_depth){up * edge_even(a, b), up * (a.z * b.y - a.y * b.z), up * (b.y - a.y),
                               4 * PEN_U * larger_size(a.z, b.z)};
}

/* Whether e is farther right than f. Edges that intersect y = 0 in the same point are ordered too.
 * So t depends neither on the first vertex of the outline nor on its direction. */
static bool is_right_of(struct edge_depth e, struct edge_depth f)
{
    double ef = e.s * f.h, fe = f.s * e.h;
    return ef > fe || (ef == fe && (e.h > f.h || (e.h == f.h && e.w > f.w)));
}

/* The edges nearest the ray on both sides: out[0] at x <= 0, out[1] at x > 0. */
static void nearest_edges(const struct pen_vec3 *v, uint32_t count, const struct pen_ray *ray,
                          struct edge_depth out[2])
{
    struct pen_sheared a = pen_shear(ray, &v[count - 1]);
    for (uint32_t i = 0; i < count; i++) {
        struct pen_sheared b = pen_shear(ray, &v[i]);
        if ((a.y <= 0) != (b.y <= 0)) {
            struct edge_depth e = edge_depth_of(a, b, a.y <= 0 ? 1 : -1);
            bool right = e.s > 0;
            if (out[right].h == 0 || is_right_of(right ? out[1] : e, right ? e : out[0]))
                out[right] = e;
        }
        a = b;
    }
}

double pen_outline_grazed(const struct pen_vec3 *v, uint32_t count, const struct pen_ray *ray,
                          double t)
{
    struct edge_depth at[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}};
    nearest_edges(v, count, ray, at);
    if (!(fabs(t) < INFINITY))
        return (at[0].w * at[1].s - at[1].w * at[0].s) * ray->sz /
               (at[1].s * at[0].h - at[0].s * at[1].h);
    double z = t * ray->permuted_d.z, left = at[0].w / at[0].h, right = at[1].w / at[1].h;
    int first = left > right;
    double least = first ? right : left, most = first ? left : right;
    double kept = z < least - at[first].error ? least : z > most + at[!first].error ? most : z;
    double t_kept = kept * ray->sz; /* sz may be negative */
    return kept != z && (t > 0 || t_kept < 0) ? t_kept : t;
}
