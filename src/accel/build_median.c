/* SPDX-License-Identifier: MIT */
/* The builder of `median`: a binary tree. Each range of primitives is split at the median of their
 * boxes' centres, along the axis with the largest extent of the centres. It ends at single
 * primitives, or at up to four triangles, which are one block. No costs are estimated: this is the
 * plain tree with which others are compared.
 *
 * The primitives are sorted once along each axis, by a stable radix sort, so equal centres stay in
 * document order. Every split divides the three orders stably. This is how a k-d tree is built by
 * presorting (Bentley, "Multidimensional binary search trees used for associative searching", CACM
 * 18(9), 1975; Wald and Havran, "On building fast kd-trees for ray tracing, and on doing that in
 * O(N log N)", RT 2006). The halves of a range differ by at most one primitive, even if all centres
 * are equal, so the tree is balanced.
 * Cost: n log n for any input. */
#include <stdlib.h>
#include <string.h>

#include "accel/internal/tree_layout.h"

enum { DIGITS = 1 << 8 };

struct median {
    struct pen_tree_layout *layout;
    const struct pen_ref *ref; /* in document order until the tree is complete */
    uint32_t *order[3]; /* indices into ref, sorted by axis; order[0] becomes the order of leaves */
    uint32_t *spare;    /* room for one order */
    uint32_t *key;      /* sort keys for one axis, by index into ref */
    uint8_t *left;      /* by index into ref: goes to the left half */
};

static float center(const struct pen_ref *ref, int axis)
{
    return 0.5f * ref->lo[axis] + 0.5f * ref->hi[axis];
}

/* Maps a float to a number with the same order. */
static uint32_t ordered(float f)
{
    uint32_t bits;
    f += 0.0f; /* -0 and +0 are equal */
    memcpy(&bits, &f, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/* One pass of a radix sort: stable, by eight bits of the keys. */
static void sort_digit(const uint32_t *key, int shift, const uint32_t *from, uint32_t *to,
                       uint32_t count)
{
    uint32_t start[DIGITS] = {0}, sum = 0;
    for (uint32_t i = 0; i < count; i++)
        start[key[from[i]] >> shift & (DIGITS - 1)]++;
    for (int d = 0; d < DIGITS; d++) {
        uint32_t n = start[d];
        start[d] = sum;
        sum += n;
    }
    for (uint32_t i = 0; i < count; i++)
        to[start[key[from[i]] >> shift & (DIGITS - 1)]++] = from[i];
}

static void sort_axis(struct median *m, int axis)
{
    uint32_t count = m->layout->count;
    for (uint32_t i = 0; i < count; i++) {
        m->key[i] = ordered(center(&m->ref[i], axis));
        m->order[axis][i] = i;
    }
    for (int shift = 0; shift < 32; shift += 16) {
        sort_digit(m->key, shift, m->order[axis], m->spare, count);
        sort_digit(m->key, shift + 8, m->spare, m->order[axis], count);
    }
}

/* The axis along which the centres of a range extend farthest; the first of equals. */
static int longest_axis(const struct median *m, uint32_t begin, uint32_t end)
{
    int longest = 0;
    float most = -1;
    for (int axis = 0; axis < 3; axis++) {
        const uint32_t *order = m->order[axis];
        float extent = center(&m->ref[order[end - 1]], axis) - center(&m->ref[order[begin]], axis);
        if (extent > most) {
            longest = axis;
            most = extent;
        }
    }
    return longest;
}

/* Moves the left half to the front of an order's range; both halves keep their order. */
static void divide(struct median *m, uint32_t *order, uint32_t begin, uint32_t end)
{
    uint32_t left = begin, right = 0;
    for (uint32_t i = begin; i < end; i++) {
        if (m->left[order[i]])
            order[left++] = order[i];
        else
            m->spare[right++] = order[i];
    }
    memcpy(&order[left], m->spare, right * sizeof *order);
}

/* Splits a range at its median and returns the position. */
static uint32_t split(struct median *m, uint32_t begin, uint32_t end)
{
    int axis = longest_axis(m, begin, end);
    uint32_t middle = begin + (end - begin) / 2;
    for (uint32_t i = begin; i < end; i++)
        m->left[m->order[axis][i]] = i < middle;
    for (int a = 0; a < 3; a++) {
        if (a != axis)
            divide(m, m->order[a], begin, end);
    }
    return middle;
}

static bool is_leaf(const struct median *m, uint32_t begin, uint32_t end)
{
    if (end - begin == 1)
        return true;
    if (end - begin > PEN_LANES)
        return false;
    for (uint32_t i = begin; i < end; i++) {
        if (m->ref[m->order[0][i]].kind != PEN_BLOCK_TRIANGLES)
            return false;
    }
    return true;
}

static bool build_leaf(struct median *m, uint32_t begin, uint32_t end, struct pen_child_box *made)
{
    for (uint32_t i = begin; i < end; i++) {
        struct pen_child_box box = pen_ref_box(&m->ref[m->order[0][i]]);
        pen_child_box_grow(made, &box);
    }
    made->child = pen_tree_layout_add_leaf(m->layout, begin, end - begin);
    return made->child != PEN_NO_CHILD;
}

/* Makes the subtree of a range; *made becomes its entry in the parent. */
static bool build(struct median *m, uint32_t begin, uint32_t end, uint32_t depth,
                  struct pen_child_box *made)
{
    *made = pen_child_box_empty;
    made->child = m->layout->nodes.count;
    if (m->layout->depth < depth)
        m->layout->depth = depth;
    bool leaf = is_leaf(m, begin, end);
    if (leaf && depth > 0)
        return build_leaf(m, begin, end, made);
    uint32_t number = made->child;
    if (!pen_tree_layout_add_pair(m->layout))
        return false;
    uint32_t middle = leaf ? end : split(m, begin, end);
    for (int lane = 0; lane < 2 && begin < end; lane++) {
        struct pen_child_box child;
        if (!build(m, begin, middle, depth + 1, &child))
            return false;
        pen_pair_put((struct pen_pair *)m->layout->nodes.data + number, lane, &child);
        pen_child_box_grow(made, &child);
        begin = middle;
        middle = end;
    }
    return true;
}

/* Brings the layout's references into the order of the leaves. */
static bool reorder(struct median *m)
{
    uint32_t count = m->layout->count;
    struct pen_ref *ref = malloc(count * sizeof *ref);
    if (!ref)
        return false;
    for (uint32_t i = 0; i < count; i++)
        ref[i] = m->layout->ref[m->order[0][i]];
    memcpy(m->layout->ref, ref, count * sizeof *ref);
    free(ref);
    return true;
}

bool pen_build_median(struct pen_tree_layout *layout)
{
    size_t count = layout->count;
    if (count == 0)
        return true;
    layout->shape = PEN_SHAPE_PAIRS;
    layout->nodes.size = sizeof(struct pen_pair);
    struct median m = {.layout = layout, .ref = layout->ref};
    uint32_t *numbers = malloc(5 * count * sizeof *numbers);
    m.left = malloc(count);
    bool ok = numbers && m.left;
    if (ok) {
        for (int axis = 0; axis < 3; axis++)
            m.order[axis] = numbers + (size_t)axis * count;
        m.spare = numbers + 3 * count;
        m.key = numbers + 4 * count;
        for (int axis = 0; axis < 3; axis++)
            sort_axis(&m, axis);
        struct pen_child_box root;
        ok = build(&m, 0, layout->count, 0, &root) && reorder(&m);
    }
    free(numbers);
    free(m.left);
    return ok;
}
