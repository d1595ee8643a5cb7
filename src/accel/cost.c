/* SPDX-License-Identifier: MIT */
/* The expected cost of a ray, by the surface-area heuristic. A random line that meets the box
 * around all primitives meets a convex box inside it with a probability that is the ratio of their
 * surfaces. It is computed from the finished layout, in the same way for every kind.
 * Source: Goldsmith and Salmon, "Automatic creation of object hierarchies for ray tracing", IEEE
 * CG&A 7(5), 1987. */
#include "accel/internal/tree_layout.h"

double pen_child_box_half_area(const struct pen_child_box *box)
{
    double x = (double)box->hi[0] - (double)box->lo[0], y = (double)box->hi[1] - (double)box->lo[1],
           z = (double)box->hi[2] - (double)box->lo[2];
    return x >= 0 ? x * y + y * z + z * x : 0;
}

/* The box around all children of the first list or node. */
static struct pen_child_box whole(const struct pen_tree_layout *layout)
{
    struct pen_child_box sum = pen_child_box_empty;
    uint32_t node = 0;
    do {
        struct pen_child_box in;
        for (int lane = 0; lane < pen_tree_layout_width(layout); lane++) {
            if (pen_tree_layout_child(layout, node, lane, &in))
                pen_child_box_grow(&sum, &in);
        }
    } while (pen_tree_layout_list_continues(layout, node++));
    return sum;
}

double pen_tree_layout_half_area(const struct pen_tree_layout *layout)
{
    struct pen_child_box all = whole(layout);
    return pen_child_box_half_area(&all);
}

/* The cost of entering a child: the boxes of a node, or the primitives of a leaf. */
static double cost_of_child(const struct pen_tree_layout *layout, uint32_t child)
{
    const struct pen_leaf *leaves = layout->leaves.data;
    if (child & PEN_CHILD_LEAF)
        return leaves[child & ~PEN_CHILD_LEAF].count;
    uint32_t boxes = 0, node = child;
    do {
        struct pen_child_box in;
        for (int lane = 0; lane < pen_tree_layout_width(layout); lane++)
            boxes += pen_tree_layout_child(layout, node, lane, &in);
    } while (pen_tree_layout_list_continues(layout, node++));
    return PEN_BOX_TEST_COST * boxes;
}

/* As in auto_choice.c. */
enum { PARTS = 64, NODES_LEAST = 1 << 12 };

struct summing {
    const struct pen_tree_layout *layout;
    double root;   /* half the area of the box around all */
    uint32_t each; /* nodes of a part */
    double part[PARTS];
};

static void sum_part(void *user, uint32_t part)
{
    struct summing *s = user;
    const struct pen_tree_layout *layout = s->layout;
    const uint32_t begin = part * s->each;
    double sum = part == 0 ? cost_of_child(layout, 0) + layout->infinite : 0;
    for (uint32_t node = begin; node < layout->nodes.count && node - begin < s->each; node++) {
        struct pen_child_box in;
        for (int lane = 0; lane < pen_tree_layout_width(layout); lane++) {
            if (pen_tree_layout_child(layout, node, lane, &in))
                sum += (s->root > 0 ? pen_child_box_half_area(&in) / s->root : 1) *
                       cost_of_child(layout, in.child);
        }
    }
    s->part[part] = sum;
}

double pen_tree_layout_cost(const struct pen_tree_layout *layout)
{
    if (layout->shape == PEN_SHAPE_NONE)
        return (double)layout->count + layout->infinite;
    const uint32_t nodes = layout->nodes.count, least = pen_parts_of(nodes, PARTS);
    struct summing s = {.layout = layout,
                        .root = pen_tree_layout_half_area(layout),
                        .each = least > NODES_LEAST ? least : NODES_LEAST};
    pen_parts_do(layout->pool, pen_parts_of(nodes, s.each), sum_part, &s);
    for (uint32_t i = 1; i < pen_parts_of(nodes, s.each); i++)
        s.part[0] += s.part[i];
    return s.part[0];
}
