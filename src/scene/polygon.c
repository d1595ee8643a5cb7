/* SPDX-License-Identifier: MIT */
/* Whether a loop of vertices is a valid polygon:
 *  1. no two vertices are equal;
 *  2. the area is not zero;
 *  3. all vertices are in one plane, within PLANARITY;
 *  4. no two edges intersect or touch.
 * The plane is that of a large triangle: the first vertex, the vertex farthest from it, and the
 * vertex farthest from the line through these two. Unlike a normal summed over the edges, it also
 * exists for a loop that intersects itself. So such a loop is refused for rule 4 and not for rule
 * 2. Rule 4 is decided exactly, in the projection along the axis of the normal's longest component.
 */
#include <stdio.h>
#include <stdlib.h>

#include "math/box.h"
#include "math/exact.h"
#include "math/exact_sum.h"
#include "math/orient2d.h"
#include "math/scale.h"
#include "scene/desc.h"
#include "scene/internal/simple_loop.h"
#include "scene/internal/vec.h"

/* The largest distance of a vertex from the plane, relative to the polygon's extent. */
static const double PLANARITY = 1e-6;

struct keyed {
    struct pen_vec3 p;
    uint32_t vertex;
};

struct loop {
    uint32_t count;
    double extent;           /* the longest side of the bounding box of `points` */
    struct pen_vec3 *points; /* the vertices, scaled by a power of two to at most 1 */
    struct keyed *sorted;
    struct pen_point2 *flat;
    uint32_t *order;
};

static int compare_keyed(const void *a, const void *b)
{
    const struct keyed *k = a, *l = b;
    for (int axis = 0; axis < 3; axis++) {
        double x = pen_component(k->p, axis), y = pen_component(l->p, axis);
        if (x != y)
            return x < y ? -1 : 1;
    }
    return k->vertex < l->vertex ? -1 : 1;
}

/* Sorts the vertices. Refuses two with equal coordinates. */
static bool check_distinct(struct loop *loop, struct pen_status *st)
{
    struct keyed *s = loop->sorted;
    qsort(s, loop->count, sizeof *s, compare_keyed);
    for (uint32_t i = 1; i < loop->count; i++) {
        struct pen_vec3 a = s[i - 1].p, b = s[i].p;
        if (a.x != b.x || a.y != b.y || a.z != b.z)
            continue;
        char at[32];
        snprintf(at, sizeof at, "/vertices/%u", s[i].vertex);
        return pen_fail_at(st, PEN_INVALID, at, "repeats vertex %u", s[i - 1].vertex);
    }
    return true;
}

/* The vector from vertex 0 to vertex i, in units of about the extent. */
static struct pen_vec3 arm(const struct loop *loop, uint32_t i)
{
    int exponent = pen_exponent(loop->extent);
    return vec_scale2_down(pen_sub(loop->points[i], loop->points[0]), exponent);
}

/* The normal of a loop so narrow that the rounding of arms may hide its width. It is the sum over
 * the edges. If that is zero because the loop meets itself, it is the normal of the first triangle
 * that has one. Exact; zero if all vertices are on one line. */
static struct pen_vec3 narrow_normal(const struct loop *loop, uint32_t far)
{
    struct pen_vec3 normal = pen_exact_normal(loop->points, loop->count);
    for (uint32_t i = 1; i < loop->count && vec_max_abs(normal) == 0; i++) {
        const struct pen_vec3 v[3] = {loop->points[0], loop->points[far], loop->points[i]};
        normal = pen_exact_normal(v, 3);
    }
    return normal;
}

/* The normal of the largest triangle; zero if all vertices are on one line. */
static struct pen_vec3 largest_normal(const struct loop *loop)
{
    struct pen_vec3 base = {0, 0, 0}, normal = {0, 0, 0};
    uint32_t far = 0;
    for (uint32_t i = 1; i < loop->count; i++) {
        struct pen_vec3 a = arm(loop, i);
        if (vec_max_abs(a) > vec_max_abs(base)) {
            base = a;
            far = i;
        }
    }
    for (uint32_t i = 1; i < loop->count; i++) {
        struct pen_vec3 n = pen_cross(base, arm(loop, i));
        if (vec_max_abs(n) > vec_max_abs(normal))
            normal = n;
    }
    const double least = 0x1p-40 * vec_max_abs(base) * vec_max_abs(base);
    return vec_max_abs(normal) > least ? normal : narrow_normal(loop, far);
}

/* The normal of the first three vertices, in document order, that are not on one line. The error
 * message uses it, because a reader expects the first vertices to define the plane. */
static struct pen_vec3 first_normal(const struct loop *loop)
{
    for (uint32_t i = 2; i < loop->count; i++) {
        struct pen_vec3 n = pen_cross(arm(loop, 1), arm(loop, i));
        if (vec_max_abs(n) > 0)
            return vec_normalize(n);
    }
    return (struct pen_vec3){0, 0, 1};
}

/* The vertex farthest from the plane through vertex 0, and its distance. */
static uint32_t farthest(const struct loop *loop, struct pen_vec3 normal, double *distance)
{
    uint32_t worst = 0;
    *distance = 0;
    for (uint32_t i = 1; i < loop->count; i++) {
        double d = fabs(pen_dot(normal, pen_sub(loop->points[i], loop->points[0])));
        if (d > *distance) {
            *distance = d;
            worst = i;
        }
    }
    return worst;
}

static bool check_planar(const struct loop *loop, struct pen_vec3 normal, struct pen_status *st)
{
    double off, first_off, allowed = PLANARITY * loop->extent;
    uint32_t worst = farthest(loop, normal, &off);
    if (off <= allowed)
        return true;
    uint32_t vertex = farthest(loop, first_normal(loop), &first_off);
    if (first_off > allowed)
        worst = vertex;
    char at[32];
    snprintf(at, sizeof at, "/vertices/%u", worst);
    return pen_fail_at(st, PEN_INVALID, at,
                       "is not in the plane of the other vertices: off by %.3g of the polygon's "
                       "extent, allowed is %g",
                       (first_off > allowed ? first_off : off) / loop->extent, PLANARITY);
}

/* Scales one coordinate of the points by a power of two to at most 1, which does not change
 * orientations. */
static void shift_axis(double *first, uint32_t count)
{
    const uint32_t stride = sizeof(struct pen_point2) / sizeof(double);
    double largest = 0;
    for (uint32_t i = 0; i < count; i++)
        largest = pen_larger(largest, fabs(first[i * stride]));
    int exponent = pen_exponent(largest);
    for (uint32_t i = 0; i < count; i++)
        first[i * stride] = pen_scale2(first[i * stride], -exponent);
}

/* Projects the points to the plane, into loop->flat: drops the coordinate in which the normal is
 * longest. */
static void flatten(struct loop *loop, struct pen_vec3 normal)
{
    double x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    int drop = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    for (uint32_t i = 0; i < loop->count; i++) {
        struct pen_vec3 p = loop->points[i];
        loop->flat[i] = (struct pen_point2){drop == 0 ? p.y : p.x, drop == 2 ? p.y : p.z};
    }
    shift_axis(&loop->flat[0].x, loop->count);
    shift_axis(&loop->flat[0].y, loop->count);
}

/* Whether the projected loop turns to the same side at every vertex and goes around exactly once.
 * Then its edges reverse their direction along the x axis twice. */
static bool is_convex(const struct loop *loop)
{
    const struct pen_point2 *p = loop->flat;
    uint32_t n = loop->count, reversals = 0;
    struct pen_point2 a = p[n - 2], b = p[n - 1];
    int side = pen_orient2d(a, b, p[0]);
    for (uint32_t i = 0; i < n; i++) {
        int turn = pen_orient2d(a, b, p[i]);
        if (turn == 0 || turn != side)
            return false;
        reversals += (pen_point2_compare(a, b) < 0) != (pen_point2_compare(b, p[i]) < 0);
        a = b;
        b = p[i];
    }
    return reversals == 2;
}

/* Whether a loop satisfies all four rules because it is flat and convex, as most loops are.
 * Vertices of a convex loop are distinct, and its edges do not meet, so no sorting is needed. */
static bool is_surely_valid(struct loop *loop, struct pen_vec3 normal)
{
    double off;
    if (!(vec_max_abs(normal) > 0))
        return false;
    farthest(loop, vec_normalize(normal), &off);
    if (!(off <= PLANARITY * loop->extent))
        return false;
    flatten(loop, vec_normalize(normal));
    return is_convex(loop);
}

static bool check_simple(struct loop *loop, struct pen_vec3 normal, struct pen_status *st)
{
    flatten(loop, normal);
    for (uint32_t i = 0; i < loop->count; i++)
        loop->sorted[i] = (struct keyed){{loop->flat[i].x, loop->flat[i].y, 0}, i};
    if (!check_distinct(loop, st))
        return false;
    for (uint32_t i = 0; i < loop->count; i++)
        loop->order[i] = loop->sorted[i].vertex;
    struct pen_simple_loop_result result;
    if (!pen_check_simple_loop(loop->flat, loop->order, loop->count, &result))
        return pen_fail(st, PEN_NO_MEMORY, "out of memory while checking a polygon");
    if (result.simple)
        return true;
    char at[32];
    snprintf(at, sizeof at, "/vertices/%u", result.edge[1]);
    return pen_fail_at(st, PEN_INVALID, at,
                       "the polygon meets itself: the edge from vertex %u crosses or touches the "
                       "edge from vertex %u",
                       result.edge[1], result.edge[0]);
}

/* Copies the vertices, scaled to at most 1, so that no difference overflows. */
static void copy_vertices(struct loop *loop, const struct pen_vec3 *vertices)
{
    double largest = 0;
    for (uint32_t i = 0; i < loop->count; i++)
        largest = pen_larger(largest, vec_max_abs(vertices[i]));
    int exponent = pen_exponent(largest);
    struct pen_box box = pen_box_empty();
    for (uint32_t i = 0; i < loop->count; i++) {
        loop->points[i] = vec_scale2_down(vertices[i], exponent);
        loop->sorted[i] = (struct keyed){loop->points[i], i};
        box = pen_box_add_point(box, loop->points[i]);
    }
    loop->extent = vec_max_abs(pen_sub(box.hi, box.lo));
}

static bool check_loop(struct loop *loop, const struct pen_vec3 *vertices, struct pen_status *st)
{
    copy_vertices(loop, vertices);
    struct pen_vec3 normal = largest_normal(loop);
    if (is_surely_valid(loop, normal))
        return true;
    if (!check_distinct(loop, st))
        return false;
    if (!(vec_max_abs(normal) > 0))
        return pen_fail_at(st, PEN_INVALID, "/vertices", "are all on one line: the area is zero");
    normal = vec_normalize(normal);
    return check_planar(loop, normal, st) && check_simple(loop, normal, st);
}

bool pen_polygon_check(const struct pen_vec3 *vertices, uint32_t count, struct pen_status *st)
{
    if (count < 3)
        return pen_fail_at(st, PEN_INVALID, "/vertices", "has %u vertices, needs at least 3",
                           count);
    struct loop loop = {
        .count = count,
        .points = malloc(count * sizeof *loop.points),
        .sorted = malloc(count * sizeof *loop.sorted),
        .flat = malloc(count * sizeof *loop.flat),
        .order = malloc(count * sizeof *loop.order),
    };
    bool ok = false;
    if (!loop.points || !loop.sorted || !loop.flat || !loop.order)
        pen_fail(st, PEN_NO_MEMORY, "out of memory while checking a polygon");
    else
        ok = check_loop(&loop, vertices, st);
    free(loop.points);
    free(loop.sorted);
    free(loop.flat);
    free(loop.order);
    return ok;
}
