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

double pen_tree_layout_cost(const struct pen_tree_layout *layout)
{
    if (layout->shape == PEN_SHAPE_NONE)
        return (double)layout->count + layout->infinite;
    double root = pen_tree_layout_half_area(layout),
           sum = cost_of_child(layout, 0) + layout->infinite;
    for (uint32_t node = 0; node < layout->nodes.count; node++) {
        struct pen_child_box in;
        for (int lane = 0; lane < pen_tree_layout_width(layout); lane++) {
            if (pen_tree_layout_child(layout, node, lane, &in))
                sum += (root > 0 ? pen_child_box_half_area(&in) / root : 1) *
                       cost_of_child(layout, in.child);
        }
    }
    return sum;
}
