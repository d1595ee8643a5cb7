/* SPDX-License-Identifier: MIT */
/* The builder of `cbr` and `manual`, which keep the structure of the document.
 *  - manual: the children of the document's top level are one list, in document order, each with
 *    its box. A group is a child like any other; its box leads to its own list.
 *  - cbr: there are no groups, and all primitives are in one list.
 * Children are single primitives, or whole meshes; nothing is merged, sorted or split. Groups
 * without a finite primitive are left out. The children of a group nested deeper than PEN_MAX_DEPTH
 * belong to the enclosing group. Cost: linear. */
#include <stdlib.h>

#include "accel/internal/tree_layout.h"

/* A group as a range of ref[], and the number of the next group that is not inside it. */
struct group_range {
    uint32_t begin, end, after;
};

struct lists {
    struct pen_tree_layout *layout;
    struct group_range *range;
    uint32_t count;
};

/* The end of the child that begins at `at`: the triangles of a mesh, at most up to `end`, or one
 * primitive. */
static uint32_t end_of_run(const struct pen_tree_layout *layout, uint32_t at, uint32_t end)
{
    const uint32_t prim = layout->ref[at].prim;
    const struct pen_mesh *mesh = pen_prim_mesh(layout->prims, prim);
    const uint32_t count = mesh ? mesh->first + mesh->count - prim : 1;
    return count < end - at ? at + count : end;
}

/* The index in ref[] of the first primitive with a number >= prim. */
static uint32_t find_ref(const struct pen_tree_layout *layout, uint32_t prim)
{
    uint32_t low = 0, high = layout->count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (layout->ref[middle].prim < prim)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool make_ranges(struct lists *l, const struct pen_groups *groups)
{
    uint32_t given = groups ? groups->count : 0;
    l->range = malloc(((size_t)given + 1) * sizeof *l->range);
    if (!l->range)
        return false;
    for (uint32_t i = 0; i < given; i++) {
        struct group_range s = {find_ref(l->layout, groups->group[i].begin),
                                find_ref(l->layout, groups->group[i].end), 0};
        if (s.begin < s.end)
            l->range[l->count++] = s;
    }
    for (uint32_t i = l->count; i-- > 0;) {
        uint32_t after = i + 1;
        while (after < l->count && l->range[after].begin < l->range[i].end)
            after = l->range[after].after;
        l->range[i].after = after;
    }
    return true;
}

/* An iterator over the children of a list: the references from `at` to `end`, and the groups from
 * `group` on, which begin no earlier than `at`. */
struct children {
    uint32_t at, end, group;
};

/* Advances to the next child; false at the end. The child is group *group or, if *group equals the
 * number of groups, the references from *ref to c->at - 1. With `flat`, the primitives of groups
 * are children instead.
 */
static bool next_child(const struct lists *l, struct children *c, bool flat, uint32_t *ref,
                       uint32_t *group)
{
    *ref = c->at;
    *group = l->count;
    if (c->at == c->end)
        return false;
    if (!flat && c->group < l->count && l->range[c->group].begin == c->at) {
        *group = c->group;
        c->at = l->range[c->group].end;
        c->group = l->range[c->group].after;
    } else {
        const bool stops = !flat && c->group < l->count && l->range[c->group].begin < c->end;
        c->at = end_of_run(l->layout, c->at, stops ? l->range[c->group].begin : c->end);
    }
    return true;
}

static uint32_t count_children(const struct lists *l, struct children c, bool flat)
{
    uint32_t count = 0, ref, group;
    while (next_child(l, &c, flat, &ref, &group))
        count++;
    return count;
}

/* Makes the leaf of a range of references. */
static bool build_leaf(struct lists *l, struct pen_leaf leaf, uint32_t depth,
                       struct pen_child_box *made)
{
    *made = pen_ref_box(&l->layout->ref[leaf.begin]);
    for (uint32_t i = 1; i < leaf.count; i++) {
        const struct pen_child_box box = pen_ref_box(&l->layout->ref[leaf.begin + i]);
        pen_child_box_grow(made, &box);
    }
    made->child = pen_tree_layout_add_leaf(l->layout, leaf.begin, leaf.count);
    if (l->layout->depth < depth)
        l->layout->depth = depth;
    return made->child != PEN_NO_CHILD;
}

/* Makes a list that is inside `depth` boxes; *made becomes its entry in the enclosing list. */
static bool build_list(struct lists *l, struct children c, uint32_t depth,
                       struct pen_child_box *made)
{
    bool flat = depth + 1 == PEN_MAX_DEPTH;
    uint32_t count = count_children(l, c, flat), first = l->layout->nodes.count, ref, group;
    *made = pen_child_box_empty;
    made->child = first;
    if (!pen_tree_layout_add_nodes(l->layout, count / PEN_WIDE + (count % PEN_WIDE != 0)))
        return false;
    l->layout->lists++;
    for (uint32_t i = 0; next_child(l, &c, flat, &ref, &group); i++) {
        struct pen_child_box child;
        bool ok = group == l->count
                      ? build_leaf(l, (struct pen_leaf){ref, c.at - ref}, depth + 1, &child)
                      : build_list(l, (struct children){ref, l->range[group].end, group + 1},
                                   depth + 1, &child);
        if (!ok)
            return false;
        pen_child_box_grow(made, &child);
        if (i % PEN_WIDE == 0 && count - i > PEN_WIDE)
            child.child |= PEN_CHILD_MORE;
        struct pen_node *nodes = l->layout->nodes.data;
        pen_node_put(&nodes[first + i / PEN_WIDE], (int)(i % PEN_WIDE), &child);
    }
    return true;
}

bool pen_build_lists(struct pen_tree_layout *layout, const struct pen_groups *groups)
{
    if (layout->count == 0)
        return true;
    layout->shape = PEN_SHAPE_LISTS;
    struct lists l = {.layout = layout};
    struct pen_child_box top;
    bool ok =
        make_ranges(&l, groups) && build_list(&l, (struct children){0, layout->count, 0}, 0, &top);
    free(l.range);
    return ok;
}
