/* SPDX-License-Identifier: MIT */
/* The corners (a vertex with its two neighbours) of all triangles and polygons are put into a k-d
 * tree. Each edge looks up the corners within its tolerance.
 * Source: Bentley, Comm. ACM 18(9), 1975.
 * Cost: O(n log n) for n edges, plus the visits of each edge, which may visit all corners if they
 * lie along one line. So visits are counted, up to a limit. */
#include "scene/tjunction.h"

#include <math.h>
#include <stdlib.h>

#include "math/box.h"
#include "math/exact.h"

/* A vertex nearer to an edge than this part of the edge's length counts as lying on it. */
static const double TOLERANCE = 1e-9;

struct corner {
    struct pen_vec3 p, before, after;     /* the vertex and its neighbours around the loop */
    uint32_t loop, index;                 /* `index` is the vertex's, in document order */
    uint32_t number;                      /* of the corner, over all loops, in document order */
    bool unshared_before, unshared_after; /* no other loop has the same edge to that neighbour */
};

/* An edge without its direction: the lesser end first. */
struct edge_key {
    double end[6];
    uint32_t number; /* of the corner that the edge starts at */
};

static const uint32_t NO_LOOP = UINT32_MAX;

struct search {
    uint32_t count, loops;
    struct corner *edges; /* in document order: an edge runs from p to `after` */
    struct corner *tree;  /* the same corners, as a k-d tree */
    struct edge_key *keys;
    /* By corner number: the first loop with an edge that contains the corner. */
    uint32_t *edge_owner;
    uint64_t steps; /* remaining visits of corners */
};

/* One edge whose corners are searched. */
struct probe {
    const struct corner *edge;
    struct pen_vec3 d; /* unit */
    double length, tolerance;
    uint32_t *edge_owner;
    uint64_t *steps;
};

static bool is_loop(const struct pen_object_desc *object)
{
    return !object->left_out &&
           (object->kind == PEN_OBJECT_TRIANGLE || object->kind == PEN_OBJECT_POLYGON);
}

static uint64_t count_corners(const struct pen_object_desc *objects, uint32_t count)
{
    uint64_t corners = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (objects[i].kind == PEN_OBJECT_GROUP)
            corners += count_corners(objects[i].u.group.objects, objects[i].u.group.count);
        else if (is_loop(&objects[i]))
            corners += objects[i].u.polygon.count;
    }
    return corners;
}

static void add_loop(struct search *s, const struct pen_object_desc *object,
                     const struct pen_transform *f)
{
    uint32_t n = object->u.polygon.count;
    struct corner *first = s->edges + s->count;
    for (uint32_t i = 0; i < n; i++)
        first[i].p = pen_transform_point(f, object->u.polygon.vertices[i]);
    for (uint32_t i = 0; i < n; i++) {
        first[i].before = first[(i + n - 1) % n].p;
        first[i].after = first[(i + 1) % n].p;
        first[i].loop = s->loops;
        first[i].index = i;
        first[i].number = s->count + i;
    }
    s->count += n;
    s->loops++;
}

static void add_objects(struct search *s, const struct pen_object_desc *objects, uint32_t count,
                        const struct pen_transform *f)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *object = &objects[i];
        if (object->kind == PEN_OBJECT_GROUP) {
            struct pen_transform inner = *f;
            if (object->u.group.has_transform)
                inner = pen_transform_compose(f, &object->u.group.transform);
            add_objects(s, object->u.group.objects, object->u.group.count, &inner);
        } else if (is_loop(object)) {
            add_loop(s, object, f);
        }
    }
}

static int compare_ends(const double *a, const double *b, int count)
{
    for (int i = 0; i < count; i++) {
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    }
    return 0;
}

static int compare_keys(const void *a, const void *b)
{
    return compare_ends(((const struct edge_key *)a)->end, ((const struct edge_key *)b)->end, 6);
}

static struct edge_key edge_key(const struct corner *c)
{
    double p[3] = {c->p.x, c->p.y, c->p.z}, q[3] = {c->after.x, c->after.y, c->after.z};
    const double *a = compare_ends(p, q, 3) < 0 ? p : q, *b = a == p ? q : p;
    return (struct edge_key){{a[0], a[1], a[2], b[0], b[1], b[2]}, c->number};
}

/* Marks the edges that no other loop shares. A loop's corners are neighbours in `edges`, and the
 * edge before its first corner is the edge after its last. */
static void find_unshared_edges(struct search *s)
{
    for (uint32_t i = 0; i < s->count; i++)
        s->keys[i] = edge_key(&s->edges[i]);
    qsort(s->keys, s->count, sizeof *s->keys, compare_keys);
    for (uint32_t i = 0; i < s->count; i++) {
        bool as_before = i > 0 && compare_keys(&s->keys[i - 1], &s->keys[i]) == 0;
        bool as_after = i + 1 < s->count && compare_keys(&s->keys[i], &s->keys[i + 1]) == 0;
        s->edges[s->keys[i].number].unshared_after = !as_before && !as_after;
    }
    for (uint32_t i = 0, last; i < s->count; i = last + 1) {
        for (last = i; last + 1 < s->count && s->edges[last + 1].loop == s->edges[i].loop;)
            last++;
        for (uint32_t k = i; k <= last; k++)
            s->edges[k].unshared_before = s->edges[k > i ? k - 1 : last].unshared_after;
    }
}

/* For equal coordinates the corners' numbers decide. So the tree, and the number of visits, do not
 * depend on the algorithm of qsort. */
static int compare_along(const void *a, const void *b, int axis)
{
    const struct corner *p = a, *q = b;
    const double x = pen_component(p->p, axis), y = pen_component(q->p, axis);
    if (x != y)
        return x < y ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

static int compare_x(const void *a, const void *b)
{
    return compare_along(a, b, 0);
}

static int compare_y(const void *a, const void *b)
{
    return compare_along(a, b, 1);
}

static int compare_z(const void *a, const void *b)
{
    return compare_along(a, b, 2);
}

/* Orders the array as a k-d tree: the middle element splits it along x, y and z alternately. */
static void build_tree(struct corner *corners, uint32_t count, int axis)
{
    static int (*const compare[])(const void *, const void *) = {compare_x, compare_y, compare_z};
    if (count < 2)
        return;
    qsort(corners, count, sizeof *corners, compare[axis]);
    uint32_t middle = count / 2;
    build_tree(corners, middle, (axis + 1) % 3);
    build_tree(corners + middle + 1, count - middle - 1, (axis + 1) % 3);
}

/* Whether p is on the edge's line without any rounding. */
static bool is_exactly_on_line(const struct probe *probe, struct pen_vec3 p)
{
    struct pen_vec3 a = probe->edge->p;
    struct pen_vec3 c = pen_cross(pen_sub(p, a), pen_sub(probe->edge->after, a));
    return c.x == 0 && c.y == 0 && c.z == 0;
}

/* The distance of a point from the edge's line; *along is the position of its foot on the line. */
static double distance_from_line(const struct probe *probe, struct pen_vec3 p, double *along)
{
    struct pen_vec3 w = pen_sub(p, probe->edge->p);
    *along = pen_dot(w, probe->d);
    return pen_length(pen_cross(w, probe->d));
}

/* Whether the edge from the corner to this neighbour runs along the line. */
static bool runs_along(const struct probe *probe, struct pen_vec3 neighbour, double from)
{
    double along, off = distance_from_line(probe, neighbour, &along);
    double reach = fabs(along - from);
    return reach > probe->tolerance && off <= TOLERANCE * (probe->length + reach);
}

static void test_corner(const struct probe *probe, const struct corner *corner)
{
    double along;
    if (corner->loop == probe->edge->loop || probe->edge_owner[corner->number] != NO_LOOP)
        return;
    if (distance_from_line(probe, corner->p, &along) > probe->tolerance)
        return;
    if (along <= probe->tolerance || along >= probe->length - probe->tolerance ||
        is_exactly_on_line(probe, corner->p))
        return;
    if ((corner->unshared_before && runs_along(probe, corner->before, along)) ||
        (corner->unshared_after && runs_along(probe, corner->after, along)))
        probe->edge_owner[corner->number] = probe->edge->loop;
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double most(double a, double b)
{
    return a > b ? a : b;
}

/* Tests the corners of one subtree against the part of the edge between lo and hi, in units of
 * length. Recursion depth: log2 of the count. */
static void search_tree(const struct probe *probe, const struct corner *tree, uint32_t count,
                        int axis, double lo, double hi)
{
    if (count == 0 || lo > hi || *probe->steps == 0)
        return;
    --*probe->steps;
    uint32_t middle = count / 2;
    double start = pen_component(probe->edge->p, axis), step = pen_component(probe->d, axis);
    double split = pen_component(tree[middle].p, axis);
    /* The edge is at split -+ tolerance there. If it is parallel to the plane, all of it is on one
     * side. */
    double below = split + probe->tolerance - start, above = split - probe->tolerance - start;
    double left_lo = lo, left_hi = hi, right_lo = lo, right_hi = hi;
    if (step > 0) {
        left_hi = least(hi, below / step);
        right_lo = most(lo, above / step);
    } else if (step < 0) {
        left_lo = most(lo, below / step);
        right_hi = least(hi, above / step);
    } else {
        left_hi = below >= 0 ? hi : lo - 1;
        right_hi = above <= 0 ? hi : lo - 1;
    }
    test_corner(probe, &tree[middle]);
    search_tree(probe, tree, middle, (axis + 1) % 3, left_lo, left_hi);
    search_tree(probe, tree + middle + 1, count - middle - 1, (axis + 1) % 3, right_lo, right_hi);
}

static void search_edge(struct search *s, const struct corner *edge)
{
    struct pen_vec3 d = pen_sub(edge->after, edge->p);
    double length = pen_length(d);
    if (!(length > 0 && isfinite(length)))
        return;
    struct probe probe = {
        edge, pen_scale(d, 1 / length), length, TOLERANCE * length, s->edge_owner, &s->steps};
    search_tree(&probe, s->tree, s->count, 0, -probe.tolerance, length + probe.tolerance);
}

static void search(struct search *s, const struct pen_scene_desc *desc, pen_tjunction_fn *found,
                   void *user)
{
    struct pen_transform identity = pen_transform_identity();
    add_objects(s, desc->objects, desc->object_count, &identity);
    find_unshared_edges(s);
    for (uint32_t i = 0; i < s->count; i++) {
        s->tree[i] = s->edges[i];
        s->edge_owner[i] = NO_LOOP;
    }
    build_tree(s->tree, s->count, 0);
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->edges[i].unshared_after)
            search_edge(s, &s->edges[i]);
    }
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->edge_owner[i] != NO_LOOP)
            found(user, &(struct pen_tjunction){.loop = s->edges[i].loop,
                                                .vertex = s->edges[i].index,
                                                .edge_loop = s->edge_owner[i]});
    }
}

bool pen_tjunctions_find(const struct pen_scene_desc *desc, uint64_t steps_max,
                         pen_tjunction_fn *found, void *user)
{
    uint64_t corners = count_corners(desc->objects, desc->object_count);
    if (corners == 0 || corners > PEN_TJUNCTION_EDGES_MAX)
        return corners == 0;
    struct search s = {.steps = steps_max};
    s.edges = calloc(corners, sizeof *s.edges);
    s.tree = calloc(corners, sizeof *s.tree);
    s.edge_owner = calloc(corners, sizeof *s.edge_owner);
    s.keys = calloc(corners, sizeof *s.keys);
    const bool ok = s.edges && s.tree && s.edge_owner && s.keys;
    if (ok)
        search(&s, desc, found, user);
    free(s.edges);
    free(s.tree);
    free(s.edge_owner);
    free(s.keys);
    return ok && s.steps > 0;
}
