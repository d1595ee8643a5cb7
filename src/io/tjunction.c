/* SPDX-License-Identifier: MIT */
/* T-junctions: two flat bodies run along one line, and a vertex of the one lies inside an edge of
 * the other. The edge and the pieces beside it are then rounded apart, and a ray may pass between
 * them. None is: a vertex that merely touches an edge (the foot of a post); an edge that two
 * bodies share end to end, as those of a box, which is closed whatever stands beside it; a vertex
 * that is on the line to the last bit, as among bodies parallel to the axes.
 *
 * Vertices are put into a k-d tree (Bentley, Comm. ACM 18(9), 1975); each edge looks up those
 * within its tolerance. Cost: O(n log n) for n edges, and what each edge finds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "io/scene/reader.h"
#include "io/scene/warnings.h"
#include "math/box.h"
#include "math/exact.h"

/* How far from an edge a vertex may be and still be meant to lie on it, in parts of its length. */
static const double TOLERANCE = 1e-9;

struct corner {
    struct pen_vec3 p, before, after; /* and its neighbours around the loop */
    uint32_t loop, index;             /* of the vertex, in the document's order */
    uint32_t number;                  /* of the corner, in the document's order */
    bool open_before, open_after;     /* the edges to the neighbours belong to this loop alone */
};

/* An edge whichever way it runs. */
struct edge_key {
    double end[6];
    uint32_t number; /* of the corner that it runs from */
};

static const uint32_t NO_LOOP = UINT32_MAX;

struct search {
    uint32_t count, loops;
    struct corner *edges; /* in the document's order: an edge runs from p to `after` */
    struct corner *tree;  /* the same, as a tree */
    struct edge_key *keys;
    uint32_t *meets; /* by corner number: the first loop with an edge that it lies inside */
};

/* One edge, looking for corners. */
struct probe {
    const struct corner *edge;
    struct pen_vec3 d; /* unit */
    double length, tolerance;
    uint32_t *meets;
};

static bool is_loop(const struct pen_object_desc *object)
{
    return object->kind == PEN_OBJECT_TRIANGLE || object->kind == PEN_OBJECT_POLYGON;
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

/* Finds the edges that no other loop shares. A loop's corners are neighbours in `edges`, and its
 * first corner's edge before it is the last one's after it. */
static void find_open(struct search *s)
{
    for (uint32_t i = 0; i < s->count; i++)
        s->keys[i] = edge_key(&s->edges[i]);
    qsort(s->keys, s->count, sizeof *s->keys, compare_keys);
    for (uint32_t i = 0; i < s->count; i++) {
        bool as_before = i > 0 && compare_keys(&s->keys[i - 1], &s->keys[i]) == 0;
        bool as_after = i + 1 < s->count && compare_keys(&s->keys[i], &s->keys[i + 1]) == 0;
        s->edges[s->keys[i].number].open_after = !as_before && !as_after;
    }
    for (uint32_t i = 0, last; i < s->count; i = last + 1) {
        for (last = i; last + 1 < s->count && s->edges[last + 1].loop == s->edges[i].loop;)
            last++;
        for (uint32_t k = i; k <= last; k++)
            s->edges[k].open_before = s->edges[k > i ? k - 1 : last].open_after;
    }
}

static int compare_x(const void *a, const void *b)
{
    double x = ((const struct corner *)a)->p.x, y = ((const struct corner *)b)->p.x;
    return (x > y) - (x < y);
}

static int compare_y(const void *a, const void *b)
{
    double x = ((const struct corner *)a)->p.y, y = ((const struct corner *)b)->p.y;
    return (x > y) - (x < y);
}

static int compare_z(const void *a, const void *b)
{
    double x = ((const struct corner *)a)->p.z, y = ((const struct corner *)b)->p.z;
    return (x > y) - (x < y);
}

/* The tree is the array itself: the middle splits it along x, y, z in turn. */
static void build(struct corner *corners, uint32_t count, int axis)
{
    static int (*const compare[])(const void *, const void *) = {compare_x, compare_y, compare_z};
    if (count < 2)
        return;
    qsort(corners, count, sizeof *corners, compare[axis]);
    uint32_t middle = count / 2;
    build(corners, middle, (axis + 1) % 3);
    build(corners + middle + 1, count - middle - 1, (axis + 1) % 3);
}

/* Whether the corner is on the edge's line to the last bit. */
static bool is_exact(const struct probe *probe, struct pen_vec3 p)
{
    struct pen_vec3 a = probe->edge->p;
    struct pen_vec3 c = pen_cross(pen_sub(p, a), pen_sub(probe->edge->after, a));
    return c.x == 0 && c.y == 0 && c.z == 0;
}

/* How far a point is from the edge's line; `along` is where on it, in units of length. */
static double from_line(const struct probe *probe, struct pen_vec3 p, double *along)
{
    struct pen_vec3 w = pen_sub(p, probe->edge->p);
    *along = pen_dot(w, probe->d);
    return pen_length(pen_cross(w, probe->d));
}

/* Whether the corner's neighbour continues along the line. */
static bool runs_along(const struct probe *probe, struct pen_vec3 neighbour, double from)
{
    double along, off = from_line(probe, neighbour, &along);
    double reach = fabs(along - from);
    return reach > probe->tolerance && off <= TOLERANCE * (probe->length + reach);
}

static void visit(const struct probe *probe, const struct corner *corner)
{
    double along;
    if (corner->loop == probe->edge->loop || probe->meets[corner->number] != NO_LOOP)
        return;
    if (from_line(probe, corner->p, &along) > probe->tolerance)
        return;
    if (along <= probe->tolerance || along >= probe->length - probe->tolerance ||
        is_exact(probe, corner->p))
        return;
    if ((corner->open_before && runs_along(probe, corner->before, along)) ||
        (corner->open_after && runs_along(probe, corner->after, along)))
        probe->meets[corner->number] = probe->edge->loop;
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double most(double a, double b)
{
    return a > b ? a : b;
}

/* Looks at the part of the edge between lo and hi, in units of length, and the corners of one
 * subtree. Depth: log2 of the count. */
static void look_up(const struct probe *probe, const struct corner *tree, uint32_t count, int axis,
                    double lo, double hi)
{
    if (count == 0 || lo > hi)
        return;
    uint32_t middle = count / 2;
    double start = pen_component(probe->edge->p, axis), step = pen_component(probe->d, axis);
    double split = pen_component(tree[middle].p, axis);
    /* The edge is at split -+ tolerance there; parallel to the plane, all of it is on one side. */
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
    visit(probe, &tree[middle]);
    look_up(probe, tree, middle, (axis + 1) % 3, left_lo, left_hi);
    look_up(probe, tree + middle + 1, count - middle - 1, (axis + 1) % 3, right_lo, right_hi);
}

static void probe_edge(struct search *s, const struct corner *edge)
{
    struct pen_vec3 d = pen_sub(edge->after, edge->p);
    double length = pen_length(d);
    if (!(length > 0 && isfinite(length)))
        return;
    struct probe probe = {edge, pen_scale(d, 1 / length), length, TOLERANCE * length, s->meets};
    look_up(&probe, s->tree, s->count, 0, -probe.tolerance, length + probe.tolerance);
}

/* Writes the pointer to the loop of that number; counts *left down to it. */
static bool find_loop(const struct pen_object_desc *objects, uint32_t count,
                      const struct pen_place *up, uint32_t *left, char out[PEN_AT_BYTES])
{
    struct pen_place at = pen_place_key(up, "objects");
    for (uint32_t i = 0; i < count; i++) {
        struct pen_place place = pen_place_index(&at, i);
        const struct pen_object_desc *object = &objects[i];
        if (object->kind == PEN_OBJECT_GROUP) {
            if (find_loop(object->u.group.objects, object->u.group.count, &place, left, out))
                return true;
        } else if (is_loop(object) && (*left)-- == 0) {
            pen_place_text(&place, "", out, PEN_AT_BYTES);
            return true;
        }
    }
    return false;
}

static void warn(const struct pen_scene_desc *desc, const char *at, const struct corner *corner,
                 uint32_t other, struct pen_errors *warnings)
{
    const struct pen_place root = {0};
    char mine[PEN_AT_BYTES], theirs[PEN_AT_BYTES], pointer[3 * PEN_AT_BYTES];
    struct pen_status st = {.code = PEN_OK};
    uint32_t loop = corner->loop;
    if (warnings->count < PEN_ERRORS_MAX &&
        find_loop(desc->objects, desc->object_count, &root, &loop, mine) &&
        find_loop(desc->objects, desc->object_count, &root, &other, theirs)) {
        snprintf(pointer, sizeof pointer, "%.255s%s/vertices/%u", at, mine, corner->index);
        pen_fail_at(&st, PEN_OK, pointer,
                    "this vertex lies inside an edge of %.255s%s, along which both run: light may "
                    "leak between them unless the edge has a vertex there too",
                    at, theirs);
    }
    pen_errors_add(warnings, &st);
}

static void search(struct search *s, const struct pen_scene_desc *desc, const char *at,
                   struct pen_errors *warnings)
{
    struct pen_transform identity = pen_transform_identity();
    add_objects(s, desc->objects, desc->object_count, &identity);
    find_open(s);
    for (uint32_t i = 0; i < s->count; i++) {
        s->tree[i] = s->edges[i];
        s->meets[i] = NO_LOOP;
    }
    build(s->tree, s->count, 0);
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->edges[i].open_after)
            probe_edge(s, &s->edges[i]);
    }
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->meets[i] != NO_LOOP)
            warn(desc, at, &s->edges[i], s->meets[i], warnings);
    }
}

void pen_tjunction_warnings(const struct pen_scene_desc *desc, const char *at,
                            struct pen_errors *warnings)
{
    uint64_t corners = count_corners(desc->objects, desc->object_count);
    if (corners == 0 || corners > PEN_TJUNCTION_EDGES_MAX)
        return;
    struct search s = {0};
    s.edges = calloc(corners, sizeof *s.edges);
    s.tree = calloc(corners, sizeof *s.tree);
    s.meets = calloc(corners, sizeof *s.meets);
    s.keys = calloc(corners, sizeof *s.keys);
    if (s.edges && s.tree && s.meets && s.keys) /* without the memory there are no such notes */
        search(&s, desc, at, warnings);
    free(s.edges);
    free(s.tree);
    free(s.meets);
    free(s.keys);
}
