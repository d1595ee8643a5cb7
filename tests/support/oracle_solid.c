/* SPDX-License-Identifier: MIT */
/* The oracle's solids: which primitives enclose glass, and the index of refraction at a point. A
 * solid is a closed primitive, or all triangles and polygons of one material that are joined at
 * edges, if every edge of theirs is joined. */
#include <jansson.h>

#include "support/oracle.h"
#include "support/oracle_parts.h"

struct box {
    struct point low, high;
};

/* Extends a box by another one around a point. */
static void box_add(struct box *box, struct point middle, struct point half)
{
    struct point low = point_difference(middle, half), high = point_sum(middle, half);
    box->low = (struct point){fminl(box->low.x, low.x), fminl(box->low.y, low.y),
                              fminl(box->low.z, low.z)};
    box->high = (struct point){fmaxl(box->high.x, high.x), fmaxl(box->high.y, high.y),
                               fmaxl(box->high.z, high.z)};
}

static void box_add_body(struct box *box, const struct oracle_primitive *b)
{
    if (b->kind == ORACLE_SPHERE)
        box_add(box, b->origin, (struct point){b->radius, b->radius, b->radius});
    for (int i = 0; i < b->count; i++)
        box_add(box, b->corners[i], (struct point){0, 0, 0});
    if (b->kind != ORACLE_CYLINDER && b->kind != ORACLE_CONE)
        return;
    struct point a = b->axis;
    struct point disk = {hypotl(a.y, a.z), hypotl(a.z, a.x), hypotl(a.x, a.y)};
    struct point end = point_sum(b->origin, point_times(a, b->height));
    box_add(box, b->origin, point_times(disk, b->radius));
    box_add(box, end, point_times(disk, b->kind == ORACLE_CONE ? b->top : b->radius));
}

static bool may_bend(const struct oracle_primitive *b)
{
    bool capped = b->caps && (b->kind == ORACLE_CYLINDER || b->kind == ORACLE_CONE);
    bool closed = capped || b->kind == ORACLE_SPHERE;
    return b->material.ior_written && (closed || b->kind == ORACLE_RING);
}

static bool same_point(struct point a, struct point b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* Whether one of b's edges is the edge from c to d, in either direction. */
static bool has_edge(const struct oracle_primitive *b, struct point c, struct point d)
{
    for (int i = 0, j = b->count - 1; i < b->count; j = i++)
        if ((same_point(b->corners[i], c) && same_point(b->corners[j], d)) ||
            (same_point(b->corners[i], d) && same_point(b->corners[j], c)))
            return true;
    return false;
}

static bool share_edge(const struct oracle_primitive *a, const struct oracle_primitive *b)
{
    for (int i = 0, j = a->count - 1; i < a->count; j = i++)
        if (has_edge(b, a->corners[i], a->corners[j]))
            return true;
    return false;
}

/* Makes one solid of two. Each has the number of its first primitive, as has the result. */
static void solids_unite(struct oracle_scene *s, int one, int other)
{
    int first = one < other ? one : other;
    for (int i = 0; i < s->body_count; i++)
        if (s->primitives[i].solid == one || s->primitives[i].solid == other)
            s->primitives[i].solid = first;
}

static void solids_join(struct oracle_scene *s)
{
    for (int i = 0; i < s->body_count; i++)
        for (int j = 0; j < i; j++) {
            const struct oracle_primitive *a = &s->primitives[i], *b = &s->primitives[j];
            if (a->solid >= 0 && b->solid >= 0 && a->solid != b->solid && share_edge(a, b) &&
                json_equal(a->written, b->written))
                solids_unite(s, a->solid, b->solid);
        }
}

/* Whether another primitive of the same solid has this edge. */
static bool edge_joined(const struct oracle_scene *s, int prim, struct point c, struct point d)
{
    for (int i = 0; i < s->body_count; i++)
        if (i != prim && s->primitives[i].solid == s->primitives[prim].solid &&
            has_edge(&s->primitives[i], c, d))
            return true;
    return false;
}

static bool solid_closed(const struct oracle_scene *s, int solid)
{
    for (int i = solid; i < s->body_count; i++) {
        const struct oracle_primitive *b = &s->primitives[i];
        for (int k = 0, j = b->count - 1; k < b->count && b->solid == solid; j = k++)
            if (!edge_joined(s, i, b->corners[k], b->corners[j]))
                return false;
    }
    return true;
}

/* Sets what the first primitive of a solid says about it; one that is open is no solid. */
static void solid_finish(struct oracle_scene *s, int solid, struct box *around_all)
{
    struct oracle_primitive *first = &s->primitives[solid];
    bool closed = solid_closed(s, solid);
    for (int i = solid; i < s->body_count; i++) {
        struct oracle_primitive *b = &s->primitives[i];
        if (b->solid != solid)
            continue;
        first->solid_end = i + 1;
        if (closed)
            box_add_body(around_all, b);
        else
            b->solid = -1;
    }
}

/* A point is inside if a line from it, of any direction, leaves through an odd number of
 * surfaces. The components of this one have nothing in common with those of edges. */
static bool solid_holds(const struct oracle_scene *s, int solid, struct point p)
{
    const struct ray line = {p, point_unit((struct point){0.5377139L, 0.8338853L, -0.2588468L})};
    bool inside = false;
    for (int i = solid; i < s->primitives[solid].solid_end; i++) {
        real t[4];
        int n = s->primitives[i].solid == solid ? oracle_body_roots(&s->primitives[i], line, t) : 0;
        for (int k = 0; k < n; k++)
            if (t[k] > 0)
                inside = !inside;
    }
    return inside;
}

/* Whether the corners of a face run counter-clockwise from outside: 1, or -1; told at the middle of
 * a corner's triangle that is on the face. */
static int face_side(const struct oracle_scene *s, const struct oracle_primitive *face)
{
    const struct point out = point_times(face->axis, 1e3L * s->step);
    for (int i = 0, n = face->count; i < n; i++) {
        const struct point *c = face->corners;
        const struct point p =
            point_times(point_sum(point_sum(c[i], c[(i + 1) % n]), c[(i + 2) % n]), 1 / 3.0L);
        const bool front = solid_holds(s, face->solid, point_sum(p, out));
        if (front != solid_holds(s, face->solid, point_difference(p, out)))
            return front ? -1 : 1;
    }
    return 1;
}

/* Of the pyramid from a point to a face. */
static real pyramid(const struct oracle_primitive *face, struct point top)
{
    real sum = 0;
    const struct point a = point_difference(face->corners[0], top);
    for (int i = 1; i + 1 < face->count; i++)
        sum += point_dot(a, point_cross(point_difference(face->corners[i], top),
                                        point_difference(face->corners[i + 1], top)));
    return sum / 6;
}

static real solid_volume(const struct oracle_scene *s, int solid)
{
    const real pi = 3.14159265358979323846264338328L;
    const struct oracle_primitive *b = &s->primitives[solid];
    const real r = b->radius, top = b->kind == ORACLE_CONE ? b->top : r;
    real sum = 0;
    if (b->kind == ORACLE_SPHERE)
        return 4 * pi / 3 * r * r * r;
    if (b->kind != ORACLE_RING)
        return pi / 3 * b->height * (r * r + r * top + top * top);
    for (int i = solid; i < b->solid_end; i++)
        if (s->primitives[i].solid == solid)
            sum += face_side(s, &s->primitives[i]) * pyramid(&s->primitives[i], b->corners[0]);
    return fabsl(sum);
}

/* The step is more than the distance at which places count as the same, so that it passes all
 * surfaces of a boundary, and more than the rounding of coordinates. */
void oracle_solids_find(struct oracle_scene *s)
{
    struct box all = {{HUGE_VALL, HUGE_VALL, HUGE_VALL}, {-HUGE_VALL, -HUGE_VALL, -HUGE_VALL}};
    for (int i = 0; i < s->body_count; i++)
        s->primitives[i].solid = may_bend(&s->primitives[i]) ? i : -1;
    solids_join(s);
    for (int i = 0; i < s->body_count; i++)
        if (s->primitives[i].solid == i)
            solid_finish(s, i, &all);
    real size = all.low.x < all.high.x ? point_length(point_difference(all.high, all.low)) : 0;
    s->step = 2 * s->tie + 1e-12L * size;
    for (int i = 0; i < s->body_count; i++)
        if (s->primitives[i].solid == i)
            s->primitives[i].solid_volume = solid_volume(s, i);
}

/* Volumes that differ by rounding are equal, and then the later solid counts. */
real oracle_index_at(const struct oracle_scene *s, struct point p)
{
    real index = 1, least = HUGE_VALL;
    for (int i = 0; i < s->body_count; i++) {
        const struct oracle_primitive *b = &s->primitives[i];
        if (b->solid == i && b->solid_volume <= least * (1 + 1e-12L) && solid_holds(s, i, p)) {
            least = b->solid_volume;
            index = b->material.ior;
        }
    }
    return index;
}
