/* SPDX-License-Identifier: MIT */
/* Faces of one material are joined where they share an edge, bit for bit in the local frame.
 *
 * An edge usually has two faces. If they have the same side of the surface outward, they run along
 * the edge in opposite directions. So of two faces that run in the same direction, one is turned.
 * Faces that are joined by such edges are a *patch*. A patch is closed if its edges are balanced:
 * along each, as many of its faces run in one direction as in the other. A closed patch is a solid.
 *
 * The other patches are joined to *groups* where three or more faces share an edge. Each group is a
 * solid; it is closed if its edges are balanced. Two faces with the same vertices are a wall inside
 * a solid, as between two boxes that stand on each other. They are a separate solid without volume,
 * and are ignored otherwise. A face without area, which the scene leaves out, still joins its
 * neighbours. It fills the seam between an edge and the parts of that edge on the other side.
 *
 * The volume of a closed solid is positive if its faces are outward. If it is negative, all are
 * turned. So the order of vertices in the document does not matter for a closed solid. */
#include "scene/internal/solid_faces.h"

#include <stdlib.h>

#include "math/scale.h"

/* A side of a face, without its direction: the lesser end first. */
struct edge {
    double end[6];
    uint32_t material;
    uint32_t face;
    int32_t along; /* 1: the face runs from the first end to the second; -1: back */
};

/* All edges, sorted, so that equal edges are neighbours. */
struct edges {
    struct edge *at;
    size_t count;
};

static int compare_ends(const double *a, const double *b, int count)
{
    for (int i = 0; i < count; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b)
{
    const struct edge *p = a, *q = b;
    if (p->material != q->material)
        return p->material < q->material ? -1 : 1;
    const int ends = compare_ends(p->end, q->end, 6);
    return ends != 0 ? ends : (p->face > q->face) - (p->face < q->face);
}

static struct edge edge_of(const struct solid_face *face, uint32_t number, struct pen_vec3 from,
                           struct pen_vec3 to)
{
    const double p[3] = {from.x, from.y, from.z}, q[3] = {to.x, to.y, to.z};
    const bool back = compare_ends(p, q, 3) > 0;
    const double *a = back ? q : p, *b = back ? p : q;
    return (struct edge){
        {a[0], a[1], a[2], b[0], b[1], b[2]}, face->material, number, back ? -1 : 1};
}

/* The vertices of a face from the least one on, towards the lesser of its neighbours. They are the
 * same for two faces with the same vertices in the same or in the reverse order. */
struct loop {
    struct pen_outline line;
    uint32_t first, step; /* step: 1, or count - 1 to go back */
    uint32_t material, face;
};

static int compare_points(struct pen_vec3 a, struct pen_vec3 b)
{
    const double p[3] = {a.x, a.y, a.z}, q[3] = {b.x, b.y, b.z};
    return compare_ends(p, q, 3);
}

static struct loop loop_of(const struct solid_face *face, uint32_t number)
{
    struct loop loop = {face->line, 0, 1, face->material, number};
    const uint32_t n = loop.line.count;
    for (uint32_t i = 1; i < n; i++)
        if (compare_points(loop.line.v[i], loop.line.v[loop.first]) < 0)
            loop.first = i;
    if (compare_points(loop.line.v[(loop.first + n - 1) % n], loop.line.v[(loop.first + 1) % n]) <
        0)
        loop.step = n - 1;
    return loop;
}

static int compare_loops(const void *a, const void *b)
{
    const struct loop *p = a, *q = b;
    if (p->material != q->material)
        return p->material < q->material ? -1 : 1;
    if (p->line.count != q->line.count)
        return p->line.count < q->line.count ? -1 : 1;
    const uint32_t n = p->line.count;
    for (uint32_t i = 0, j = p->first, k = q->first; i < n; i++) {
        const int order = compare_points(p->line.v[j], q->line.v[k]);
        if (order != 0)
            return order;
        j = (j + p->step) % n;
        k = (k + q->step) % n;
    }
    return 0;
}

/* Makes a solid of two faces with the same vertices: a ray that enters it by one leaves it by the
 * other. */
static void make_wall(struct solid_face *face, const struct loop *a, const struct loop *b)
{
    const uint32_t first = a->face < b->face ? a->face : b->face;
    face[a->face].wall = face[b->face].wall = true;
    face[a->face].solid = face[b->face].solid = first;
    face[a->face].closed = face[b->face].closed = true;
    face[a->face].turned = false;
    face[b->face].turned = a->step == b->step;
}

/* Finds pairs of faces with the same vertices. Of three, one remains. */
static bool find_walls(struct solid_face *face, uint32_t count)
{
    struct loop *loop = malloc((count + (size_t)1) * sizeof *loop);
    if (!loop)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        loop[i] = loop_of(&face[i], i);
        face[i].wall = false;
    }
    qsort(loop, count, sizeof *loop, compare_loops);
    for (uint32_t i = 0; i + 1 < count; i++)
        if (compare_loops(&loop[i], &loop[i + 1]) == 0) {
            make_wall(face, &loop[i], &loop[i + 1]);
            i++;
        }
    free(loop);
    return true;
}

static bool make_edges(const struct solid_face *face, uint32_t count, struct edges *edges)
{
    size_t total = 0;
    for (uint32_t i = 0; i < count; i++)
        total += face[i].line.count;
    edges->at = malloc((total + 1) * sizeof *edges->at);
    if (!edges->at)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_outline line = face[i].line;
        for (uint32_t k = 0; k < line.count && !face[i].wall; k++)
            edges->at[edges->count++] =
                edge_of(&face[i], i, line.v[k], line.v[k + 1 < line.count ? k + 1 : 0]);
    }
    qsort(edges->at, edges->count, sizeof *edges->at, compare_edges);
    return true;
}

/* Removes edges without length, and edges that a face without area runs along in both directions.
 * They bound nothing. */
static void remove_folds(struct edges *edges)
{
    size_t kept = 0;
    for (size_t i = 0; i < edges->count; i++) {
        const struct edge *e = &edges->at[i], *last = kept > 0 ? &edges->at[kept - 1] : NULL;
        if (compare_ends(e->end, e->end + 3, 3) == 0)
            continue;
        if (last && last->face == e->face && last->along != e->along &&
            compare_ends(last->end, e->end, 6) == 0)
            kept--;
        else
            edges->at[kept++] = *e;
    }
    edges->count = kept;
}

/* The first edge after the run of edges that equal edge i. */
static size_t run_end(const struct edges *edges, size_t i)
{
    const struct edge *first = &edges->at[i];
    size_t end = i + 1;
    while (end < edges->count && edges->at[end].material == first->material &&
           compare_ends(edges->at[end].end, first->end, 6) == 0)
        end++;
    return end;
}

/* The root of a face's patch; it becomes the face's parent. */
static uint32_t patch_of(struct solid_face *face, uint32_t i)
{
    uint32_t root = i;
    bool turned = false;
    while (face[root].patch_up != root) {
        turned ^= face[root].turned_up;
        root = face[root].patch_up;
    }
    while (face[i].patch_up != root && i != root) {
        const uint32_t up = face[i].patch_up;
        const bool here = face[i].turned_up;
        face[i].patch_up = root;
        face[i].turned_up = turned;
        turned ^= here;
        i = up;
    }
    return root;
}

static uint32_t group_of(struct solid_face *face, uint32_t i)
{
    while (face[i].group_up != i)
        i = face[i].group_up = face[face[i].group_up].group_up;
    return i;
}

/* Whether a face is turned against the root of its patch. */
static bool turned_in_patch(struct solid_face *face, uint32_t i)
{
    return patch_of(face, i) != i && face[i].turned_up;
}

/* Joins two faces of a patch. A patch that cannot have two sides is open. */
static void join_patch(struct solid_face *face, uint32_t a, uint32_t b, bool turned)
{
    const uint32_t p = patch_of(face, a), q = patch_of(face, b);
    const bool between = turned ^ turned_in_patch(face, a) ^ turned_in_patch(face, b);
    if (p == q) {
        face[p].open = face[p].open || between;
        return;
    }
    const uint32_t up = p < q ? p : q, down = p < q ? q : p;
    face[down].patch_up = up;
    face[down].turned_up = between;
    face[up].open = face[up].open || face[down].open;
}

static void join_patches(struct solid_face *face, const struct edges *edges)
{
    for (size_t i = 0, end; i < edges->count; i = end) {
        end = run_end(edges, i);
        if (end == i + 2)
            join_patch(face, edges->at[i].face, edges->at[i + 1].face,
                       edges->at[i].along == edges->at[i + 1].along);
    }
}

typedef uint32_t root_fn(struct solid_face *face, uint32_t i);

/* Marks as open the patches, or groups, whose edges in a run are not balanced. */
static void mark_open(struct solid_face *face, const struct edge *run, size_t count, root_fn *root)
{
    for (size_t i = 0; i < count; i++)
        face[root(face, run[i].face)].balance +=
            turned_in_patch(face, run[i].face) ? -run[i].along : run[i].along;
    for (size_t i = 0; i < count; i++) {
        struct solid_face *r = &face[root(face, run[i].face)];
        r->open = r->open || r->balance != 0;
    }
    for (size_t i = 0; i < count; i++)
        face[root(face, run[i].face)].balance = 0;
}

static void mark_all_open(struct solid_face *face, const struct edges *edges, root_fn *root)
{
    for (size_t i = 0, end; i < edges->count; i = end) {
        end = run_end(edges, i);
        mark_open(face, &edges->at[i], end - i, root);
    }
}

/* Joins the open patches that share an edge. */
static void join_groups(struct solid_face *face, uint32_t count, const struct edges *edges)
{
    for (uint32_t i = 0; i < count; i++) {
        if (!face[i].wall)
            face[i].closed = !face[patch_of(face, i)].open;
        face[i].group_up = patch_of(face, i);
    }
    for (size_t i = 0, end; i < edges->count; i = end) {
        uint32_t first = UINT32_MAX;
        end = run_end(edges, i);
        for (size_t k = i; k < end; k++) {
            if (face[edges->at[k].face].closed)
                continue;
            const uint32_t root = group_of(face, edges->at[k].face);
            if (first == UINT32_MAX)
                first = root;
            const uint32_t up = first < root ? first : root, down = first < root ? root : first;
            face[down].group_up = up;
            first = up;
        }
    }
    for (uint32_t i = 0; i < count; i++)
        if (!face[i].closed)
            face[i].open = false;
}

/* Six times the volume between a face and point o. */
static double volume_under(const struct solid_face *face, struct pen_vec3 o)
{
    const struct pen_outline line = face->line;
    double sum = 0;
    for (uint32_t i = 1; i + 1 < line.count; i++) {
        const struct pen_vec3 a = pen_sub(line.v[0], o), b = pen_sub(line.v[i], o),
                              c = pen_sub(line.v[i + 1], o);
        sum += pen_dot(a, pen_cross(b, c));
    }
    return face->turned ? -sum : sum;
}

/* Turns the closed solids outward. Faces of open solids keep the order of the document. */
static bool turn_outward(struct solid_face *face, uint32_t count)
{
    double *volume = calloc((size_t)count + 1, sizeof *volume);
    if (!volume)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        struct solid_face *f = &face[i];
        if (f->wall)
            continue;
        f->turned = f->closed && turned_in_patch(face, i);
        volume[f->solid] += volume_under(f, face[f->solid].line.v[0]);
    }
    for (uint32_t i = 0; i < count; i++)
        face[i].turned ^= !face[i].wall && face[i].closed && volume[face[i].solid] < 0;
    free(volume);
    return true;
}

bool pen_solid_faces_join(struct solid_face *face, uint32_t count)
{
    struct edges edges = {0};
    if (!find_walls(face, count) || !make_edges(face, count, &edges))
        return false;
    remove_folds(&edges);
    for (uint32_t i = 0; i < count; i++) {
        face[i].patch_up = i;
        face[i].turned_up = face[i].open = false;
        face[i].balance = 0;
    }
    join_patches(face, &edges);
    mark_all_open(face, &edges, patch_of);
    join_groups(face, count, &edges);
    mark_all_open(face, &edges, group_of);
    for (uint32_t i = 0; i < count; i++) {
        if (face[i].wall)
            continue;
        face[i].solid = group_of(face, i);
        face[i].closed = !face[face[i].solid].open;
    }
    free(edges.at);
    return turn_outward(face, count);
}
