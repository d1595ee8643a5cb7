/* SPDX-License-Identifier: MIT */
/* The builder of `auto`: binned surface-area heuristic, made eight-wide on the way down by
 * splitting the child of largest surface until there are eight (Wald, Benthin, Boulos, "Getting
 * rid of packets", RT 2008; binning: Wald, "On fast construction of SAH-based BVHs", RT 2007).
 * Single-threaded, and so a pure function of the primitives.
 *
 * Below a depth of PEN_MAX_DEPTH / 2, and where all centroids are equal, ranges are split in half
 * by number, so no input makes a tree deeper than PEN_MAX_DEPTH. */
#include <float.h>
#include <string.h>

#include "accel/internal/tree_layout.h"

enum { BINS = 16, CLASSES = PEN_COST_CLASS_COUNT, BLOCKS_MAX = 4 };

struct bounds {
    float lo[3], hi[3];
};

/* A range of ref[], not yet a node or a leaf. */
struct range {
    uint32_t begin, end;
    struct bounds box;      /* of the primitives */
    struct bounds centroid; /* of lo + hi */
    uint32_t lanes[CLASSES];
    bool leaf; /* splitting does not reduce the cost */
};

struct bin {
    struct bounds box;
    uint32_t lanes[CLASSES];
};

/* A way to split a range in two. */
struct split {
    int axis, bin; /* the first bin on the right; axis -1: none found */
    float cost;
};

static struct bounds empty(void)
{
    return (struct bounds){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static void add_point(struct bounds *b, const float lo[3], const float hi[3])
{
    for (int a = 0; a < 3; a++) {
        b->lo[a] = lo[a] < b->lo[a] ? lo[a] : b->lo[a];
        b->hi[a] = hi[a] > b->hi[a] ? hi[a] : b->hi[a];
    }
}

static void add_bounds(struct bounds *b, const struct bounds *c)
{
    add_point(b, c->lo, c->hi);
}

static float half_area(const struct bounds *b)
{
    float x = b->hi[0] - b->lo[0], y = b->hi[1] - b->lo[1], z = b->hi[2] - b->lo[2];
    return x >= 0 ? x * y + y * z + z * x : 0;
}

static void add_ref(struct range *r, const struct pen_ref *ref)
{
    float c[3] = {ref->lo[0] + ref->hi[0], ref->lo[1] + ref->hi[1], ref->lo[2] + ref->hi[2]};
    add_point(&r->box, ref->lo, ref->hi);
    add_point(&r->centroid, c, c);
    r->lanes[ref->cost_class] += ref->lanes;
}

static struct range measure(const struct pen_ref *ref, uint32_t begin, uint32_t end)
{
    struct range r = {.begin = begin, .end = end, .box = empty(), .centroid = empty()};
    for (uint32_t i = begin; i < end; i++)
        add_ref(&r, &ref[i]);
    return r;
}

/* The bin that a primitive falls into. */
static int bin_of(const struct pen_ref *ref, int axis, float start, float scale)
{
    int bin = (int)((ref->lo[axis] + ref->hi[axis] - start) * scale);
    return bin < BINS ? bin : BINS - 1;
}

/* Bins per unit of centroid; 0 where the axis cannot be binned. */
static float bin_scale(const struct range *r, int axis)
{
    float extent = r->centroid.hi[axis] - r->centroid.lo[axis];
    float scale = (float)BINS * 0.999f / extent;
    return extent > 0 && extent <= FLT_MAX && scale <= FLT_MAX ? scale : 0;
}

static void fill_bins(const struct pen_ref *ref, const struct range *r, const float scale[3],
                      struct bin bins[3][BINS])
{
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < BINS; i++)
            bins[axis][i] = (struct bin){empty(), {0}};
    }
    for (uint32_t i = r->begin; i < r->end; i++) {
        for (int axis = 0; axis < 3; axis++) {
            if (scale[axis] == 0)
                continue;
            struct bin *bin = &bins[axis][bin_of(&ref[i], axis, r->centroid.lo[axis], scale[axis])];
            add_point(&bin->box, ref[i].lo, ref[i].hi);
            bin->lanes[ref[i].cost_class] += ref[i].lanes;
        }
    }
}

static void add_bin(struct bin *sum, const struct bin *b)
{
    add_bounds(&sum->box, &b->box);
    for (int k = 0; k < CLASSES; k++)
        sum->lanes[k] += b->lanes[k];
}

/* Finds the cheapest split between one axis's bins, if it is cheaper than *best. */
static void sweep(const struct bin bins[BINS], int axis, struct split *best)
{
    float right[BINS];
    struct bin sum = {empty(), {0}};
    for (int i = BINS - 1; i > 0; i--) {
        add_bin(&sum, &bins[i]);
        right[i] = half_area(&sum.box) * pen_leaf_cost(sum.lanes);
    }
    sum = (struct bin){empty(), {0}};
    for (int i = 1; i < BINS; i++) {
        add_bin(&sum, &bins[i - 1]);
        float cost = half_area(&sum.box) * pen_leaf_cost(sum.lanes) + right[i];
        if (cost < best->cost)
            *best = (struct split){axis, i, cost};
    }
}

static struct split find_split(const struct pen_ref *ref, const struct range *r,
                               const float scale[3])
{
    struct bin bins[3][BINS];
    struct split best = {-1, 0, INFINITY};
    fill_bins(ref, r, scale, bins);
    for (int axis = 0; axis < 3; axis++) {
        if (scale[axis] > 0)
            sweep(bins[axis], axis, &best);
    }
    return best;
}

/* Moves the primitives left of the split to the front, not keeping the order, and measures both
 * sides. */
static void divide(struct pen_ref *ref, const struct range *r, const struct split *split,
                   float scale, struct range *left, struct range *right)
{
    float start = r->centroid.lo[split->axis];
    uint32_t i = r->begin, j = r->end;
    *left = (struct range){.box = empty(), .centroid = empty()};
    *right = *left;
    while (i < j) {
        if (bin_of(&ref[i], split->axis, start, scale) < split->bin) {
            add_ref(left, &ref[i++]);
        } else {
            struct pen_ref moved = ref[i];
            ref[i] = ref[--j];
            ref[j] = moved;
            add_ref(right, &moved);
        }
    }
    left->begin = r->begin;
    left->end = right->begin = i;
    right->end = r->end;
}

/* Splits a range in two; if a leaf is cheaper, marks the range as one and returns false. */
static bool split_range(struct pen_tree_layout *layout, struct range *r, uint32_t depth,
                        struct range *right)
{
    uint32_t count = r->end - r->begin, blocks = 0;
    for (int k = 0; k < CLASSES; k++)
        blocks += (r->lanes[k] + PEN_LANES - 1) / PEN_LANES;
    r->leaf = count <= 1 || (blocks == 1 && count <= 2);
    if (r->leaf)
        return false;
    float scale[3] = {bin_scale(r, 0), bin_scale(r, 1), bin_scale(r, 2)};
    struct split best = {-1, 0, INFINITY};
    if (depth < PEN_MAX_DEPTH / 2)
        best = find_split(layout->ref, r, scale);
    float area = half_area(&r->box);
    if (blocks <= BLOCKS_MAX &&
        !(best.cost + pen_node_cost * area < pen_leaf_cost(r->lanes) * area)) {
        r->leaf = true;
        return false;
    }
    struct range whole = *r;
    if (best.axis >= 0) {
        divide(layout->ref, &whole, &best, scale[best.axis], r, right);
    } else {
        uint32_t middle = whole.begin + count / 2;
        *r = measure(layout->ref, whole.begin, middle);
        *right = measure(layout->ref, middle, whole.end);
    }
    return true;
}

/* Splits the range with the largest surface until there are eight or all are leaves. */
static int widen(struct pen_tree_layout *layout, struct range *child, uint32_t depth)
{
    int count = 1;
    while (count < PEN_WIDE) {
        int largest = -1;
        for (int i = 0; i < count; i++) {
            if (!child[i].leaf &&
                (largest < 0 || half_area(&child[i].box) > half_area(&child[largest].box)))
                largest = i;
        }
        if (largest < 0)
            break;
        if (split_range(layout, &child[largest], depth, &child[count]))
            count++;
    }
    return count;
}

/* Makes the subtree of a range and returns it as a child; PEN_NO_CHILD when out of memory. */
static uint32_t build(struct pen_tree_layout *layout, const struct range *r, uint32_t depth)
{
    struct range child[PEN_WIDE] = {*r};
    int count = r->leaf ? 1 : widen(layout, child, depth);
    if (layout->depth < depth)
        layout->depth = depth;
    if (count == 1)
        return pen_tree_layout_add_leaf(layout, r->begin, r->end - r->begin);
    uint32_t number = layout->nodes.count;
    if (!pen_tree_layout_add_nodes(layout, 1))
        return PEN_NO_CHILD;
    for (int i = 0; i < count; i++) {
        uint32_t made = build(layout, &child[i], depth + 1);
        if (made == PEN_NO_CHILD)
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

bool pen_build_sah(struct pen_tree_layout *layout)
{
    if (layout->count == 0)
        return true;
    struct range all = measure(layout->ref, 0, layout->count);
    layout->shape = PEN_SHAPE_WIDE;
    uint32_t root = build(layout, &all, 0);
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
