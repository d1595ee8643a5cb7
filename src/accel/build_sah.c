/* SPDX-License-Identifier: MIT */
/* The builder of `auto`: the binned surface-area heuristic. It makes nodes of eight children on the
 * way down, by splitting the child with the largest surface until there are eight.
 *
 * The top of the tree is built first, down to ranges of SUBTREE primitives. Then threads build the
 * subtrees of these ranges, and their nodes are appended in order. Threads also share the bins and
 * the division of large ranges at the top. Sums of bins do not depend on their order, and a
 * division keeps the order of triangles. So the tree is a pure function of the primitives.
 *
 * Below a depth of PEN_MAX_DEPTH / 2, and if all centroids are equal, ranges are split in half by
 * number. So no input makes a tree deeper than PEN_MAX_DEPTH.
 * Source: Wald, Benthin, Boulos, "Getting rid of packets", RT 2008; binning: Wald, "On fast
 * construction of SAH-based BVHs", RT 2007. */
#include <stdlib.h>
#include <string.h>

#include "accel/internal/sah_split.h"
#include "base/memory.h"

enum {
    SUBTREE = 1 << 14, /* a range of so many primitives or fewer is built by one thread */
    USUAL = 16         /* primitives per node */
};

struct builder {
    struct pen_splitter splitter;
    struct pen_array *subtrees; /* struct subtree: those to build later; NULL: none */
};

/* A range that becomes a child of a node after the top of the tree is complete. */
struct subtree {
    const struct builder *b;
    struct pen_range range;
    uint32_t depth, node, root;
    int lane;
    struct pen_tree_layout made; /* its own nodes and leaves */
    uint32_t first_node, first_leaf;
};

/* Splits the range with the largest surface until there are eight ranges or all are leaves. */
static int widen(const struct builder *b, struct pen_range *child, uint32_t depth)
{
    int count = 1;
    while (count < PEN_WIDE) {
        int largest = -1;
        for (int i = 0; i < count; i++) {
            if (!child[i].leaf &&
                (largest < 0 || pen_half_area(&child[i].box) > pen_half_area(&child[largest].box)))
                largest = i;
        }
        if (largest < 0)
            break;
        if (pen_range_split(&b->splitter, &child[largest], depth, &child[count]))
            count++;
    }
    return count;
}

/* Makes the subtree of a range later. Returns false if it is to be made now, or out of memory. */
static bool build_later(const struct builder *b, const struct subtree *like)
{
    struct subtree *subtree = NULL;
    if (b->subtrees && !like->range.leaf && like->range.end - like->range.begin <= SUBTREE)
        subtree = pen_array_add(b->subtrees, 1);
    if (subtree)
        *subtree = *like;
    return subtree != NULL;
}

/* Makes the subtree of a range and returns it as a child; PEN_NO_CHILD when out of memory. */
static uint32_t build(const struct builder *b, const struct pen_range *r, uint32_t depth)
{
    struct pen_tree_layout *layout = b->splitter.layout;
    struct pen_range child[PEN_WIDE] = {*r};
    int count = r->leaf ? 1 : widen(b, child, depth);
    if (layout->depth < depth)
        layout->depth = depth;
    if (count == 1)
        return pen_tree_layout_add_leaf(layout, r->begin, r->end - r->begin);
    uint32_t number = layout->nodes.count;
    if (!pen_tree_layout_add_nodes(layout, 1))
        return PEN_NO_CHILD;
    for (int i = 0; i < count; i++) {
        const struct subtree later = {
            .b = b, .range = child[i], .depth = depth + 1, .node = number, .lane = i};
        uint32_t made = 0;
        if (!build_later(b, &later) && (made = build(b, &child[i], depth + 1)) == PEN_NO_CHILD)
            return PEN_NO_CHILD;
        struct pen_node *node = (struct pen_node *)layout->nodes.data + number;
        node->child[i] = made;
        for (int a = 0; a < 3; a++) {
            node->plane[a][i] = child[i].box.lo[a];
            node->plane[3 + a][i] = child[i].box.hi[a];
        }
    }
    return number;
}

static void build_subtree(void *user, uint32_t number)
{
    struct subtree *subtree = (struct subtree *)user + number;
    subtree->made = *subtree->b->splitter.layout;
    pen_tree_layout_begin(&subtree->made);
    const uint32_t nodes = (subtree->range.end - subtree->range.begin) / USUAL;
    if (pen_array_add(&subtree->made.nodes, nodes)) /* so that they need not move often */
        subtree->made.nodes.count = 0;
    const struct builder b = {{&subtree->made, subtree->b->splitter.other, false}, NULL};
    subtree->root = build(&b, &subtree->range, subtree->depth);
}

/* Appends the nodes and leaves of a subtree, and frees them. */
static void append_subtree(void *user, uint32_t number)
{
    const struct subtree *s = (struct subtree *)user + number;
    struct pen_tree_layout *to = s->b->splitter.layout, from = s->made;
    struct pen_node *node = (struct pen_node *)to->nodes.data + s->first_node;
    struct pen_leaf *leaf = (struct pen_leaf *)to->leaves.data + s->first_leaf;
    if (from.nodes.count > 0)
        memcpy(node, from.nodes.data, from.nodes.count * sizeof *node);
    memcpy(leaf, from.leaves.data, from.leaves.count * sizeof *leaf);
    for (uint32_t i = 0; i < from.nodes.count; i++)
        for (int lane = 0; lane < PEN_WIDE; lane++)
            if (node[i].child[lane] != PEN_NO_CHILD)
                node[i].child[lane] +=
                    node[i].child[lane] & PEN_CHILD_LEAF ? s->first_leaf : s->first_node;
    ((struct pen_node *)to->nodes.data)[s->node].child[s->lane] =
        s->root + (s->root & PEN_CHILD_LEAF ? s->first_leaf : s->first_node);
    pen_array_release(&from.nodes);
    pen_array_release(&from.leaves);
}

/* Makes space for the nodes and leaves of all subtrees, in order. Returns false when out of memory,
 * or if that has been so for a subtree. */
static bool make_places(struct pen_tree_layout *layout, struct pen_array *subtrees)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < subtrees->count; i++) {
        struct subtree *s = (struct subtree *)subtrees->data + i;
        s->first_node = layout->nodes.count;
        s->first_leaf = layout->leaves.count;
        layout->depth = s->made.depth > layout->depth ? s->made.depth : layout->depth;
        ok = s->root != PEN_NO_CHILD && pen_array_add(&layout->nodes, s->made.nodes.count) &&
             pen_array_add(&layout->leaves, s->made.leaves.count);
    }
    for (uint32_t i = 0; !ok && i < subtrees->count; i++) {
        struct subtree *s = (struct subtree *)subtrees->data + i;
        pen_array_release(&s->made.nodes);
        pen_array_release(&s->made.leaves);
    }
    return ok;
}

/* Makes the tree of a large range: its top, then its subtrees. */
static uint32_t build_large(const struct builder *b, const struct pen_range *all)
{
    struct pen_tree_layout *layout = b->splitter.layout;
    struct pen_array subtrees = {.size = sizeof(struct subtree)};
    const struct builder top = {{layout, b->splitter.other, layout->pool != NULL}, &subtrees};
    uint32_t root = build(&top, all, 0);
    if (root != PEN_NO_CHILD) {
        pen_parts_do(layout->pool, subtrees.count, build_subtree, subtrees.data);
        if (make_places(layout, &subtrees))
            pen_parts_do(layout->pool, subtrees.count, append_subtree, subtrees.data);
        else
            root = PEN_NO_CHILD;
    }
    pen_array_release(&subtrees);
    return root;
}

bool pen_build_sah(struct pen_tree_layout *layout)
{
    if (layout->count == 0)
        return true;
    struct pen_range all = pen_range_measure(layout->ref, 0, layout->count);
    struct builder b = {{.layout = layout}, NULL};
    layout->shape = PEN_SHAPE_WIDE;
    if (layout->frames &&
        !(b.splitter.other = pen_memory_large(layout->count * sizeof *b.splitter.other)))
        return false;
    uint32_t root = layout->count > SUBTREE ? build_large(&b, &all) : build(&b, &all, 0);
    free(b.splitter.other);
    if (root == PEN_NO_CHILD || !(root & PEN_CHILD_LEAF))
        return root != PEN_NO_CHILD;
    /* A single leaf gets a node, so that its box is tested. */
    struct pen_node *node = pen_tree_layout_add_nodes(layout, 1);
    if (!node)
        return false;
    node->child[0] = root;
    for (int a = 0; a < 3; a++) {
        node->plane[a][0] = all.box.lo[a];
        node->plane[3 + a][0] = all.box.hi[a];
    }
    layout->depth = 1;
    return true;
}
