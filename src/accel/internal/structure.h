/* SPDX-License-Identifier: MIT */
/* The frozen acceleration structure, which builders fill and traversals read. src/accel/README.md
 * describes it as a whole.
 *
 * A structure has nodes and leaves. Each child of a node has a box in binary32, rounded outward. A
 * leaf is a short list of items. An item is a block of up to four primitives of one kind, with a
 * copy of the data for their test, lane by lane. Or it is a single primitive, which is read from
 * the scene. Infinite primitives are in a list beside the nodes; with PEN_ACCEL_NONE all other
 * primitives are in such a list too. The form of a node depends on the structure's shape:
 *
 *   wide   (auto, if it chooses a tree) up to eight children, entered nearest first;
 *   pairs  (median) two children, entered nearest first; a leaf is a block of triangles, or a
 *          single primitive;
 *   lists  (cbr, manual) any number of children, eight to a node in consecutive nodes, entered in
 *          document order; cbr is one list, manual has one for each group. A leaf is a single
 *          primitive.
 *
 * Why boxes never hide an intersection: for a flat primitive, the point of an intersection is a
 * mean of vertices with weights in [0, 1]. For a quadric, it is within the box's own margin. Both
 * are off by a few 2^-53 of t and of the vertices' distance from the box's faces. The box test
 * leaves a margin of at least 2^-24 of t. */
#ifndef PEN_ACCEL_INTERNAL_STRUCTURE_H
#define PEN_ACCEL_INTERNAL_STRUCTURE_H

#include "accel/accel.h"

enum { PEN_WIDE = 8, PEN_LANES = 4, PEN_MAX_DEPTH = 64 };

/* Outlines with more corners count as not convex. */
enum { PEN_CONVEX_CORNERS = 8 };

/* A child is the number of a node. With this bit set, it is the number of a leaf's first item. */
#define PEN_CHILD_LEAF 0x80000000u
/* In wide trees, a leaf of one to four blocks of meshes, and nothing else, has no items. Then this
 * bit is set with PEN_CHILD_LEAF; the rest is the number of its first block times four, plus the
 * number of its other blocks. */
#define PEN_LEAF_BLOCKS 0x40000000u
enum { PEN_LEAF_BLOCKS_MAX = 4 };
/* In lists, the first child of a node also has this bit set if the next node continues the list. */
#define PEN_CHILD_MORE 0x40000000u

/* The kind of an item: a block, or a single primitive. Leaves hold their blocks in this order. A
 * kind of primitive that is tested several at once has its own kind of block. Every other kind is
 * packed in generic blocks, whose primitives are tested one by one with pen_prim_intersect. */
enum pen_block_kind {
    PEN_BLOCK_GENERIC,
    PEN_BLOCK_TRIANGLES,
    PEN_BLOCK_POLYGONS,
    PEN_BLOCK_SPHERES,
    PEN_BLOCK_CYLINDERS,
    PEN_BLOCK_PLANES,
    PEN_BLOCK_INFINITE_CYLINDERS,
    PEN_BLOCK_MESH,
    PEN_BLOCK_NOTHING, /* in the empty leaf */
    PEN_BLOCK_SINGLE,  /* the index is the primitive's number */
    PEN_BLOCK_KIND_COUNT
};

/* An item: its index in the lowest bits, then its kind. The top bit is set in the last item of a
 * leaf. */
#define PEN_ITEM_LAST 0x80000000u
#define PEN_ITEM_INDEX_BITS 26
#define PEN_ITEM_KIND_BITS 5
#define PEN_ITEM_INDEX_MAX ((1u << PEN_ITEM_INDEX_BITS) - 1)
#define PEN_ITEM(kind, index) ((uint32_t)(kind) << PEN_ITEM_INDEX_BITS | (index))
#define PEN_ITEM_KIND(item)                                                                        \
    ((enum pen_block_kind)((item) >> PEN_ITEM_INDEX_BITS & ((1u << PEN_ITEM_KIND_BITS) - 1)))
#define PEN_ITEM_INDEX(item) ((item)&PEN_ITEM_INDEX_MAX)
_Static_assert(PEN_ITEM_INDEX_BITS + PEN_ITEM_KIND_BITS + 1 == 32, "an item fills 32 bits");
_Static_assert(PEN_PRIM_KINDS_MAX + PEN_BLOCK_KIND_COUNT - PEN_BLOCK_NOTHING <
                   1 << PEN_ITEM_KIND_BITS,
               "room for a block of each of 16 kinds of primitives, a generic one and the others");
_Static_assert(PEN_BLOCK_KIND_COUNT <= 1 << PEN_ITEM_KIND_BITS, "an item's tag holds its kind");

/* The kind of block for a kind of primitive; generic if the kind is not listed here. */
static inline enum pen_block_kind pen_block_of(uint32_t prim_kind)
{
    static const uint8_t block[PEN_PRIM_KIND_COUNT] = {
        [PEN_PRIM_TRIANGLE] = PEN_BLOCK_TRIANGLES,
        [PEN_PRIM_POLYGON] = PEN_BLOCK_POLYGONS,
        [PEN_PRIM_SPHERE] = PEN_BLOCK_SPHERES,
        [PEN_PRIM_CYLINDER] = PEN_BLOCK_CYLINDERS,
        [PEN_PRIM_PLANE] = PEN_BLOCK_PLANES,
        [PEN_PRIM_INFINITE_CYLINDER] = PEN_BLOCK_INFINITE_CYLINDERS,
    };
    return (enum pen_block_kind)block[prim_kind];
}

/* A node of up to eight children. An empty lane has a box that no ray enters, and the empty leaf as
 * its child: PEN_CHILD_LEAF, item 0. */
struct pen_node {
    float plane[6][PEN_WIDE]; /* the boxes: low ends by axis, then high ends by axis */
    uint32_t child[PEN_WIDE];
};

/* A node of two children. */
struct pen_pair {
    float plane[6][2];
    uint32_t child[2];
};

enum pen_shape { PEN_SHAPE_NONE, PEN_SHAPE_WIDE, PEN_SHAPE_PAIRS, PEN_SHAPE_LISTS };

/* The boxes of a block's primitives, as in struct pen_node. */
struct pen_boxes4 {
    float plane[6][PEN_LANES];
};

/* Blocks. A lane without a primitive has prim = PEN_NO_PRIM and data that no ray intersects. */
struct pen_triangles4 {
    double v[3][3][PEN_LANES]; /* vertex, axis, lane */
    uint32_t prim[PEN_LANES];
};

struct pen_polygons4 {
    struct pen_boxes4 boxes;
    uint32_t first, count; /* in `corners`; a polygon with fewer vertices repeats its last one */
    uint32_t prim[PEN_LANES];
};

struct pen_corner4 {
    double v[3][PEN_LANES];
};

struct pen_spheres4 {
    double c[3][PEN_LANES];
    double r[PEN_LANES], rr[PEN_LANES], rr_low[PEN_LANES];
    uint32_t prim[PEN_LANES];
};

struct pen_planes4 {
    double q[3][PEN_LANES], g[3][PEN_LANES];
    uint32_t prim[PEN_LANES];
};

/* Primitives that are tested one by one and read from the scene. */
struct pen_generic4 {
    uint32_t prim[PEN_LANES];
};

struct pen_cylinders4 {
    struct pen_boxes4 boxes;
    double q[3][PEN_LANES], a[3][PEN_LANES];
    double rr[PEN_LANES], rr_low[PEN_LANES];
    double base[PEN_LANES], top[PEN_LANES]; /* slab_base, slab_top */
    double size[PEN_LANES];                 /* radius + height; open ones: plus the rim over 8u */
    uint32_t prim[PEN_LANES];
    uint32_t open; /* bit per lane: no caps */
};

/* Triangles of one mesh, each from its distinguished corner on. Their numbers are those of the mesh
 * times a power of two, such that the mesh is about as large as 1: see struct pen_mesh_frame. A
 * lane without a triangle has NaN. */
struct pen_mesh4 {
    float v[3][3][PEN_LANES]; /* vertex, axis, lane */
    uint32_t prim[PEN_LANES];
};

/* What the test of a mesh's blocks needs of the mesh. A number f of a block is at shift + unit f.
 * Lengths are in these numbers. */
struct pen_mesh_frame {
    double unit, inv_unit;
    float factor; /* numbers of the block per number of the mesh */
    float extent; /* the largest size of a coordinate, in [1/2, 1] or 0 */
};

struct pen_float_box {
    float lo[3], hi[3];
};

struct pen_accel {
    const struct pen_prims *prims;
    enum pen_shape shape;
    const struct pen_node *nodes; /* for wide and lists; the root, or its list, is the first */
    const struct pen_pair *pairs; /* for pairs; the root is the first */
    uint32_t infinite;            /* first item of the list of infinite primitives */
    uint32_t list; /* first item of the list of finite primitives; 0 if they are in nodes */
    const uint32_t *items;
    const struct pen_triangles4 *triangles;
    const struct pen_polygons4 *polygons;
    const struct pen_corner4 *corners;
    const struct pen_spheres4 *spheres;
    const struct pen_cylinders4 *cylinders;
    const struct pen_planes4 *planes;
    const struct pen_generic4 *infinite_cylinders;
    const struct pen_generic4 *generic;
    const struct pen_mesh4 *mesh_blocks;
    const struct pen_mesh_frame *mesh_frames; /* by mesh; NULL: no mesh has blocks */
    double scale;                             /* the largest pen_prim_scale of a finite primitive */
    double extent;                            /* the largest size of a coordinate of their boxes */
    /* By slot, wide trees only; zero for infinite primitives and for meshes: see pen_accel_box. */
    const struct pen_float_box *prim_box;
    const bool *convex; /* by slot, wide trees only: see pack_boxes.c */
    bool mixed;         /* some block is none of a mesh */
    bool packets;       /* rays of a packet are traced in groups */
    struct pen_accel_stats stats;
    struct pen_test_counts *counts; /* for a view that counts; else NULL */
};

#endif
