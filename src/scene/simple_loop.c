/* SPDX-License-Identifier: MIT */
/* The sweep-line test of Shamos & Hoey, "Geometric intersection problems", FOCS 1976. A vertical
 * line sweeps over the points from left to right. The edges that it cuts are kept sorted from
 * bottom to top. Two edges that intersect become neighbours in that order before the line reaches
 * the intersection. So each edge is tested only against new neighbours, and the first intersection
 * found ends the sweep. All decisions are signs of exact orientations; there is no tolerance.
 * Points are ordered by x, then by y. This is the order of a line tilted by an infinitesimal angle,
 * so vertical edges are no special case.
 *
 * The sorted edges are a treap (a binary tree ordered by position, a heap by priority) that is also
 * linked as a list. Priorities are a hash of the edge's number and of all points, so no input can
 * be constructed for which the tree is deep. */
#include "scene/internal/simple_loop.h"

#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

struct node {
    uint32_t parent, child[2]; /* child[0]: below */
    uint32_t near[2];          /* the next edge below, above */
    uint32_t priority;
};

struct sweep {
    const struct pen_point2 *points;
    uint32_t count;
    uint32_t root;
    struct node *node; /* by edge */
    struct pen_simple_loop_result *result;
};

static uint64_t mix(uint64_t h, uint64_t v)
{
    h = (h ^ v) * 0x9E3779B97F4A7C15u;
    return h ^ (h >> 29);
}

static uint64_t hash_points(const struct pen_point2 *points, uint32_t count)
{
    uint64_t h = count;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t bits[2];
        memcpy(bits, &points[i], sizeof bits);
        h = mix(mix(h, bits[0]), bits[1]);
    }
    return h;
}

static uint32_t next_of(const struct sweep *s, uint32_t i)
{
    return i + 1 == s->count ? 0 : i + 1;
}

/* The end of an edge that the sweep line reaches first (last = 0) or last (last = 1). */
static uint32_t edge_end(const struct sweep *s, uint32_t e, int last)
{
    uint32_t a = e, b = next_of(s, e);
    bool forward = pen_point2_compare(s->points[a], s->points[b]) < 0;
    return forward == (last == 1) ? b : a;
}

static bool meet(struct sweep *s, uint32_t e, uint32_t f)
{
    s->result->simple = false;
    s->result->edge[0] = e < f ? e : f;
    s->result->edge[1] = e < f ? f : e;
    return true;
}

/* Whether two edges intersect or touch elsewhere than at a common end. */
static bool check_pair(struct sweep *s, uint32_t e, uint32_t f)
{
    if (e == NONE || f == NONE)
        return false;
    uint32_t e0 = edge_end(s, e, 0), e1 = edge_end(s, e, 1);
    uint32_t f0 = edge_end(s, f, 0), f1 = edge_end(s, f, 1);
    const struct pen_point2 *p = s->points;
    int of_f0 = pen_orient2d(p[e0], p[e1], p[f0]), of_f1 = pen_orient2d(p[e0], p[e1], p[f1]);
    if (of_f0 == 0 && of_f1 == 0) { /* on one line: do they overlap by more than a point? */
        uint32_t from = pen_point2_compare(p[e0], p[f0]) > 0 ? e0 : f0;
        uint32_t to = pen_point2_compare(p[e1], p[f1]) < 0 ? e1 : f1;
        int order = pen_point2_compare(p[from], p[to]);
        return (order < 0 || (order == 0 && from != to)) && meet(s, e, f);
    }
    if (e0 == f0 || e0 == f1 || e1 == f0 || e1 == f1)
        return false;
    int of_e0 = pen_orient2d(p[f0], p[f1], p[e0]), of_e1 = pen_orient2d(p[f0], p[f1], p[e1]);
    return of_f0 * of_f1 <= 0 && of_e0 * of_e1 <= 0 && meet(s, e, f);
}

static void link_child(struct sweep *s, uint32_t parent, uint32_t old, uint32_t child)
{
    if (parent == NONE)
        s->root = child;
    else
        s->node[parent].child[s->node[parent].child[1] == old] = child;
    if (child != NONE)
        s->node[child].parent = parent;
}

/* Rotates an edge above its parent in the treap. */
static void rotate(struct sweep *s, uint32_t e)
{
    uint32_t parent = s->node[e].parent;
    int side = s->node[parent].child[1] == e;
    uint32_t inner = s->node[e].child[!side];
    link_child(s, s->node[parent].parent, parent, e);
    s->node[parent].child[side] = inner;
    if (inner != NONE)
        s->node[inner].parent = parent;
    s->node[e].child[!side] = parent;
    s->node[parent].parent = e;
}

/* Links an edge between two neighbours of the list. */
static void thread_between(struct sweep *s, uint32_t below, uint32_t e, uint32_t above)
{
    s->node[e].near[0] = below;
    s->node[e].near[1] = above;
    if (below != NONE)
        s->node[below].near[1] = e;
    if (above != NONE)
        s->node[above].near[0] = e;
}

static void place(struct sweep *s, uint32_t e, uint32_t parent, int side)
{
    uint32_t below = NONE, above = NONE;
    if (parent != NONE) {
        below = side ? parent : s->node[parent].near[0];
        above = side ? s->node[parent].near[1] : parent;
        s->node[parent].child[side] = e;
    } else {
        s->root = e;
    }
    s->node[e].parent = parent;
    s->node[e].child[0] = s->node[e].child[1] = NONE;
    thread_between(s, below, e, above);
    while (s->node[e].parent != NONE && s->node[s->node[e].parent].priority < s->node[e].priority)
        rotate(s, e);
}

/* Adds an edge that begins at point v. Returns whether an intersection was found. */
static bool insert(struct sweep *s, uint32_t e, uint32_t v)
{
    const struct pen_point2 *p = s->points;
    uint32_t parent = NONE;
    int side = 0;
    for (uint32_t f = s->root; f != NONE; f = s->node[f].child[side]) {
        uint32_t f0 = edge_end(s, f, 0), f1 = edge_end(s, f, 1);
        int turn = f0 == v ? pen_orient2d(p[f0], p[f1], p[edge_end(s, e, 1)])
                           : pen_orient2d(p[f0], p[f1], p[v]);
        if (turn == 0)
            return meet(s, e, f);
        parent = f;
        side = turn > 0;
    }
    place(s, e, parent, side);
    return check_pair(s, e, s->node[e].near[0]) || check_pair(s, e, s->node[e].near[1]);
}

static bool erase(struct sweep *s, uint32_t e)
{
    struct node *n = &s->node[e];
    while (n->child[0] != NONE && n->child[1] != NONE) {
        uint32_t a = n->child[0], b = n->child[1];
        rotate(s, s->node[a].priority > s->node[b].priority ? a : b);
    }
    link_child(s, n->parent, e, n->child[0] != NONE ? n->child[0] : n->child[1]);
    uint32_t below = n->near[0], above = n->near[1];
    if (below != NONE)
        s->node[below].near[1] = above;
    if (above != NONE)
        s->node[above].near[0] = below;
    return check_pair(s, below, above);
}

/* Replaces the edge `old` by the edge e, which begins where `old` ends. */
static bool replace(struct sweep *s, uint32_t old, uint32_t e)
{
    uint32_t priority = s->node[old].priority;
    s->node[e] = s->node[old];
    s->node[e].priority = priority;
    link_child(s, s->node[e].parent, old, e);
    for (int side = 0; side < 2; side++)
        if (s->node[e].child[side] != NONE)
            s->node[s->node[e].child[side]].parent = e;
    thread_between(s, s->node[e].near[0], e, s->node[e].near[1]);
    return check_pair(s, e, s->node[e].near[0]) || check_pair(s, e, s->node[e].near[1]);
}

/* Handles one point: both of its edges begin, both end, or one ends and the other begins. */
static bool advance(struct sweep *s, uint32_t v)
{
    uint32_t edges[2] = {v == 0 ? s->count - 1 : v - 1, v};
    bool begins[2] = {edge_end(s, edges[0], 0) == v, edge_end(s, edges[1], 0) == v};
    if (begins[0] && begins[1])
        return insert(s, edges[0], v) || insert(s, edges[1], v);
    if (!begins[0] && !begins[1])
        return erase(s, edges[0]) || erase(s, edges[1]);
    return replace(s, edges[begins[0]], edges[begins[1]]);
}

bool pen_check_simple_loop(const struct pen_point2 *points, const uint32_t *order, uint32_t count,
                           struct pen_simple_loop_result *result)
{
    struct sweep s = {.points = points, .count = count, .root = NONE, .result = result};
    s.node = malloc(count * sizeof *s.node);
    if (!s.node)
        return false;
    uint64_t seed = hash_points(points, count);
    for (uint32_t i = 0; i < count; i++)
        s.node[i].priority = (uint32_t)(mix(seed, i) >> 32);
    result->simple = true;
    for (uint32_t i = 0; i < count; i++)
        if (advance(&s, order[i]))
            break;
    free(s.node);
    return true;
}
