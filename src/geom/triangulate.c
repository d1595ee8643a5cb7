/* SPDX-License-Identifier: MIT */
/* Triangulation by cutting ears: a triangle of three neighbours that contains no other vertex is
 * cut off, until three vertices are left. All orientations are exact. The ear with the best shape
 * is cut first, because corners off the plane tilt the plane of a narrow triangle most.
 * Source: Meisters, "Polygons have ears", American Mathematical Monthly 82(6), 1975. */
#include "geom/triangulate.h"

#include <stdlib.h>

#include "math/orient2d.h"

struct vertex {
    struct pen_point2 at; /* as seen */
    uint32_t prev, next;  /* in the remaining outline */
    int turn;             /* 1: it is convex; 0: straight; -1: reflex */
    double shape;         /* of its ear; negative if it has none */
};

struct cutter {
    const struct pen_vec3 *v;
    struct vertex *vertex;
    uint32_t left; /* vertices */
};

static bool is_same(struct pen_point2 a, struct pen_point2 b)
{
    return pen_point2_compare(a, b) == 0;
}

/* Whether q is in the triangle a, b, c, which runs counter-clockwise, or on its border. A vertex
 * that is seen at the place of a corner is not. */
static bool holds(struct pen_point2 a, struct pen_point2 b, struct pen_point2 c,
                  struct pen_point2 q)
{
    if ((q.x < a.x && q.x < b.x && q.x < c.x) || (q.x > a.x && q.x > b.x && q.x > c.x) ||
        (q.y < a.y && q.y < b.y && q.y < c.y) || (q.y > a.y && q.y > b.y && q.y > c.y))
        return false;
    return pen_orient2d(a, b, q) >= 0 && pen_orient2d(b, c, q) >= 0 && pen_orient2d(c, a, q) >= 0 &&
           !is_same(a, q) && !is_same(b, q) && !is_same(c, q);
}

static double square(struct pen_point2 a, struct pen_point2 b)
{
    double x = a.x - b.x, y = a.y - b.y;
    return x * x + y * y;
}

/* The height of a triangle over its longest edge. A mirrored triangle has the same bits. */
static double shape_of(struct pen_point2 a, struct pen_point2 b, struct pen_point2 c)
{
    double ab = square(a, b), bc = square(b, c), ca = square(c, a);
    double longest = ab > bc ? ab : bc;
    double area = fabs((a.x - b.x) * (c.y - b.y) - (a.y - b.y) * (c.x - b.x));
    return area / (longest > ca ? longest : ca);
}

/* Decides whether vertex i is the tip of an ear. If the triangle contains a vertex, it contains a
 * reflex or straight one. */
static void judge(struct cutter *k, uint32_t i)
{
    struct vertex *tip = &k->vertex[i];
    struct pen_point2 a = k->vertex[tip->prev].at, c = k->vertex[tip->next].at;
    tip->turn = pen_orient2d(a, tip->at, c);
    tip->shape = -1;
    if (tip->turn <= 0)
        return;
    for (uint32_t q = k->vertex[tip->next].next; q != tip->prev; q = k->vertex[q].next)
        if (k->vertex[q].turn <= 0 && holds(a, tip->at, c, k->vertex[q].at))
            return;
    tip->shape = shape_of(a, tip->at, c);
}

/* Whether ear a is cut before ear b. For ears of one shape, the order of their tips decides. */
static bool is_before(const struct cutter *k, uint32_t a, uint32_t b)
{
    double x = k->vertex[a].shape, y = k->vertex[b].shape;
    if (x != y)
        return x > y;
    struct pen_vec3 p = k->v[a], q = k->v[b];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
}

/* The best ear. An outline that meets itself may have none; then it is some vertex. */
static uint32_t best_ear(const struct cutter *k, uint32_t first)
{
    uint32_t best = first, i = first;
    for (uint32_t n = 1; n < k->left; n++) {
        i = k->vertex[i].next;
        if (is_before(k, i, best))
            best = i;
    }
    return best;
}

/* Sets the vertices as they are seen along n, Newell's normal. They are moved along n into the
 * plane across the axis in which n is longest, and mirrored if they run clockwise there. Seen along
 * the axis itself, three of them on a line would turn by their distances from the plane. */
static void flatten(struct cutter *k, uint32_t count, struct pen_vec3 n)
{
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    int drop = x >= y && x >= z ? 0
               : y >= z         ? 1
                                : 2,
        first = (drop + 1) % 3, second = 3 - drop - first;
    double along = pen_component(n, drop), side = along < 0 ? -1 : 1;
    double slope_x = pen_component(n, first) / along, slope_y = pen_component(n, second) / along;
    for (uint32_t i = 0; i < count; i++) {
        struct vertex *to = &k->vertex[i];
        double h = pen_component(k->v[i], drop);
        to->at = (struct pen_point2){side * (pen_component(k->v[i], first) - slope_x * h),
                                     pen_component(k->v[i], second) - slope_y * h};
        to->prev = i == 0 ? count - 1 : i - 1;
        to->next = i + 1 == count ? 0 : i + 1;
    }
}

static void cut(struct cutter *k, uint32_t tip, uint32_t corner[3])
{
    uint32_t a = k->vertex[tip].prev, c = k->vertex[tip].next;
    corner[0] = a;
    corner[1] = tip;
    corner[2] = c;
    k->vertex[a].next = c;
    k->vertex[c].prev = a;
    k->left--;
    judge(k, a);
    judge(k, c);
}

bool pen_triangulate(const struct pen_vec3 *v, uint32_t count, struct pen_vec3 n,
                     uint32_t (*corner)[3])
{
    struct cutter k = {v, malloc(count * sizeof *k.vertex), count};
    if (!k.vertex)
        return false;
    flatten(&k, count, n);
    for (uint32_t i = 0; i < count; i++) {
        const struct vertex *at = &k.vertex[i];
        k.vertex[i].turn = pen_orient2d(k.vertex[at->prev].at, at->at, k.vertex[at->next].at);
    }
    for (uint32_t i = 0; i < count; i++)
        judge(&k, i);
    uint32_t first = 0;
    for (uint32_t i = 0; i + 2 < count; i++) {
        uint32_t tip = best_ear(&k, first);
        first = k.vertex[tip].next;
        cut(&k, tip, corner[i]);
    }
    free(k.vertex);
    return true;
}
