/* SPDX-License-Identifier: MIT */
/* Triangles: the constructor, and the functions of their kind. */
#include "geom/triangle.h"

#include "geom/internal/facet.h"
#include "geom/internal/kinds.h"
#include "geom/internal/make.h"

/* The extents along x, y, z of the edge from p to q. Mirroring or moving the triangle does not
 * change them. */
static struct pen_vec3 edge_extents(struct pen_vec3 p, struct pen_vec3 q)
{
    return pen_vec3(fabs(q.x - p.x), fabs(q.y - p.y), fabs(q.z - p.z));
}

static struct pen_vec3 sorted(struct pen_vec3 s)
{
    double high = s.x > s.y ? s.x : s.y, low = s.x > s.y ? s.y : s.x;
    double most = high > s.z ? high : s.z, rest = high > s.z ? s.z : high;
    return rest > low ? pen_vec3(most, rest, low) : pen_vec3(most, low, rest);
}

/* < 0, 0 or > 0 if a is before, equal to or after b in the order by x, then y, then z. */
static int compare(struct pen_vec3 a, struct pen_vec3 b)
{
    if (a.x != b.x)
        return a.x < b.x ? -1 : 1;
    if (a.y != b.y)
        return a.y < b.y ? -1 : 1;
    return (a.z > b.z) - (a.z < b.z);
}

/* The corner that the edges distinguish: the one between two equal edges, or the one opposite the
 * greatest edge. -1 if all edges are equal. Edge i is opposite corner i. */
static int distinguished_by(const struct pen_vec3 edge[3])
{
    int greatest = 0;
    for (int i = 0; i < 3; i++) {
        bool equal = compare(edge[(i + 1) % 3], edge[(i + 2) % 3]) == 0;
        if (equal)
            return compare(edge[i], edge[(i + 1) % 3]) == 0 ? -1 : i;
        if (compare(edge[i], edge[greatest]) > 0)
            greatest = i;
    }
    return greatest;
}

/* The distinguished corner. It does not depend on the order of the corners, on the triangle's
 * place, on mirroring, or on a permutation of the axes. The exception is a triangle whose edges all
 * have equal extents up to such a permutation. */
int pen_triangle_first_corner(const struct pen_vec3 v[3])
{
    struct pen_vec3 edge[3], permuted[3];
    double most[3];
    for (int i = 0; i < 3; i++) {
        edge[i] = edge_extents(v[(i + 1) % 3], v[(i + 2) % 3]);
        most[i] = pen_largest3(edge[i]);
    }
    for (int i = 0; i < 3; i++) /* nearly always the largest extent decides */
        if (most[i] > most[(i + 1) % 3] && most[i] > most[(i + 2) % 3])
            return i;
    for (int i = 0; i < 3; i++)
        permuted[i] = sorted(edge[i]);
    int first = distinguished_by(permuted);
    if (first < 0)
        first = distinguished_by(edge);
    return first < 0 ? 0 : first; /* three equal points */
}

/* Makes a triangle. `otherwise` is the normal if the vertices are on one line; zero: such a
 * triangle is refused. */
static bool make_with(struct pen_triangle *tri, const struct pen_vec3 v[3],
                      struct pen_vec3 otherwise)
{
    if (!is_vertex(v[0]) || !is_vertex(v[1]) || !is_vertex(v[2]))
        return false;
    int first = pen_triangle_first_corner(v);
    *tri = (struct pen_triangle){.v = {v[first], v[(first + 1) % 3], v[(first + 2) % 3]}};
    struct dd3 normal;
    if (!pen_triangle_normal(tri->v, otherwise, &normal))
        return false;
    tri->facet = pen_facet_of(tri->v[0], normal);
    return true;
}

bool pen_triangle_make(struct pen_triangle *tri, struct pen_vec3 a, struct pen_vec3 b,
                       struct pen_vec3 c)
{
    const struct pen_vec3 v[3] = {a, b, c};
    return make_with(tri, v, pen_vec3(0, 0, 0));
}

void pen_triangle_make_thin(struct pen_triangle *tri, const struct pen_vec3 v[3])
{
    const struct pen_vec3 otherwise = pen_across_points(v, 3);
    if (pen_largest3(otherwise) > 0 && make_with(tri, v, otherwise))
        return;
    *tri = (struct pen_triangle){.v = {v[0], v[1], v[2]}};
    tri->facet = pen_facet_of(v[0], dd_of3(pen_vec3(0, 0, 1)));
}

/* The largest distance between two vertices along an axis. */
static double extent_of(const struct pen_triangle *tri)
{
    struct pen_box b = pen_box_of_points(tri->v, 3);
    return pen_largest3(pen_sub(b.hi, b.lo));
}

static bool make(void *self, const struct pen_prim_source *from)
{
    return from->count == 3 && make_with(self, from->vertices, from->direction);
}

static void intersect_line(const void *self, const struct pen_ray *ray,
                           struct pen_intersections *out)
{
    double t;
    if (pen_triangle_root(self, ray, &t))
        pen_intersections_add(out, t, PEN_PART_SIDE);
}

static struct pen_vec3 normal(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part, (void)p;
    return ((const struct pen_triangle *)self)->facet.n;
}

static struct pen_vec3 project(const void *self, uint8_t part, struct pen_vec3 p)
{
    (void)part;
    return pen_facet_project(&((const struct pen_triangle *)self)->facet, p);
}

static struct pen_box bounds(const void *self)
{
    return pen_outline_bounds(((const struct pen_triangle *)self)->v, 3, 0);
}

/* 0: the facet is exact. */
static double scale(const void *self, struct pen_vec3 p)
{
    (void)self, (void)p;
    return 0;
}

static double reach(const void *self, struct pen_vec3 n, struct pen_vec3 p)
{
    return pen_farthest(((const struct pen_triangle *)self)->v, 3, n, p);
}

static struct pen_outline outline(const void *self)
{
    return (struct pen_outline){((const struct pen_triangle *)self)->v, 3, extent_of(self)};
}

const struct pen_kind_functions pen_triangle_functions = {
    .make = make,
    .intersect_line = intersect_line,
    .normal = normal,
    .project = project,
    .bounds = bounds,
    .scale = scale,
    .reach = reach,
    .outline = outline,
};
