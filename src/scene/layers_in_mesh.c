/* SPDX-License-Identifier: MIT */
#include "scene/internal/layers_in_mesh.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum {
    BOXES = 16, /* boxes that are compared one by one; further ones share the last */
    EQUAL = 16  /* a triangle is compared with this number of equal ones */
};

struct pen_layers_others {
    uint32_t count;
    struct {
        struct pen_box box;
        uint32_t mesh; /* the number of the mesh; UINT32_MAX: none */
    } at[BOXES];
};

static const uint32_t NO_MESH = UINT32_MAX;

static struct pen_box grown(struct pen_box box)
{
    const double size = pen_norm1(box.lo) + pen_norm1(box.hi);
    const double by = 0x1p-38 * (1 + (size < INFINITY ? size : 0));
    const struct pen_vec3 margin = pen_vec3(by, by, by);
    return (struct pen_box){pen_sub(box.lo, margin), pen_add(box.hi, margin)};
}

static void add(struct pen_layers_others *to, struct pen_box box, uint32_t mesh)
{
    if (to->count < BOXES) {
        to->at[to->count].box = grown(box);
        to->at[to->count++].mesh = mesh;
        return;
    }
    to->at[BOXES - 1].box = pen_box_union(to->at[BOXES - 1].box, grown(box));
    to->at[BOXES - 1].mesh = NO_MESH;
}

/* The place of a plane: along an axis, it is thin across it. */
static struct pen_box box_of_plane(const struct pen_plane *plane)
{
    struct pen_box box = {pen_vec3(-INFINITY, -INFINITY, -INFINITY),
                          pen_vec3(INFINITY, INFINITY, INFINITY)};
    if (plane->n.y == 0 && plane->n.z == 0)
        box.lo.x = box.hi.x = plane->q.x;
    if (plane->n.x == 0 && plane->n.z == 0)
        box.lo.y = box.hi.y = plane->q.y;
    if (plane->n.x == 0 && plane->n.y == 0)
        box.lo.z = box.hi.z = plane->q.z;
    return box;
}

struct pen_layers_others *pen_layers_others(const struct pen_prims *prims)
{
    struct pen_layers_others *to = calloc(1, sizeof *to);
    if (!to)
        return NULL;
    for (uint32_t m = 0; m < prims->mesh_count; m++)
        add(to, pen_mesh_box(&prims->mesh[m]), m);
    for (uint32_t i = 0, m = 0; prims->mesh_count && i < prims->count; i++) {
        if (m < prims->mesh_count && i == prims->mesh[m].first) {
            i += prims->mesh[m++].count - 1;
            continue;
        }
        const struct pen_prim_ref ref = pen_prim_ref(prims, i);
        const struct pen_box all = {pen_vec3(-INFINITY, -INFINITY, -INFINITY),
                                    pen_vec3(INFINITY, INFINITY, INFINITY)};
        add(to,
            ref.kind == PEN_PRIM_PLANE    ? box_of_plane(&prims->plane[ref.index])
            : pen_prim_infinite(ref.kind) ? all
                                          : pen_prim_bounds(prims, i),
            NO_MESH);
    }
    return to;
}

bool pen_mesh_comes_near(const struct pen_prims *prims, const struct pen_layers_others *others,
                         uint32_t m, uint32_t triangle)
{
    if (others->count == 1 && others->at[0].mesh == m)
        return false;
    const struct pen_box box = grown(pen_mesh_bounds(&prims->mesh[m], triangle));
    for (uint32_t i = 0; i < others->count; i++) {
        const struct pen_box *b = &others->at[i].box;
        if (others->at[i].mesh != m && box.lo.x <= b->hi.x && box.hi.x >= b->lo.x &&
            box.lo.y <= b->hi.y && box.hi.y >= b->lo.y && box.lo.z <= b->hi.z &&
            box.hi.z >= b->lo.z)
            return true;
    }
    return false;
}

/* A point's hash. -0 and 0 are equal. */
static uint64_t hash_point(const float *f)
{
    uint64_t hash = 0;
    for (int i = 0; i < 3; i++) {
        const float x = f[i] + 0.0f;
        uint32_t bits;
        memcpy(&bits, &x, sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return hash;
}

static bool equal_points(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Whether each point of one is a point of the other. */
static bool equal_triangles(const struct pen_mesh *mesh, uint32_t a, uint32_t b)
{
    for (int i = 0; i < 3; i++) {
        bool found[2] = {false, false};
        for (int k = 0; k < 3; k++) {
            found[0] |= equal_points(pen_mesh_float(mesh, a, i), pen_mesh_float(mesh, b, k));
            found[1] |= equal_points(pen_mesh_float(mesh, b, i), pen_mesh_float(mesh, a, k));
        }
        if (!found[0] || !found[1])
            return false;
    }
    return true;
}

/* A table of triangles by their hash, with open addressing. */
struct entry {
    uint32_t hash, triangle; /* UINT32_MAX: none */
};

struct table {
    const struct pen_mesh *mesh;
    struct entry *entry;
    size_t mask;
};

static size_t place_of(const struct table *table, uint64_t hash)
{
    return (size_t)(hash >> 20) & table->mask;
}

/* Adds a triangle, and gives its pairs with equal ones to fn. */
static void add_triangle(const struct table *table, uint32_t triangle, uint64_t hash,
                         void (*fn)(void *user, uint32_t a, uint32_t b), void *user)
{
    const struct pen_mesh *mesh = table->mesh;
    struct entry *at = &table->entry[place_of(table, hash)];
    const uint32_t own = (uint32_t)hash;
    for (int equal = 0; at->triangle != UINT32_MAX;) {
        if (at->hash == own && equal_triangles(mesh, triangle, at->triangle)) {
            fn(user, mesh->first + at->triangle, mesh->first + triangle);
            if (++equal == EQUAL)
                return;
        }
        at = at < table->entry + table->mask ? at + 1 : table->entry;
    }
    *at = (struct entry){own, triangle};
}

/* Hashes some triangles before it looks for their places, which a processor then reads together. */
static void add_all(const struct table *table, void (*fn)(void *user, uint32_t a, uint32_t b),
                    void *user)
{
    enum { SOME = 32 };
    uint64_t hash[SOME];
    for (uint32_t begin = 0; begin < table->mesh->count; begin += SOME) {
        const uint32_t left = table->mesh->count - begin, count = left < SOME ? left : SOME;
        for (uint32_t i = 0; i < count; i++) {
            hash[i] = 0;
            for (int k = 0; k < 3; k++)
                hash[i] += hash_point(pen_mesh_float(table->mesh, begin + i, k));
            __builtin_prefetch(&table->entry[place_of(table, hash[i])], 1);
        }
        for (uint32_t i = 0; i < count; i++)
            add_triangle(table, begin + i, hash[i], fn, user);
    }
}

bool pen_mesh_find_equal(const struct pen_mesh *mesh,
                         void (*fn)(void *user, uint32_t a, uint32_t b), void *user)
{
    size_t room = 16;
    while (room < mesh->count + (size_t)mesh->count / 2)
        room *= 2;
    const struct table table = {mesh, pen_memory_large(room * sizeof *table.entry), room - 1};
    if (!table.entry)
        return false;
    memset(table.entry, 0xff, room * sizeof *table.entry);
    add_all(&table, fn, user);
    free(table.entry);
    return true;
}
