/* SPDX-License-Identifier: MIT */
/* Packing: turns a tree layout into the frozen structure in an arena. The primitives of each leaf
 * are packed into SIMD blocks, kind by kind. It runs twice; the first pass only counts. */
#include <stdlib.h>
#include <string.h>

#include "accel/internal/tree_layout.h"

/* The number of elements of each array. */
struct counts {
    uint32_t item, corner, block[PEN_BLOCK_KIND_COUNT];
};

/* The arrays being filled, and the position in each. In the first pass `items` is NULL. */
struct packer {
    bool wide;    /* leaves of meshes have no items */
    bool singles; /* a leaf of one primitive is that primitive, not a block; never for `auto`,
                     because disk packets read only blocks */
    const struct pen_prims *prims;
    const struct pen_mesh_frame *frames;
    const struct pen_ref *ref;
    uint32_t *items;
    struct pen_triangles4 *triangles;
    struct pen_polygons4 *polygons;
    struct pen_corner4 *corners;
    struct pen_spheres4 *spheres;
    struct pen_cylinders4 *cylinders;
    struct pen_planes4 *planes;
    struct pen_generic4 *infinite_cylinders;
    struct pen_generic4 *generic;
    struct pen_mesh4 *mesh_blocks;
    bool no_items; /* of this leaf: its child names its blocks */
    struct counts n;
};

/* The primitives that go into one block: up to four of one kind. */
struct lanes {
    uint32_t prim[PEN_LANES], index[PEN_LANES];
    const struct pen_ref *ref[PEN_LANES];
    int count;
};

static void put(double to[3][PEN_LANES], int lane, struct pen_vec3 v)
{
    to[0][lane] = v.x;
    to[1][lane] = v.y;
    to[2][lane] = v.z;
}

/* Packs boxes. Empty lanes have a box that no ray enters. */
static void pack_boxes(struct pen_boxes4 *boxes, const struct lanes *in)
{
    for (int lane = 0; lane < PEN_LANES; lane++) {
        const struct pen_child_box box =
            lane < in->count ? pen_ref_box(in->ref[lane]) : pen_child_box_empty;
        for (int axis = 0; axis < 3; axis++) {
            boxes->plane[axis][lane] = box.lo[axis];
            boxes->plane[axis + 3][lane] = box.hi[axis];
        }
    }
}

/* Packs triangles. Empty lanes are all zero: a triangle of one point, which no ray intersects. */
static void pack_triangles(struct packer *p, const struct lanes *in, uint32_t block)
{
    struct pen_triangles4 *b = &p->triangles[block];
    memcpy(b->prim, in->prim, sizeof b->prim);
    for (int lane = 0; lane < in->count; lane++) {
        for (int i = 0; i < 3; i++)
            put(b->v[i], lane, p->prims->triangle[in->index[lane]].v[i]);
    }
}

static uint32_t most_corners(const struct pen_prims *prims, const struct lanes *in)
{
    uint32_t most = 0;
    for (int lane = 0; lane < in->count; lane++) {
        uint32_t count = prims->polygon[in->index[lane]].count;
        most = count > most ? count : most;
    }
    return most;
}

static void pack_polygons(struct packer *p, const struct lanes *in, uint32_t block)
{
    struct pen_polygons4 *b = &p->polygons[block];
    memcpy(b->prim, in->prim, sizeof b->prim);
    pack_boxes(&b->boxes, in);
    b->first = p->n.corner;
    b->count = most_corners(p->prims, in);
    p->n.corner += b->count;
    for (int lane = 0; lane < in->count; lane++) {
        const struct pen_polygon *pg = &p->prims->polygon[in->index[lane]];
        for (uint32_t i = 0; i < b->count; i++)
            put(p->corners[b->first + i].v, lane, pg->v[i < pg->count ? i : pg->count - 1]);
    }
}

static void pack_spheres(struct packer *p, const struct lanes *in, uint32_t block)
{
    struct pen_spheres4 *b = &p->spheres[block];
    memcpy(b->prim, in->prim, sizeof b->prim);
    for (int lane = 0; lane < PEN_LANES; lane++)
        b->rr[lane] = -1; /* an empty lane */
    for (int lane = 0; lane < in->count; lane++) {
        const struct pen_sphere *s = &p->prims->sphere[in->index[lane]];
        put(b->c, lane, s->c);
        b->r[lane] = s->r;
        b->rr[lane] = s->rr;
        b->rr_low[lane] = s->rr_low;
    }
}

static void pack_cylinders(struct packer *p, const struct lanes *in, uint32_t block)
{
    struct pen_cylinders4 *b = &p->cylinders[block];
    memcpy(b->prim, in->prim, sizeof b->prim);
    pack_boxes(&b->boxes, in);
    for (int lane = 0; lane < PEN_LANES; lane++)
        b->rr[lane] = -1; /* an empty lane */
    for (int lane = 0; lane < in->count; lane++) {
        const struct pen_cylinder *c = &p->prims->cylinder[in->index[lane]];
        put(b->q, lane, c->round.q);
        put(b->a, lane, c->round.a);
        b->rr[lane] = c->round.rr;
        b->rr_low[lane] = c->round.rr_low;
        b->base[lane] = c->slab_base;
        b->top[lane] = c->slab_top;
        b->size[lane] = c->round.r + c->h + c->rim / (8 * PEN_U);
        b->open |= (uint32_t)!c->caps << lane;
    }
}

/* Packs planes. Empty lanes have a normal of zero: every ray is parallel to such a plane. */
static void pack_planes(struct packer *p, const struct lanes *in, uint32_t block)
{
    struct pen_planes4 *b = &p->planes[block];
    memcpy(b->prim, in->prim, sizeof b->prim);
    for (int lane = 0; lane < in->count; lane++) {
        put(b->q, lane, p->prims->plane[in->index[lane]].q);
        put(b->g, lane, p->prims->plane[in->index[lane]].g);
    }
}

/* Packs triangles of a mesh, each from its distinguished corner on. */
static void pack_mesh(struct packer *p, const struct lanes *in, uint32_t block)
{
    struct pen_mesh4 *b = &p->mesh_blocks[block];
    const struct pen_mesh *mesh = pen_prim_mesh(p->prims, in->prim[0]);
    const float factor = p->frames[mesh - p->prims->mesh].factor;
    memcpy(b->prim, in->prim, sizeof b->prim);
    for (int k = 0; k < 9 * PEN_LANES; k++)
        ((float *)b->v)[k] = NAN;
    for (int lane = 0; lane < in->count; lane++) {
        const uint32_t triangle = in->prim[lane] - mesh->first;
        struct pen_vec3 v[3];
        pen_mesh_corners(mesh, triangle, v);
        const int first = pen_triangle_first_corner(v);
        for (int i = 0; i < 3; i++)
            for (int axis = 0; axis < 3; axis++)
                b->v[i][axis][lane] =
                    factor * pen_mesh_float(mesh, triangle, (first + i) % 3)[axis];
    }
}

/* Packs one block in the second pass; counts it in the first. */
static void pack_block(struct packer *p, const struct lanes *in, enum pen_block_kind kind)
{
    uint32_t block = p->n.block[kind]++, item = p->n.item++;
    if (!p->items) {
        if (kind == PEN_BLOCK_POLYGONS)
            p->n.corner += most_corners(p->prims, in);
        return;
    }
    if (!p->no_items)
        p->items[item] = PEN_ITEM(kind, block);
    switch (kind) {
    case PEN_BLOCK_TRIANGLES:
        pack_triangles(p, in, block);
        break;
    case PEN_BLOCK_POLYGONS:
        pack_polygons(p, in, block);
        break;
    case PEN_BLOCK_SPHERES:
        pack_spheres(p, in, block);
        break;
    case PEN_BLOCK_CYLINDERS:
        pack_cylinders(p, in, block);
        break;
    case PEN_BLOCK_PLANES:
        pack_planes(p, in, block);
        break;
    case PEN_BLOCK_INFINITE_CYLINDERS:
        memcpy(p->infinite_cylinders[block].prim, in->prim, sizeof in->prim);
        break;
    case PEN_BLOCK_GENERIC:
        memcpy(p->generic[block].prim, in->prim, sizeof in->prim);
        break;
    case PEN_BLOCK_MESH:
        pack_mesh(p, in, block);
        break;
    case PEN_BLOCK_NOTHING:
    case PEN_BLOCK_SINGLE:
    case PEN_BLOCK_KIND_COUNT:
        break; /* not a block of primitives */
    }
}

/* Packs a leaf of one primitive, which is read from the scene. */
static uint32_t pack_single(struct packer *p, uint32_t ref)
{
    uint32_t item = p->n.item++;
    if (p->items)
        p->items[item] = PEN_ITEM(PEN_BLOCK_SINGLE, p->ref[ref].prim) | PEN_ITEM_LAST;
    return item;
}

/* Packs the primitives of one kind of a leaf. */
static void pack_kind(struct packer *p, struct pen_leaf leaf, enum pen_block_kind kind)
{
    const struct lanes none = {{PEN_NO_PRIM, PEN_NO_PRIM, PEN_NO_PRIM, PEN_NO_PRIM}, {0}, {0}, 0};
    const bool meshes = kind == PEN_BLOCK_MESH && p->prims->mesh_count > 1;
    struct lanes in = none;
    if (!p->items && kind == PEN_BLOCK_MESH && !meshes && p->wide) {
        uint32_t count = 0;
        for (uint32_t i = leaf.begin; i < leaf.begin + leaf.count; i++)
            count += p->ref[i].kind == PEN_BLOCK_MESH;
        p->n.item += pen_parts_of(count, PEN_LANES);
        p->n.block[kind] += pen_parts_of(count, PEN_LANES);
        return;
    }
    for (uint32_t i = leaf.begin; i < leaf.begin + leaf.count; i++) {
        if (p->ref[i].kind != kind)
            continue;
        if (meshes && in.count > 0 &&
            pen_prim_mesh(p->prims, p->ref[i].prim) != pen_prim_mesh(p->prims, in.prim[0])) {
            pack_block(p, &in, kind);
            in = none;
        }
        in.prim[in.count] = p->ref[i].prim;
        in.ref[in.count] = &p->ref[i];
        in.index[in.count++] =
            kind == PEN_BLOCK_MESH ? 0 : pen_prim_ref(p->prims, p->ref[i].prim).index;
        if (in.count == PEN_LANES) {
            pack_block(p, &in, kind);
            in = none;
        }
    }
    if (in.count > 0)
        pack_block(p, &in, kind);
}

/* Whether the child of a node names the blocks of a leaf with these kinds of primitives. */
static bool needs_no_items(const struct packer *p, struct pen_leaf leaf, uint32_t kinds)
{
    struct packer counting = {.wide = p->wide, .prims = p->prims, .ref = p->ref};
    if (!p->wide || kinds != 1u << PEN_BLOCK_MESH)
        return false;
    pack_kind(&counting, leaf, PEN_BLOCK_MESH);
    return counting.n.block[PEN_BLOCK_MESH] <= PEN_LEAF_BLOCKS_MAX;
}

/* Packs the blocks of a leaf, kind by kind, and returns its first item, or what stands for it in
 * the child of a node. */
static uint32_t pack_leaf(struct packer *p, struct pen_leaf leaf)
{
    const uint32_t first = p->n.item, block = p->n.block[PEN_BLOCK_MESH];
    uint32_t kinds = 0; /* one bit per kind */
    for (uint32_t i = leaf.begin; i < leaf.begin + leaf.count; i++)
        kinds |= 1u << p->ref[i].kind;
    p->no_items = needs_no_items(p, leaf, kinds);
    for (; kinds; kinds &= kinds - 1)
        pack_kind(p, leaf, (enum pen_block_kind)__builtin_ctz(kinds));
    if (p->no_items) {
        p->n.item = first;
        return PEN_LEAF_BLOCKS | block * PEN_LEAF_BLOCKS_MAX |
               (p->n.block[PEN_BLOCK_MESH] - block - 1);
    }
    if (p->n.item == first) {
        if (p->items)
            p->items[first] = PEN_ITEM(PEN_BLOCK_NOTHING, 0);
        p->n.item++;
    }
    if (p->items)
        p->items[p->n.item - 1] |= PEN_ITEM_LAST;
    return first;
}

/* The leaves of a layout, while they are packed. */
struct leaves {
    const struct pen_tree_layout *layout;
    struct packer packer;  /* with the arrays */
    struct counts *before; /* by part: its own elements, then those of the parts before it */
    uint32_t *first;       /* by leaf: what pack_leaf returns */
};

enum { LEAVES_IN_PART = 1 << 11, INDICES_AHEAD = 8, VERTICES_AHEAD = 4 };

/* Packs the leaves of a part. */
static void pack_leaves(const struct leaves *leaves, struct packer *p, uint32_t part)
{
    const struct pen_leaf *leaf = leaves->layout->leaves.data;
    const uint32_t count = leaves->layout->leaves.count, begin = part * LEAVES_IN_PART;
    for (uint32_t i = begin; i < count && i - begin < LEAVES_IN_PART; i++) {
        if (p->items && i + INDICES_AHEAD < count) {
            pen_pack_fetch(leaves->layout, leaf[i + INDICES_AHEAD], false);
            pen_pack_fetch(leaves->layout, leaf[i + VERTICES_AHEAD], true);
        }
        const bool single =
            p->singles && leaf[i].count == 1 && p->ref[leaf[i].begin].kind != PEN_BLOCK_GENERIC;
        const uint32_t first = single ? pack_single(p, leaf[i].begin) : pack_leaf(p, leaf[i]);
        if (p->items)
            leaves->first[i] = first;
    }
}

static void pack_part(void *user, uint32_t part)
{
    const struct leaves *leaves = user;
    struct packer p = leaves->packer;
    p.n = leaves->before[part];
    pack_leaves(leaves, &p, part);
}

/* Item 0 is an empty leaf; item 1 begins the list of infinite primitives. Then follow the layout's
 * leaves. */
static void pack_lists(struct packer *p, const struct pen_tree_layout *layout)
{
    pack_leaf(p, (struct pen_leaf){0, 0});
    pack_leaf(p, (struct pen_leaf){layout->count, layout->infinite});
}

static uint32_t parts_of(const struct pen_tree_layout *layout)
{
    return pen_parts_of(layout->leaves.count, LEAVES_IN_PART);
}

static void count_part(void *user, uint32_t part)
{
    const struct leaves *leaves = user;
    struct packer p = leaves->packer;
    pack_leaves(leaves, &p, part);
    leaves->before[part] = p.n;
}

static struct counts counts_sum(struct counts a, const struct counts *b)
{
    a.item += b->item;
    a.corner += b->corner;
    for (int kind = 0; kind < PEN_BLOCK_KIND_COUNT; kind++)
        a.block[kind] += b->block[kind];
    return a;
}

/* Counts the elements of all leaves. */
static void count_leaves(struct leaves *leaves, struct counts *all)
{
    struct packer lists = leaves->packer;
    const uint32_t parts = parts_of(leaves->layout);
    pen_parts_do(leaves->layout->pool, parts, count_part, leaves);
    pack_lists(&lists, leaves->layout);
    *all = lists.n;
    for (uint32_t part = 0; part < parts; part++) {
        const struct counts own = leaves->before[part];
        leaves->before[part] = *all;
        *all = counts_sum(*all, &own);
    }
}

static bool allocate(struct packer *p, const struct counts *counted, struct pen_arena *arena)
{
    const uint32_t *n = counted->block;
    p->items = pen_arena_alloc(arena, counted->item, sizeof *p->items);
    p->triangles = pen_arena_alloc(arena, n[PEN_BLOCK_TRIANGLES], sizeof *p->triangles);
    p->polygons = pen_arena_alloc(arena, n[PEN_BLOCK_POLYGONS], sizeof *p->polygons);
    p->corners = pen_arena_alloc(arena, counted->corner, sizeof *p->corners);
    p->spheres = pen_arena_alloc(arena, n[PEN_BLOCK_SPHERES], sizeof *p->spheres);
    p->cylinders = pen_arena_alloc(arena, n[PEN_BLOCK_CYLINDERS], sizeof *p->cylinders);
    p->planes = pen_arena_alloc(arena, n[PEN_BLOCK_PLANES], sizeof *p->planes);
    p->infinite_cylinders =
        pen_arena_alloc(arena, n[PEN_BLOCK_INFINITE_CYLINDERS], sizeof *p->infinite_cylinders);
    p->generic = pen_arena_alloc(arena, n[PEN_BLOCK_GENERIC], sizeof *p->generic);
    p->mesh_blocks = pen_arena_alloc(arena, n[PEN_BLOCK_MESH], sizeof *p->mesh_blocks);
    return p->items && p->triangles && p->polygons && p->corners && p->spheres && p->cylinders &&
           p->planes && p->infinite_cylinders && p->generic && p->mesh_blocks;
}

/* Replaces the numbers of leaves by those of their first items, and empty children by the empty
 * leaf. */
static void pack_children(uint32_t *child, int count, const uint32_t *first_item)
{
    for (int lane = 0; lane < count; lane++) {
        uint32_t more = lane == 0 ? child[lane] & PEN_CHILD_MORE : 0;
        uint32_t number = child[lane] & ~(PEN_CHILD_LEAF | PEN_CHILD_MORE);
        if (child[lane] == PEN_NO_CHILD)
            child[lane] = PEN_CHILD_LEAF;
        else if (child[lane] & PEN_CHILD_LEAF)
            child[lane] = PEN_CHILD_LEAF | more | first_item[number];
    }
}

static bool pack_nodes(const struct pen_tree_layout *layout, const uint32_t *first_item,
                       struct pen_arena *arena, struct pen_accel *accel)
{
    uint32_t count = layout->nodes.count;
    void *nodes = pen_arena_alloc(arena, count, layout->nodes.size);
    if (!nodes)
        return false;
    if (count > 0)
        memcpy(nodes, layout->nodes.data, count * layout->nodes.size);
    if (layout->shape == PEN_SHAPE_PAIRS)
        accel->pairs = nodes;
    else
        accel->nodes = nodes;
    for (uint32_t i = 0; i < count; i++) {
        if (layout->shape == PEN_SHAPE_PAIRS)
            pack_children(((struct pen_pair *)nodes)[i].child, 2, first_item);
        else
            pack_children(((struct pen_node *)nodes)[i].child, PEN_WIDE, first_item);
    }
    accel->shape = layout->shape;
    return true;
}

/* The largest pen_prim_scale of a finite primitive. */
static double largest_scale(const struct pen_tree_layout *layout)
{
    double largest = 0;
    for (uint32_t i = 0; i < layout->count && !pen_tree_layout_meshes_alone(layout); i++) {
        if (layout->ref[i].kind == PEN_BLOCK_MESH)
            continue;
        double scale = pen_prim_scale(layout->prims, layout->ref[i].prim, pen_vec3(0, 0, 0));
        largest = scale > largest ? scale : largest;
    }
    return largest;
}

/* Packs the leaves and nodes; p gets the arrays and their counts. */
static bool pack_all(struct packer *p, const struct pen_tree_layout *layout,
                     struct pen_arena *arena, struct pen_accel *accel)
{
    struct leaves leaves = {.layout = layout, .packer = *p};
    struct counts counted;
    leaves.first = malloc((layout->leaves.count + (size_t)1) * sizeof *leaves.first);
    leaves.before = malloc((parts_of(layout) + (size_t)1) * sizeof *leaves.before);
    bool ok = leaves.first && leaves.before;
    if (ok)
        count_leaves(&leaves, &counted);
    ok = ok && allocate(p, &counted, arena);
    if (ok) {
        pack_lists(p, layout);
        leaves.packer = *p;
        pen_parts_do(layout->pool, parts_of(layout), pack_part, &leaves);
        p->n = counted;
        ok = pack_nodes(layout, leaves.first, arena, accel);
        accel->list =
            layout->shape == PEN_SHAPE_NONE && layout->leaves.count > 0 ? leaves.first[0] : 0;
    }
    free(leaves.first);
    free(leaves.before);
    return ok;
}

bool pen_accel_pack(const struct pen_tree_layout *layout, struct pen_arena *arena,
                    struct pen_accel *accel)
{
    struct packer p = {.wide = layout->shape == PEN_SHAPE_WIDE,
                       .singles =
                           layout->shape == PEN_SHAPE_PAIRS || layout->shape == PEN_SHAPE_LISTS,
                       .prims = layout->prims,
                       .frames = layout->frames,
                       .ref = layout->ref};
    const bool ok = pack_all(&p, layout, arena, accel);
    accel->prims = layout->prims;
    accel->items = p.items;
    accel->triangles = p.triangles;
    accel->polygons = p.polygons;
    accel->corners = p.corners;
    accel->spheres = p.spheres;
    accel->cylinders = p.cylinders;
    accel->planes = p.planes;
    accel->infinite_cylinders = p.infinite_cylinders;
    accel->generic = p.generic;
    accel->mesh_blocks = p.mesh_blocks;
    accel->mixed = p.n.item > 2;
    accel->mesh_frames = p.n.block[PEN_BLOCK_MESH] > 0 ? layout->frames : NULL;
    accel->infinite = 1;
    accel->scale = largest_scale(layout);
    accel->stats.nodes = layout->shape == PEN_SHAPE_LISTS ? layout->lists : layout->nodes.count;
    accel->stats.leaves = layout->leaves.count;
    accel->stats.depth = layout->depth;
    return ok && (layout->shape != PEN_SHAPE_WIDE || pen_accel_pack_boxes(layout, arena, accel));
}
