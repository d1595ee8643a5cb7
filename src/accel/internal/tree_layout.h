/* SPDX-License-Identifier: MIT */
/* Tree layouts: the decisions of a builder. A layout is an order of the finite primitives, leaves
 * as ranges of that order, and nodes over the leaves. pen_accel_pack turns it into the frozen
 * structure. */
#ifndef PEN_ACCEL_INTERNAL_TREE_LAYOUT_H
#define PEN_ACCEL_INTERNAL_TREE_LAYOUT_H

#include <stddef.h>

#include "accel/internal/structure.h"
#include "base/thread_pool.h"

/* A growing array of elements of one size. */
struct pen_array {
    void *data;
    size_t size; /* of an element, in bytes */
    uint32_t count, capacity;
};

/* Appends `more` elements, not zeroed, and returns the first; NULL when out of memory. */
void *pen_array_add(struct pen_array *array, uint32_t more);
void pen_array_release(struct pen_array *array);

struct pen_leaf {
    uint32_t begin, count; /* in ref[] */
};

/* A primitive, as builders read it. */
struct pen_ref {
    float lo[3];
    uint32_t prim;
    float hi[3];
    uint16_t kind;             /* enum pen_block_kind */
    uint8_t cost_class, lanes; /* see pen_leaf_cost */
};

struct pen_tree_layout {
    struct pen_thread_pool *pool; /* NULL: only the calling thread */
    const struct pen_prims *prims;
    unsigned generic_kinds; /* bit 1 << enum pen_prim_kind: packed in generic blocks although the
                               kind has its own block; 0 except in tests */
    const struct pen_mesh_frame *frames; /* by mesh; NULL: meshes have no blocks of their own */
    struct pen_ref *ref; /* the finite primitives, which builders reorder, then the infinite ones */
    uint32_t count;      /* of finite primitives */
    uint32_t infinite;   /* count of infinite primitives */
    enum pen_shape shape;    /* PEN_SHAPE_NONE while there are no nodes */
    struct pen_array nodes;  /* struct pen_node, or pen_pair for pairs; leaf children hold
                                PEN_CHILD_LEAF | leaf number */
    struct pen_array leaves; /* struct pen_leaf; of one primitive each for lists */
    uint32_t lists;          /* number of lists, for lists */
    uint32_t depth;          /* boxes around the innermost primitive */
};

/* Calls fn(user, i) for each i below `parts`, in any order, on all threads of the pool. The calls
 * must not depend on one another, so that the number of threads changes nothing. */
void pen_parts_do(struct pen_thread_pool *pool, uint32_t parts,
                  void (*fn)(void *user, uint32_t part), void *user);

/* The number of parts of `each` elements or fewer. */
static inline uint32_t pen_parts_of(uint32_t count, uint32_t each)
{
    return count / each + (count % each > 0);
}

/* Begins a layout with the primitives in document order; finite ones get boxes rounded outward.
 * The caller has set the pool, prims, generic_kinds and frames, and all other members to 0.
 * Fails: returns false when out of memory. */
bool pen_tree_layout_init(struct pen_tree_layout *layout);
void pen_tree_layout_release(struct pen_tree_layout *layout);

/* Makes the nodes and leaves of a layout empty, without freeing them. */
static inline void pen_tree_layout_begin(struct pen_tree_layout *layout)
{
    layout->nodes = (struct pen_array){.size = sizeof(struct pen_node)};
    layout->leaves = (struct pen_array){.size = sizeof(struct pen_leaf)};
}

/* Whether all finite primitives are triangles of meshes in blocks of their own. */
static inline bool pen_tree_layout_meshes_alone(const struct pen_tree_layout *layout)
{
    uint64_t triangles = 0;
    for (uint32_t i = 0; layout->frames && i < layout->prims->mesh_count; i++)
        triangles += layout->prims->mesh[i].count;
    return triangles > 0 && triangles == layout->count;
}

/* Adds a leaf, a range of ref[]. Returns it as a child, or PEN_NO_CHILD when out of memory. */
uint32_t pen_tree_layout_add_leaf(struct pen_tree_layout *layout, uint32_t begin, uint32_t count);
#define PEN_NO_CHILD UINT32_MAX

/* Adds `count` consecutive nodes without children and returns the first; NULL when out of memory.
 * Adding nodes may move earlier ones. */
struct pen_node *pen_tree_layout_add_nodes(struct pen_tree_layout *layout, uint32_t count);
struct pen_pair *pen_tree_layout_add_pair(struct pen_tree_layout *layout);

/* A child of a node, with its box. */
struct pen_child_box {
    float lo[3], hi[3];
    uint32_t child; /* without PEN_CHILD_MORE */
};

extern const struct pen_child_box pen_child_box_empty;

/* The box of a primitive; its child is PEN_NO_CHILD. */
struct pen_child_box pen_ref_box(const struct pen_ref *ref);

/* Grows the box of *sum to contain that of *in. */
void pen_child_box_grow(struct pen_child_box *sum, const struct pen_child_box *in);

/* Sets the child and the box in one lane of a node. */
void pen_node_put(struct pen_node *node, int lane, const struct pen_child_box *in);
void pen_pair_put(struct pen_pair *pair, int lane, const struct pen_child_box *in);

/* The number of lanes of the layout's nodes. */
int pen_tree_layout_width(const struct pen_tree_layout *layout);

/* Reads a lane of a node; false if it is empty. */
bool pen_tree_layout_child(const struct pen_tree_layout *layout, uint32_t node, int lane,
                           struct pen_child_box *out);

/* Whether the node after this one continues its list. */
bool pen_tree_layout_list_continues(const struct pen_tree_layout *layout, uint32_t node);

/* Costs are in units of one test of a block of triangles. A block costs the same for any number of
 * filled lanes, so builders count filled lanes, by class of cost. A primitive of a generic block is
 * tested alone: it counts as several full blocks of triangles, by the cost of its kind (pen_kinds).
 */
enum pen_cost_class {
    PEN_COST_TRIANGLES,
    PEN_COST_POLYGONS,
    PEN_COST_SPHERES,
    PEN_COST_CYLINDERS,
    PEN_COST_MESHES, /* the last one */
    PEN_COST_CLASS_COUNT
};

/* The cost of a leaf of meshes' triangles alone: two blocks are tested at once, in about the time
 * of a node. */
static inline float pen_mesh_leaf_cost(uint32_t triangles)
{
    return 0.3f * (float)((triangles + 2 * PEN_LANES - 1) / (2 * PEN_LANES));
}

/* The expected cost of the tests in a leaf with these numbers of filled lanes by class. */
float pen_leaf_cost(const uint32_t lanes[PEN_COST_CLASS_COUNT]);

/* The cost of the box tests of one wide node. */
extern const float pen_node_cost;

/* The cost of one box test in primitive tests, as statistics define it: pen_node_cost (0.3) is that
 * of eight boxes in tests of four triangles, and 0.3 / 8 * 4 = 0.15. */
#define PEN_BOX_TEST_COST 0.15

/* Builds by the surface-area heuristic.
 * Fails: returns false when out of memory. */
bool pen_build_sah(struct pen_tree_layout *layout);

/* Builds by median split.
 * Fails: returns false when out of memory. */
bool pen_build_median(struct pen_tree_layout *layout);

/* Builds one list for each group; without groups (NULL), one list of all primitives.
 * Fails: returns false when out of memory. */
bool pen_build_lists(struct pen_tree_layout *layout, const struct pen_groups *groups);

/* The expected cost of a ray, as pen_accel_stats defines it. */
double pen_tree_layout_cost(const struct pen_tree_layout *layout);

/* Half the surface of the box around all children of the first node or list. A line that meets this
 * box meets a box inside it with a probability that is the ratio of their surfaces. */
double pen_tree_layout_half_area(const struct pen_tree_layout *layout);
double pen_child_box_half_area(const struct pen_child_box *box);

/* The expected times that pen_accel_stats defines. `layout` is the tree of pen_build_sah, or has no
 * finite primitive.
 * Cost: linear. */
void pen_auto_expect(const struct pen_tree_layout *layout, double expected[PEN_AUTO_COUNT]);

/* The choice with the least expected time; the first of equals. */
enum pen_auto_choice pen_auto_choose(const double expected[PEN_AUTO_COUNT]);

/* Fills in *accel, except stats.kind, stats.sah_cost and stats.build_ms.
 * Owns: the arena owns everything.
 * Fails: returns false when out of memory. */
bool pen_accel_pack(const struct pen_tree_layout *layout, struct pen_arena *arena,
                    struct pen_accel *accel);

/* Fills in the frames of all meshes. Returns false if there are no meshes, or if some mesh cannot
 * have blocks because its numbers are too far apart. */
bool pen_mesh_frames_make(const struct pen_prims *prims, struct pen_mesh_frame *frame);

/* Reads ahead what the packing of a leaf's mesh triangles needs: their numbers of vertices, or the
 * vertices. Neighbours in space may be far from one another in a file. */
void pen_pack_fetch(const struct pen_tree_layout *layout, struct pen_leaf leaf, bool vertices);

/* Fills in the members of wide trees for ray packets: extent, prim_box, convex.
 * Owns: the arena owns everything.
 * Fails: returns false when out of memory. */
bool pen_accel_pack_boxes(const struct pen_tree_layout *layout, struct pen_arena *arena,
                          struct pen_accel *accel);

#endif
