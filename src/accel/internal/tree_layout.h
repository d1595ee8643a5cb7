/* SPDX-License-Identifier: MIT */
/* What a builder decides: an order of the finite primitives, leaves as ranges of that order, and
 * nodes over them. Packing turns a plan into the frozen structure. */
#ifndef PEN_ACCEL_INTERNAL_TREE_LAYOUT_H
#define PEN_ACCEL_INTERNAL_TREE_LAYOUT_H

#include <stddef.h>

#include "accel/internal/structure.h"

/* A growing array of elements of one size. */
struct pen_array {
    void *data;
    size_t size; /* of an element, in bytes */
    uint32_t count, capacity;
};

/* Room for `more` elements at the end, not zeroed; NULL when out of memory. */
void *pen_array_add(struct pen_array *array, uint32_t more);
void pen_array_release(struct pen_array *array);

struct pen_leaf {
    uint32_t begin, count; /* in order[] */
};

/* What a builder reads of a primitive. */
struct pen_ref {
    float lo[3];
    uint32_t prim;
    float hi[3];
    uint16_t kind;             /* enum pen_block_kind */
    uint8_t cost_class, lanes; /* see pen_leaf_cost */
};

struct pen_tree_layout {
    const struct pen_prims *prims;
    unsigned generic_kinds;  /* bit per enum pen_prim_kind: packed in generic blocks, although the
                              * kind has its own */
    struct pen_ref *ref;     /* first the finite primitives; builders bring them into their order */
    uint32_t count;          /* of these */
    uint32_t infinite;       /* count of those without bounds, which come after */
    enum pen_shape shape;    /* none as long as there are no nodes */
    struct pen_array nodes;  /* struct pen_node, or pen_pair where the shape is pairs; leaf children
                              * hold PEN_CHILD_LEAF | leaf number */
    struct pen_array leaves; /* struct pen_leaf; of one primitive where the shape is lists */
    uint32_t lists;          /* how many, where the shape is lists */
    uint32_t depth;          /* boxes around the innermost primitive */
};

/* Lists the primitives in document order, finite ones with boxes rounded outward.
 * Fails: returns false when out of memory. */
bool pen_tree_layout_init(struct pen_tree_layout *layout, const struct pen_prims *prims,
                          unsigned generic_kinds);
void pen_tree_layout_release(struct pen_tree_layout *layout);

/* Adds a leaf of a range of ref[]; returns the child, or PEN_NO_CHILD when out of memory. */
uint32_t pen_tree_layout_add_leaf(struct pen_tree_layout *layout, uint32_t begin, uint32_t count);
#define PEN_NO_CHILD UINT32_MAX

/* Nodes in a row whose lanes are all empty; NULL when out of memory. Nodes move when others are
 * added. */
struct pen_node *pen_tree_layout_add_nodes(struct pen_tree_layout *layout, uint32_t count);
struct pen_pair *pen_tree_layout_add_pair(struct pen_tree_layout *layout);

/* One child of a node and its box. */
struct pen_child_box {
    float lo[3], hi[3];
    uint32_t child; /* without PEN_CHILD_MORE */
};

extern const struct pen_child_box pen_child_box_empty;

/* The box of a primitive; no child. */
struct pen_child_box pen_ref_box(const struct pen_ref *ref);

/* Grows the box of *sum to hold that of *in. */
void pen_child_box_grow(struct pen_child_box *sum, const struct pen_child_box *in);

void pen_node_put(struct pen_node *node, int lane, const struct pen_child_box *in);
void pen_pair_put(struct pen_pair *pair, int lane, const struct pen_child_box *in);

/* The lanes that nodes of the plan's shape have. */
int pen_tree_layout_width(const struct pen_tree_layout *layout);

/* Reads a lane of a node; false if it is empty. */
bool pen_tree_layout_child(const struct pen_tree_layout *layout, uint32_t node, int lane,
                           struct pen_child_box *out);

/* Whether the node after this one continues its list. */
bool pen_tree_layout_list_continues(const struct pen_tree_layout *layout, uint32_t node);

/* Costs of tests, in units of one test of a block of triangles. A block costs the same however many
 * of its lanes are filled, so builders count lanes by class of cost. A primitive of a generic block
 * is tested alone: it counts as so many full blocks of triangles as its kind's row in pen_kinds
 * says that it costs. */
enum pen_cost_class {
    PEN_COST_TRIANGLES,
    PEN_COST_POLYGONS,
    PEN_COST_SPHERES,
    PEN_COST_CYLINDERS,
    PEN_COST_CLASS_COUNT
};

/* The expected cost of the tests in a leaf with so many filled lanes of each class. */
float pen_leaf_cost(const uint32_t lanes[PEN_COST_CLASS_COUNT]);

/* That of the boxes of a node. */
extern const float pen_node_cost;

/* The cost of one box test in primitive tests, in statistics: pen_node_cost is that of eight, in
 * tests of four triangles. */
#define PEN_BOX_TEST_COST 0.15

/* The surface-area heuristic. Fails: returns false when out of memory. */
bool pen_build_sah(struct pen_tree_layout *layout);

/* Median split. Fails: returns false when out of memory. */
bool pen_build_median(struct pen_tree_layout *layout);

/* A list for each group, one for all without groups. Fails: returns false when out of memory. */
bool pen_build_lists(struct pen_tree_layout *layout, const struct pen_groups *groups);

/* The expected cost of a ray, as pen_accel_stats defines it. */
double pen_tree_layout_cost(const struct pen_tree_layout *layout);

/* Fills in everything of *accel but stats.kind, sah_cost and build_ms. Owns: all in the arena.
 * Fails: returns false when out of memory. */
bool pen_accel_pack(const struct pen_tree_layout *layout, struct pen_arena *arena,
                    struct pen_accel *accel);

#endif
