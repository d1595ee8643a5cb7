/* SPDX-License-Identifier: MIT */
/* The builder of `auto`: the binned surface-area heuristic. It makes nodes of eight children on the
 * way down, by splitting the child with the largest surface until there are eight. It uses one
 * thread, so the tree is a pure function of the primitives.
 *
 * Below a depth of PEN_MAX_DEPTH / 2, and if all centroids are equal, ranges are split in half by
 * number. So no input makes a tree deeper than PEN_MAX_DEPTH.
 * Source: Wald, Benthin, Boulos, "Getting rid of packets", RT 2008; binning: Wald, "On fast
 * construction of SAH-based BVHs", RT 2007. */
#include <float.h>
#include <stddef.h>
#include <string.h>

#include "accel/internal/tree_layout.h"

enum { BINS = 16, CLASSES = PEN_COST_CLASS_COUNT, BLOCKS_MAX = 4 };

/* Three coordinates in the compiler's own vector type, for any processor. The last lane is
 * undefined. */
typedef float float4 __attribute__((vector_size(16), aligned(4), may_alias));
typedef int32_t mask4 __attribute__((vector_size(16)));

struct bounds {
    float4 lo, hi;
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

/* The bins along one axis. Most ranges are small and leave most bins empty; empty bins are not
 * cleared. */
struct bins {
    uint32_t filled; /* bit i: bin i holds a primitive */
    struct bin bin[BINS];
};

/* A way to split a range in two. */
struct split {
    int axis, bin; /* the first bin on the right; axis -1: none found */
    float cost;
};

static struct bounds empty(void)
{
    const float4 inf = {INFINITY, INFINITY, INFINITY, INFINITY};
    return (struct bounds){inf, -inf};
}

/* a where the mask is set, b elsewhere. */
static float4 choose(mask4 mask, float4 a, float4 b)
{
    return (float4)(((mask4)a & mask) | ((mask4)b & ~mask));
}

static void add_bounds(struct bounds *b, struct bounds c)
{
    b->lo = choose(c.lo < b->lo, c.lo, b->lo);
    b->hi = choose(c.hi > b->hi, c.hi, b->hi);
}

_Static_assert(offsetof(struct pen_ref, lo) == 0 &&
                   offsetof(struct pen_ref, hi) == sizeof(float4) &&
                   sizeof(struct pen_ref) == sizeof(struct bounds),
               "the bounds of a primitive are read as two vectors");

static struct bounds ref_bounds(const struct pen_ref *ref)
{
    const float4 *v = (const float4 *)ref;
    return (struct bounds){v[0], v[1]};
}

/* The coordinates, with 0 in the last lane. There a primitive has other numbers, which are not
 * coordinates, and slow as floats. */
static float4 first_three(float4 v)
{
    return (float4)((mask4)v & (mask4){-1, -1, -1, 0});
}

static float half_area(const struct bounds *b)
{
    float4 d = b->hi - b->lo;
    return d[0] >= 0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0;
}

static void add_ref(struct range *r, const struct pen_ref *ref)
{
    struct bounds box = ref_bounds(ref);
    float4 c = first_three(box.lo) + first_three(box.hi);
    add_bounds(&r->box, box);
    add_bounds(&r->centroid, (struct bounds){c, c});
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
                      struct bins bins[3])
{
    const float4 start = first_three(r->centroid.lo);
    const float4 by = {scale[0], scale[1], scale[2], 0};
    for (uint32_t i = r->begin; i < r->end; i++) {
        const struct bounds box = ref_bounds(&ref[i]);
        const float4 sum = first_three(box.lo) + first_three(box.hi);
        const mask4 at = __builtin_convertvector((sum - start) * by, mask4); /* as bin_of */
        for (int axis = 0; axis < 3; axis++) {
            if (scale[axis] == 0)
                continue;
            const int number = at[axis] < BINS ? at[axis] : BINS - 1;
            struct bin *bin = &bins[axis].bin[number];
            if (!(bins[axis].filled >> number & 1))
                *bin = (struct bin){empty(), {0}};
            bins[axis].filled |= 1u << number;
            add_bounds(&bin->box, box);
            bin->lanes[ref[i].cost_class] += ref[i].lanes;
        }
    }
}

static void add_bin(struct bin *sum, const struct bin *b)
{
    add_bounds(&sum->box, b->box);
    for (int k = 0; k < CLASSES; k++)
        sum->lanes[k] += b->lanes[k];
}

/* Finds the cheapest split between one axis's bins, if it is cheaper than *best. The first bin, of
 * the lowest centroid, is never empty. */
static void sweep(const struct bins *bins, int axis, struct split *best)
{
    float right[BINS];
    struct bin sum = {empty(), {0}};
    for (uint32_t rest = bins->filled & ~1u; rest; rest ^= 1u << 31 >> __builtin_clz(rest)) {
        int i = 31 - __builtin_clz(rest);
        add_bin(&sum, &bins->bin[i]);
        right[i] = half_area(&sum.box) * pen_leaf_cost(sum.lanes);
    }
    sum = bins->bin[0];
    for (uint32_t rest = bins->filled & ~1u; rest; rest &= rest - 1) {
        int i = __builtin_ctz(rest);
        float cost = half_area(&sum.box) * pen_leaf_cost(sum.lanes) + right[i];
        if (cost < best->cost)
            *best = (struct split){axis, i, cost};
        add_bin(&sum, &bins->bin[i]);
    }
}

static struct split find_split(const struct pen_ref *ref, const struct range *r,
                               const float scale[3])
{
    struct bins bins[3];
    struct split best = {-1, 0, INFINITY};
    for (int axis = 0; axis < 3; axis++)
        bins[axis].filled = 0;
    fill_bins(ref, r, scale, bins);
    for (int axis = 0; axis < 3; axis++) {
        if (scale[axis] > 0)
            sweep(&bins[axis], axis, &best);
    }
    return best;
}

/* Moves the primitives left of the split to the front, in any order, and measures both sides. */
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

/* Splits a range in two. If a leaf is cheaper, marks the range as a leaf and returns false. */
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

/* Splits the range with the largest surface until there are eight ranges or all are leaves. */
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
