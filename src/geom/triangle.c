/* SPDX-License-Identifier: MIT */
/* Triangles: how they are made. */
#include "pen/geom/triangle.h"

#include "make.h"
#include "twofold.h"

/* Whether a comes before b by x, then y, then z. */
static bool before(struct pen_vec3 a, struct pen_vec3 b)
{
    if (a.x != b.x)
        return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

static void order(struct pen_vec3 *a, struct pen_vec3 *b)
{
    struct pen_vec3 first = before(*b, *a) ? *b : *a;
    *b = before(*b, *a) ? *a : *b;
    *a = first;
}

bool pen_triangle_make(struct pen_triangle *tri, struct pen_vec3 a, struct pen_vec3 b,
                       struct pen_vec3 c)
{
    if (!is_finite3(a) || !is_finite3(b) || !is_finite3(c))
        return false;
    *tri = (struct pen_triangle){.v = {a, b, c}};
    struct twofold3 e = tf_sub3(b, a), f = tf_sub3(c, a);
    struct pen_vec3 n = tf_round3(tf_cross(e, f));
    /* Below this, the cross product may be nothing but its own rounding. */
    double least = 0x1p-90 * pen_largest3(tf_round3(e)) * pen_largest3(tf_round3(f));
    if (!is_finite3(n) || !(pen_largest3(n) > least))
        return false;
    tri->n = pen_unit_of(n);
    order(&tri->v[0], &tri->v[1]);
    order(&tri->v[1], &tri->v[2]);
    order(&tri->v[0], &tri->v[1]);
    return true;
}

struct pen_box pen_triangle_bounds(const struct pen_triangle *tri)
{
    struct pen_box b = pen_box_empty();
    for (int i = 0; i < 3; i++)
        b = pen_box_add_point(b, tri->v[i]);
    return b;
}

double pen_triangle_extent(const struct pen_triangle *tri)
{
    struct pen_box b = pen_triangle_bounds(tri);
    return pen_largest3(pen_sub(b.hi, b.lo));
}

void pen_triangle_refine(const struct pen_triangle *tri, const struct pen_ray *ray, double *t)
{
    const struct pen_vec3 *v = tri->v;
    struct twofold3 n = tf_cross(tf_sub3(v[1], v[0]), tf_sub3(v[2], v[0]));
    double far = tf_dot(n, tf_sub3(v[0], ray->o)).hi, nd = tf_dot(n, tf_of3(ray->d)).hi;
    double plane = far / nd, least = INFINITY, most = -INFINITY;
    if (!(fabs(plane) < INFINITY)) /* seen edge-on */
        return;
    for (int i = 0; i < 3; i++) {
        double depth = pen_shear(ray, &v[i]).z * ray->sz;
        least = depth < least ? depth : least;
        most = depth > most ? depth : most;
    }
    *t = plane < least ? least : plane > most ? most : plane;
}
