/* SPDX-License-Identifier: MIT */
/* Tree layouts: the list of primitives that builders sort, their nodes and leaves, and costs. */
#include "accel/internal/tree_layout.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "accel/internal/rounding.h"
#include "base/memory.h"

const struct pen_child_box pen_child_box_empty = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, PEN_NO_CHILD};

void *pen_array_add(struct pen_array *array, uint32_t more)
{
    if (array->count > UINT32_MAX / 2 - more)
        return NULL;
    if (array->count + more > array->capacity) {
        uint32_t capacity = array->capacity * 2 > 64 ? array->capacity * 2 : 64;
        if (capacity < array->count + more)
            capacity = array->count + more;
        void *data = realloc(array->data, capacity * array->size);
        if (!data)
            return NULL;
        array->data = data;
        array->capacity = capacity;
    }
    void *place = (char *)array->data + array->count * array->size;
    array->count += more;
    return place;
}

void pen_array_release(struct pen_array *array)
{
    free(array->data);
    *array = (struct pen_array){.size = array->size};
}

/* The parts of a call of pen_parts_do. */
struct parts {
    void (*fn)(void *user, uint32_t part);
    void *user;
    uint32_t count;
    _Atomic uint32_t next; /* relaxed: parts do not depend on one another */
};

static void do_parts(void *user, int index)
{
    struct parts *parts = user;
    uint32_t part;
    (void)index;
    while ((part = atomic_fetch_add_explicit(&parts->next, 1, memory_order_relaxed)) < parts->count)
        parts->fn(parts->user, part);
}

void pen_parts_do(struct pen_thread_pool *pool, uint32_t parts,
                  void (*fn)(void *user, uint32_t part), void *user)
{
    struct parts all = {.fn = fn, .user = user, .count = parts};
    if (pool && parts > 1)
        pen_thread_pool_run(pool, pen_thread_pool_size(pool), do_parts, &all);
    else
        do_parts(&all, 0);
}

/* The kind of a primitive's block. A cut polygon is tested by the reference,
 * and so is a triangle of a mesh in all structures but the tree. */
static enum pen_block_kind block_kind(const struct pen_tree_layout *layout, uint32_t prim)
{
    uint32_t kind = pen_prim_kind(layout->prims, prim);
    if (pen_prim_cut(layout->prims, prim) || layout->generic_kinds >> kind & 1)
        return PEN_BLOCK_GENERIC;
    if (!pen_prim_mesh(layout->prims, prim))
        return pen_block_of(kind);
    return layout->frames ? PEN_BLOCK_MESH : PEN_BLOCK_GENERIC;
}

/* Sets the number of lanes as which a finite primitive counts, and their class. */
static void set_cost(struct pen_ref *ref, enum pen_block_kind block, uint32_t prim_kind)
{
    ref->lanes = 1;
    switch (block) {
    case PEN_BLOCK_TRIANGLES:
        ref->cost_class = PEN_COST_TRIANGLES;
        return;
    case PEN_BLOCK_MESH:
        ref->cost_class = PEN_COST_MESHES;
        return;
    case PEN_BLOCK_POLYGONS:
        ref->cost_class = PEN_COST_POLYGONS;
        return;
    case PEN_BLOCK_SPHERES:
        ref->cost_class = PEN_COST_SPHERES;
        return;
    case PEN_BLOCK_CYLINDERS:
        ref->cost_class = PEN_COST_CYLINDERS;
        return;
    case PEN_BLOCK_GENERIC:
    case PEN_BLOCK_PLANES:
    case PEN_BLOCK_INFINITE_CYLINDERS:
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break;
    }
    ref->cost_class = PEN_COST_TRIANGLES;
    ref->lanes = (uint8_t)(PEN_LANES * (int)ceilf(pen_kinds[prim_kind].cost));
}

/* A finite primitive. `block` is that of block_kind. */
static struct pen_ref finite_ref(uint32_t prim, uint32_t prim_kind, enum pen_block_kind block,
                                 struct pen_box box)
{
    struct pen_ref ref = {
        {pen_float_down(box.lo.x), pen_float_down(box.lo.y), pen_float_down(box.lo.z)},
        prim,
        {pen_float_up(box.hi.x), pen_float_up(box.hi.y), pen_float_up(box.hi.z)},
        (uint16_t)block,
        0,
        0};
    set_cost(&ref, block, prim_kind);
    return ref;
}

/* The triangles of a mesh, to be added to ref[]. */
struct adding {
    const struct pen_mesh *mesh;
    struct pen_ref *ref;
    enum pen_block_kind block;
};

enum { TRIANGLES_IN_PART = 1 << 13 };

static void add_part(void *user, uint32_t part)
{
    const struct adding *adding = user;
    const struct pen_mesh *mesh = adding->mesh;
    const uint32_t begin = part * TRIANGLES_IN_PART;
    for (uint32_t i = begin; i < mesh->count && i - begin < TRIANGLES_IN_PART; i++)
        adding->ref[i] =
            finite_ref(mesh->first + i, PEN_PRIM_TRIANGLE, adding->block, pen_mesh_bounds(mesh, i));
}

static void add_mesh(struct pen_tree_layout *layout, const struct pen_mesh *mesh)
{
    struct adding adding = {mesh, layout->ref + layout->count, block_kind(layout, mesh->first)};
    pen_parts_do(layout->pool, pen_parts_of(mesh->count, TRIANGLES_IN_PART), add_part, &adding);
    layout->count += mesh->count;
}

/* Adds the finite primitives, in document order. */
static void add_finite(struct pen_tree_layout *layout)
{
    const struct pen_prims *prims = layout->prims;
    for (uint32_t prim = 0, mesh = 0; prim < prims->count; prim++) {
        if (mesh < prims->mesh_count && prim == prims->mesh[mesh].first) {
            add_mesh(layout, &prims->mesh[mesh]);
            prim += prims->mesh[mesh++].count - 1;
            continue;
        }
        const uint32_t kind = pen_prim_kind(prims, prim);
        if (!pen_prim_infinite(kind))
            layout->ref[layout->count++] =
                finite_ref(prim, kind, block_kind(layout, prim), pen_prim_bounds(prims, prim));
    }
}

/* Adds the infinite primitives after the finite ones. */
static void add_infinite(struct pen_tree_layout *layout)
{
    const struct pen_prims *prims = layout->prims;
    for (uint32_t prim = 0, mesh = 0; prim < prims->count; prim++) {
        if (mesh < prims->mesh_count && prim == prims->mesh[mesh].first)
            prim += prims->mesh[mesh++].count - 1;
        else if (pen_prim_infinite(pen_prim_kind(prims, prim)))
            layout->ref[layout->count + layout->infinite++] =
                (struct pen_ref){.prim = prim, .kind = (uint16_t)block_kind(layout, prim)};
    }
}

bool pen_tree_layout_init(struct pen_tree_layout *layout)
{
    pen_tree_layout_begin(layout);
    layout->ref = pen_memory_large(((size_t)layout->prims->count + 1) * sizeof *layout->ref);
    if (!layout->ref)
        return false;
    add_finite(layout);
    add_infinite(layout);
    return true;
}

void pen_tree_layout_release(struct pen_tree_layout *layout)
{
    free(layout->ref);
    pen_array_release(&layout->nodes);
    pen_array_release(&layout->leaves);
}

uint32_t pen_tree_layout_add_leaf(struct pen_tree_layout *layout, uint32_t begin, uint32_t count)
{
    struct pen_leaf *leaf = pen_array_add(&layout->leaves, 1);
    if (!leaf)
        return PEN_NO_CHILD;
    *leaf = (struct pen_leaf){begin, count};
    return PEN_CHILD_LEAF | (layout->leaves.count - 1);
}

struct pen_node *pen_tree_layout_add_nodes(struct pen_tree_layout *layout, uint32_t count)
{
    struct pen_node *nodes = pen_array_add(&layout->nodes, count);
    if (!nodes)
        return NULL;
    for (uint32_t i = 0; i < count; i++) {
        for (int lane = 0; lane < PEN_WIDE; lane++)
            pen_node_put(&nodes[i], lane, &pen_child_box_empty);
    }
    return nodes;
}

struct pen_pair *pen_tree_layout_add_pair(struct pen_tree_layout *layout)
{
    struct pen_pair *pair = pen_array_add(&layout->nodes, 1);
    if (!pair)
        return NULL;
    pen_pair_put(pair, 0, &pen_child_box_empty);
    pen_pair_put(pair, 1, &pen_child_box_empty);
    return pair;
}

struct pen_child_box pen_ref_box(const struct pen_ref *ref)
{
    return (struct pen_child_box){
        {ref->lo[0], ref->lo[1], ref->lo[2]}, {ref->hi[0], ref->hi[1], ref->hi[2]}, PEN_NO_CHILD};
}

void pen_child_box_grow(struct pen_child_box *sum, const struct pen_child_box *in)
{
    for (int axis = 0; axis < 3; axis++) {
        sum->lo[axis] = in->lo[axis] < sum->lo[axis] ? in->lo[axis] : sum->lo[axis];
        sum->hi[axis] = in->hi[axis] > sum->hi[axis] ? in->hi[axis] : sum->hi[axis];
    }
}

void pen_node_put(struct pen_node *node, int lane, const struct pen_child_box *in)
{
    for (int axis = 0; axis < 3; axis++) {
        node->plane[axis][lane] = in->lo[axis];
        node->plane[3 + axis][lane] = in->hi[axis];
    }
    node->child[lane] = in->child;
}

void pen_pair_put(struct pen_pair *pair, int lane, const struct pen_child_box *in)
{
    for (int axis = 0; axis < 3; axis++) {
        pair->plane[axis][lane] = in->lo[axis];
        pair->plane[3 + axis][lane] = in->hi[axis];
    }
    pair->child[lane] = in->child;
}

int pen_tree_layout_width(const struct pen_tree_layout *layout)
{
    return layout->shape == PEN_SHAPE_PAIRS ? 2 : PEN_WIDE;
}

bool pen_tree_layout_child(const struct pen_tree_layout *layout, uint32_t node, int lane,
                           struct pen_child_box *out)
{
    const struct pen_node *nodes = layout->nodes.data;
    const struct pen_pair *pairs = layout->nodes.data;
    bool pair = layout->shape == PEN_SHAPE_PAIRS;
    for (int axis = 0; axis < 3; axis++) {
        out->lo[axis] = pair ? pairs[node].plane[axis][lane] : nodes[node].plane[axis][lane];
        out->hi[axis] =
            pair ? pairs[node].plane[axis + 3][lane] : nodes[node].plane[axis + 3][lane];
    }
    out->child = pair ? pairs[node].child[lane] : nodes[node].child[lane];
    if (out->child == PEN_NO_CHILD)
        return false;
    out->child &= ~PEN_CHILD_MORE;
    return true;
}

bool pen_tree_layout_list_continues(const struct pen_tree_layout *layout, uint32_t node)
{
    const struct pen_node *nodes = layout->nodes.data;
    return layout->shape == PEN_SHAPE_LISTS && nodes[node].child[0] & PEN_CHILD_MORE;
}

const float pen_node_cost = 0.3f;

float pen_leaf_cost(const uint32_t lanes[PEN_COST_CLASS_COUNT])
{
    const float cost[PEN_COST_MESHES] = {
        [PEN_COST_TRIANGLES] = pen_kinds[PEN_PRIM_TRIANGLE].cost,
        [PEN_COST_POLYGONS] = pen_kinds[PEN_PRIM_POLYGON].cost,
        [PEN_COST_SPHERES] = pen_kinds[PEN_PRIM_SPHERE].cost,
        [PEN_COST_CYLINDERS] = pen_kinds[PEN_PRIM_CYLINDER].cost,
    };
    float sum = pen_mesh_leaf_cost(lanes[PEN_COST_MESHES]);
    for (int k = 0; k < PEN_COST_MESHES; k++)
        sum += cost[k] * (float)((lanes[k] + PEN_LANES - 1) / PEN_LANES);
    return sum;
}
