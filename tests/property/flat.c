/* SPDX-License-Identifier: MIT */
#include "property/flat.h"

#include "property/gen.h"

int flat_case(const struct row_case *c, vec3 *v, struct oracle_ray *line)
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

void flat_put(struct row_case *c, const vec3 *v, int count, vec3 o, vec3 d)
{
    row_fixed(c, count);
    for (int i = 0; i < count; i++)
        row_arg3(c, v[i]);
    row_arg3(c, o);
    row_arg3(c, d);
}

bool flat_cross(const vec3 *v, int count, const struct pen_ray *ray, double *t, bool *made)
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

struct lattice flat_lattice(struct random *r)
{
    struct lattice l;
    l.at = gen_dyadic3(r, 4);
    do {
        l.e = gen_dyadic3(r, 2);
        l.f = gen_dyadic3(r, 2);
    } while (pen_norm1(pen_cross(l.e, l.f)) < .25);
    return l;
}

vec3 flat_lattice_point(const struct lattice *l, double i, double j)
{
    return pen_along(pen_along(l->at, l->e, i), l->f, j);
}
