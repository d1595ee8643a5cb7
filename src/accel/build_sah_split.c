/* SPDX-License-Identifier: MIT */
/* Splits of ranges: bins, the choice among their borders, and the division. For large ranges of
 * triangles of meshes, threads share the bins and the division, part by part. Sums of bins do not
 * depend on their order, and the triangles keep their order on both sides. So the threads change
 * nothing.
 *
 * Functions with `mesh` are compiled twice: ranges of triangles of meshes alone have one class of
 * cost, and are frequent. */
#include <float.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "accel/internal/sah_split.h"

enum {
    BINS = 16,
    CLASSES = PEN_COST_CLASS_COUNT,
    BLOCKS_MAX = 4,
    SHARED = 1 << 14, /* a range with more triangles is split by all threads together */
    PART = 1 << 13    /* of such a range, for one thread */
};

#define INLINED static inline __attribute__((always_inline))

typedef int32_t mask4 __attribute__((vector_size(16)));

struct bin {
    struct pen_bounds box;
    uint32_t lanes[8]; /* by class; the rest makes a bin as long as a cache line */
};

/* The bins along one axis. Most ranges are small and leave most bins empty. */
struct bins {
    _Alignas(16) struct bin bin[BINS];
    uint32_t filled; /* bit i: bin i holds a primitive */
};

/* A way to split a range in two. */
struct split {
    int axis, bin; /* the first bin on the right; axis -1: none found */
    float cost;
};

/* What a part of a large range adds to the whole. */
struct part {
    struct bins bins[3];
    uint32_t left, right; /* the places of its first triangles on each side of a split */
    struct pen_range on_left, on_right; /* begin and end are not of use */
};

/* A range with what its splitting needs. */
struct splitting {
    const struct pen_splitter *splitter;
    struct pen_range whole;
    float scale[3]; /* bins per unit of centroid; 0 where the axis cannot be binned */
    struct split split;
    struct part *part; /* NULL: it is split by one thread */
};

static struct pen_bounds empty(void)
{
    const pen_float4 inf = {INFINITY, INFINITY, INFINITY, INFINITY};
    return (struct pen_bounds){inf, -inf};
}

/* Compilers make one instruction of each loop. */
static void add_bounds(struct pen_bounds *b, struct pen_bounds c)
{
    for (int i = 0; i < 4; i++)
        b->lo[i] = c.lo[i] < b->lo[i] ? c.lo[i] : b->lo[i];
    for (int i = 0; i < 4; i++)
        b->hi[i] = c.hi[i] > b->hi[i] ? c.hi[i] : b->hi[i];
}

_Static_assert(offsetof(struct pen_ref, lo) == 0 &&
                   offsetof(struct pen_ref, hi) == sizeof(pen_float4) &&
                   sizeof(struct pen_ref) == sizeof(struct pen_bounds),
               "the bounds of a primitive are read as two vectors");

static struct pen_bounds ref_bounds(const struct pen_ref *ref)
{
    const pen_float4 *v = (const pen_float4 *)ref;
    return (struct pen_bounds){v[0], v[1]};
}

/* The coordinates, with 0 in the last lane. There a primitive has other numbers, which are not
 * coordinates, and slow as floats. */
static pen_float4 first_three(pen_float4 v)
{
    return (pen_float4)((mask4)v & (mask4){-1, -1, -1, 0});
}

static struct pen_bounds centroid_of(struct pen_bounds box)
{
    const pen_float4 c = first_three(box.lo) + first_three(box.hi);
    return (struct pen_bounds){c, c};
}

static void add_ref(struct pen_range *r, const struct pen_ref *ref)
{
    const struct pen_bounds box = ref_bounds(ref);
    add_bounds(&r->box, box);
    add_bounds(&r->centroid, centroid_of(box));
    r->lanes[ref->cost_class] += ref->lanes;
}

struct pen_range pen_range_measure(const struct pen_ref *ref, uint32_t begin, uint32_t end)
{
    struct pen_range r = {.begin = begin, .end = end, .box = empty(), .centroid = empty()};
    for (uint32_t i = begin; i < end; i++)
        add_ref(&r, &ref[i]);
    return r;
}

/* The same for triangles of meshes. */
static struct pen_range measure_mesh(const struct pen_ref *ref, uint32_t begin, uint32_t end)
{
    struct pen_range r = {.begin = begin, .end = end, .lanes = {[PEN_COST_MESHES] = end - begin}};
    struct pen_bounds box = empty(), centroid = box;
    for (uint32_t i = begin; i < end; i++) {
        add_bounds(&box, ref_bounds(&ref[i]));
        add_bounds(&centroid, centroid_of(ref_bounds(&ref[i])));
    }
    r.box = box;
    r.centroid = centroid;
    return r;
}

static void merge(struct pen_range *sum, const struct pen_range *part)
{
    add_bounds(&sum->box, part->box);
    add_bounds(&sum->centroid, part->centroid);
    for (int k = 0; k < CLASSES; k++)
        sum->lanes[k] += part->lanes[k];
}

static bool is_mesh(const struct pen_range *r)
{
    return r->lanes[PEN_COST_MESHES] == r->end - r->begin;
}

/* The bin that a primitive falls into. */
static int bin_of(const struct pen_ref *ref, int axis, float start, float scale)
{
    int bin = (int)((ref->lo[axis] + ref->hi[axis] - start) * scale);
    return bin < BINS ? bin : BINS - 1;
}

/* Bins per unit of centroid; 0 where the axis cannot be binned. */
static float bin_scale(const struct pen_range *r, int axis)
{
    float extent = r->centroid.hi[axis] - r->centroid.lo[axis];
    float scale = (float)BINS * 0.999f / extent;
    return extent > 0 && extent <= FLT_MAX && scale <= FLT_MAX ? scale : 0;
}

static void clear_bins(struct bins bins[3])
{
    for (int axis = 0; axis < 3; axis++) {
        bins[axis].filled = 0;
        for (int i = 0; i < BINS; i++)
            bins[axis].bin[i] = (struct bin){empty(), {0}};
    }
}

INLINED void fill_bins(const struct splitting *s, uint32_t begin, uint32_t end, struct bins bins[3],
                       bool mesh)
{
    const struct pen_ref *ref = s->splitter->layout->ref;
    const pen_float4 start = first_three(s->whole.centroid.lo);
    const pen_float4 by = {s->scale[0], s->scale[1], s->scale[2], 0};
    clear_bins(bins);
    for (uint32_t i = begin; i < end; i++) {
        const struct pen_bounds box = ref_bounds(&ref[i]);
        const pen_float4 sum = first_three(box.lo) + first_three(box.hi);
        const mask4 at = __builtin_convertvector((sum - start) * by, mask4); /* as bin_of */
        for (int axis = 0; axis < 3; axis++) {
            const uint32_t place = (uint32_t)at[axis], number = place < BINS ? place : BINS - 1;
            struct bin *bin = &bins[axis].bin[number];
            bins[axis].filled |= 1u << number;
            add_bounds(&bin->box, box);
            bin->lanes[mesh ? PEN_COST_MESHES : ref[i].cost_class] += mesh ? 1 : ref[i].lanes;
        }
    }
}

INLINED void add_bin(struct bin *sum, const struct bin *b, bool mesh)
{
    add_bounds(&sum->box, b->box);
    for (int k = mesh ? PEN_COST_MESHES : 0; k < CLASSES; k++)
        sum->lanes[k] += b->lanes[k];
}

INLINED float cost_of(const uint32_t *lanes, bool mesh)
{
    return mesh ? pen_mesh_leaf_cost(lanes[PEN_COST_MESHES]) : pen_leaf_cost(lanes);
}

/* Finds the cheapest split between one axis's bins, if it is cheaper than *best. The first bin, of
 * the lowest centroid, is never empty. */
INLINED void sweep(const struct bins *bins, int axis, struct split *best, bool mesh)
{
    float right[BINS];
    struct bin sum = {empty(), {0}};
    for (uint32_t rest = bins->filled & ~1u; rest; rest ^= 1u << 31 >> __builtin_clz(rest)) {
        int i = 31 - __builtin_clz(rest);
        add_bin(&sum, &bins->bin[i], mesh);
        right[i] = pen_half_area(&sum.box) * cost_of(sum.lanes, mesh);
    }
    sum = bins->bin[0];
    for (uint32_t rest = bins->filled & ~1u; rest; rest &= rest - 1) {
        int i = __builtin_ctz(rest);
        float cost = pen_half_area(&sum.box) * cost_of(sum.lanes, mesh) + right[i];
        if (cost < best->cost)
            *best = (struct split){axis, i, cost};
        add_bin(&sum, &bins->bin[i], mesh);
    }
}

static uint32_t part_begin(const struct splitting *s, uint32_t part)
{
    return s->whole.begin + part * PART;
}

static uint32_t part_end(const struct splitting *s, uint32_t part)
{
    const uint32_t begin = part_begin(s, part);
    return s->whole.end - begin < PART ? s->whole.end : begin + PART;
}

static void bin_part(void *user, uint32_t part)
{
    struct splitting *s = user;
    fill_bins(s, part_begin(s, part), part_end(s, part), s->part[part].bins, true);
}

/* Fills the bins of a large range of a mesh by all threads, part by part. Returns false, with
 * nothing done, if the range is not large or memory is short. */
static bool share_bins(struct splitting *s, struct bins bins[3])
{
    struct pen_thread_pool *pool = s->splitter->layout->pool;
    const uint32_t count = s->whole.end - s->whole.begin, parts = pen_parts_of(count, PART);
    if (!pool || !s->splitter->shared || count <= SHARED)
        return false;
    s->part = malloc(parts * sizeof *s->part);
    if (!s->part)
        return false;
    pen_parts_do(pool, parts, bin_part, s);
    clear_bins(bins);
    for (uint32_t i = 0; i < parts; i++)
        for (int axis = 0; axis < 3; axis++) {
            bins[axis].filled |= s->part[i].bins[axis].filled;
            for (int k = 0; k < BINS; k++)
                add_bin(&bins[axis].bin[k], &s->part[i].bins[axis].bin[k], true);
        }
    return true;
}

INLINED void find_split(struct splitting *s, bool mesh)
{
    struct bins bins[3];
    if (!mesh || !share_bins(s, bins))
        fill_bins(s, s->whole.begin, s->whole.end, bins, mesh);
    for (int axis = 0; axis < 3; axis++)
        if (s->scale[axis] > 0)
            sweep(&bins[axis], axis, &s->split, mesh);
}

static bool is_left(const struct splitting *s, const struct pen_ref *ref)
{
    const int axis = s->split.axis;
    return bin_of(ref, axis, s->whole.centroid.lo[axis], s->scale[axis]) < s->split.bin;
}

/* Moves the primitives left of the split to the front, in any order, and measures both sides. */
static void divide(const struct splitting *s, struct pen_range *left, struct pen_range *right)
{
    struct pen_ref *ref = s->splitter->layout->ref;
    uint32_t i = s->whole.begin, j = s->whole.end;
    *left = (struct pen_range){.box = empty(), .centroid = empty()};
    *right = *left;
    while (i < j) {
        if (is_left(s, &ref[i])) {
            add_ref(left, &ref[i++]);
        } else {
            struct pen_ref moved = ref[i];
            ref[i] = ref[--j];
            ref[j] = moved;
            add_ref(right, &moved);
        }
    }
    left->begin = s->whole.begin;
    left->end = right->begin = i;
    right->end = s->whole.end;
}

/* The same for triangles of meshes, which keep their order on both sides. Without branches that
 * depend on a triangle. */
static void divide_mesh(const struct splitting *s, struct pen_range *left, struct pen_range *right)
{
    struct pen_ref *ref = s->splitter->layout->ref, *other = s->splitter->other + s->whole.begin;
    uint32_t middle = s->whole.begin, rest = 0;
    for (uint32_t i = s->whole.begin; i < s->whole.end; i++) {
        const struct pen_ref moved = ref[i];
        const bool front = is_left(s, &moved);
        ref[middle] = other[rest] = moved;
        middle += front;
        rest += !front;
    }
    memcpy(ref + middle, other, rest * sizeof *ref);
    *left = measure_mesh(ref, s->whole.begin, middle);
    *right = measure_mesh(ref, middle, s->whole.end);
}

/* Moves the triangles of a part to their places in other[]. */
static void move_part(void *user, uint32_t number)
{
    struct splitting *s = user;
    struct part *part = &s->part[number];
    struct pen_ref *other = s->splitter->other;
    uint32_t left = part->left, right = part->right;
    for (uint32_t i = part_begin(s, number), end = part_end(s, number); i < end; i++) {
        const struct pen_ref moved = s->splitter->layout->ref[i];
        const bool front = is_left(s, &moved);
        other[front ? left : right] = moved;
        left += front;
        right += !front;
    }
    part->on_left = measure_mesh(other, part->left, left);
    part->on_right = measure_mesh(other, part->right, right);
}

static void copy_part(void *user, uint32_t part)
{
    const struct splitting *s = user;
    const uint32_t begin = part_begin(s, part), count = part_end(s, part) - begin;
    memcpy(s->splitter->layout->ref + begin, s->splitter->other + begin,
           count * sizeof *s->splitter->other);
}

/* divide_mesh by all threads; the bins of the parts tell where their triangles go. */
static void share_division(struct splitting *s, struct pen_range *left, struct pen_range *right)
{
    const uint32_t parts = pen_parts_of(s->whole.end - s->whole.begin, PART);
    uint32_t on_left = 0, sum_left = s->whole.begin, sum_right;
    for (uint32_t i = 0; i < parts; i++) {
        const struct bin *bin = s->part[i].bins[s->split.axis].bin;
        s->part[i].left = sum_left + on_left;
        for (int k = 0; k < s->split.bin; k++)
            on_left += bin[k].lanes[PEN_COST_MESHES];
    }
    sum_right = sum_left + on_left;
    *left = (struct pen_range){.box = empty(), .centroid = empty()};
    *right = *left;
    left->begin = s->whole.begin;
    left->end = right->begin = sum_right;
    right->end = s->whole.end;
    for (uint32_t i = 0; i < parts; i++) /* what comes before it and is not on the left */
        s->part[i].right = sum_right + (part_begin(s, i) - s->part[i].left);
    pen_parts_do(s->splitter->layout->pool, parts, move_part, s);
    pen_parts_do(s->splitter->layout->pool, parts, copy_part, s);
    for (uint32_t i = 0; i < parts; i++) {
        merge(left, &s->part[i].on_left);
        merge(right, &s->part[i].on_right);
    }
}

/* Divides the range by the split that was found; without one, in half by number. */
static void divide_range(struct splitting *s, bool mesh, struct pen_range *left,
                         struct pen_range *right)
{
    const struct pen_ref *ref = s->splitter->layout->ref;
    const uint32_t middle = s->whole.begin + (s->whole.end - s->whole.begin) / 2;
    if (s->split.axis < 0) {
        *left = pen_range_measure(ref, s->whole.begin, middle);
        *right = pen_range_measure(ref, middle, s->whole.end);
    } else if (s->part) {
        share_division(s, left, right);
    } else if (mesh) {
        divide_mesh(s, left, right);
    } else {
        divide(s, left, right);
    }
    free(s->part);
}

/* Splits a range in two. If a leaf is cheaper, marks the range as a leaf and returns false. */
bool pen_range_split(const struct pen_splitter *splitter, struct pen_range *r, uint32_t depth,
                     struct pen_range *right)
{
    const bool mesh = is_mesh(r);
    uint32_t count = r->end - r->begin, blocks = 0;
    for (int k = 0; k < CLASSES; k++)
        blocks += (r->lanes[k] + PEN_LANES - 1) / PEN_LANES;
    r->leaf = count <= 1 || (blocks == 1 && (count <= 2 || mesh)); /* two blocks cost more */
    if (r->leaf)
        return false;
    struct splitting s = {.splitter = splitter,
                          .whole = *r,
                          .scale = {bin_scale(r, 0), bin_scale(r, 1), bin_scale(r, 2)},
                          .split = {-1, 0, INFINITY}};
    if (depth < PEN_MAX_DEPTH / 2 && mesh)
        find_split(&s, true);
    else if (depth < PEN_MAX_DEPTH / 2)
        find_split(&s, false);
    float area = pen_half_area(&r->box);
    if (blocks <= BLOCKS_MAX &&
        !(s.split.cost + pen_node_cost * area < pen_leaf_cost(r->lanes) * area)) {
        r->leaf = true;
        return false;
    }
    divide_range(&s, mesh, r, right);
    return true;
}
