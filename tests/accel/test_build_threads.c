/* SPDX-License-Identifier: MIT */
/* A tree is the same, byte for byte, whatever the number of threads that build it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accel/internal/structure.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

enum {
    SIDE = 240, /* of a grid of squares, two triangles each */
    HILLS = 2 * SIDE * SIDE,
    SOUP = 30000,
    STACK = 3000, /* equal triangles, which no plane divides */
    SPHERES = 500
};

static float hill_vertex[3 * (SIDE + 1) * (SIDE + 1)], soup_vertex[9 * (SOUP + STACK)];
static uint32_t hill_corner[3 * HILLS], soup_corner[3 * (SOUP + STACK)];
static struct pen_sphere sphere[SPHERES];
static struct pen_prim_ref ref[SPHERES + 2];

/* The spheres are beside the meshes, so that large ranges have triangles of meshes alone. */
static struct pen_mesh mesh[2] = {{.vertex = hill_vertex,
                                   .corner = hill_corner,
                                   .unit = 0.5,
                                   .count = HILLS,
                                   .slot = 0,
                                   .slots = 1},
                                  {.vertex = soup_vertex,
                                   .corner = soup_corner,
                                   .shift = {0.1, -0.2, 0.3},
                                   .unit = 1,
                                   .first = HILLS + SPHERES,
                                   .count = SOUP + STACK,
                                   .slot = SPHERES + 1,
                                   .slots = 1,
                                   .index = HILLS}};

static struct pen_prims prims;

static void make_hills(struct random *r)
{
    float *v = hill_vertex;
    uint32_t *c = hill_corner;
    for (int i = 0; i <= SIDE; i++)
        for (int j = 0; j <= SIDE; j++) {
            *v++ = (float)i / SIDE;
            *v++ = (float)random_in(r, 0, 0.02);
            *v++ = (float)j / SIDE;
        }
    for (uint32_t i = 0; i < SIDE; i++)
        for (uint32_t j = 0; j < SIDE; j++) {
            const uint32_t a = i * (SIDE + 1) + j, b = a + SIDE + 1;
            const uint32_t corners[6] = {a, a + 1, b, a + 1, b + 1, b};
            memcpy(c, corners, sizeof corners);
            c += 6;
        }
}

static void make_soup(struct random *r)
{
    for (uint32_t t = 0; t < SOUP; t++)
        for (uint32_t k = 0; k < 9; k++)
            soup_vertex[9 * t + k] =
                (float)(k < 3 ? random_in(r, -1, 1)
                              : (double)soup_vertex[9 * t + k % 3] + random_in(r, -0.02, 0.02));
    for (uint32_t t = SOUP; t < SOUP + STACK; t++)
        memcpy(&soup_vertex[9 * t], soup_vertex, 9 * sizeof *soup_vertex);
    for (uint32_t i = 0; i < 3 * (SOUP + STACK); i++)
        soup_corner[i] = i;
}

static void make_prims(void)
{
    struct random r = random_begin(53);
    make_hills(&r);
    make_soup(&r);
    for (uint32_t i = 0; i < SPHERES; i++) {
        const struct pen_vec3 center =
            pen_vec3(random_in(&r, 1, 2), random_in(&r, -1, 1), random_in(&r, -1, 1));
        ck_assert(pen_sphere_make(&sphere[i], center, 0.01));
        ref[i + 1] = (struct pen_prim_ref){.kind = PEN_PRIM_SPHERE, .index = i & 0xfffffff};
    }
    for (int i = 0; i < 2; i++)
        pen_mesh_measure(&mesh[i]);
    prims = (struct pen_prims){.count = HILLS + SPHERES + SOUP + STACK,
                               .mesh_count = 2,
                               .mesh = mesh,
                               .ref = ref,
                               .sphere = sphere};
    prims.kind_count[PEN_PRIM_SPHERE] = SPHERES;
}

static void same_block(const struct pen_accel *a, const struct pen_accel *b, uint32_t block)
{
    ck_assert_mem_eq(&a->mesh_blocks[block], &b->mesh_blocks[block], sizeof *a->mesh_blocks);
}

static void same_items(const struct pen_accel *a, const struct pen_accel *b, uint32_t item)
{
    for (;; item++) {
        const uint32_t index = PEN_ITEM_INDEX(a->items[item]);
        ck_assert_uint_eq(a->items[item], b->items[item]);
        if (PEN_ITEM_KIND(a->items[item]) == PEN_BLOCK_MESH)
            same_block(a, b, index);
        else if (PEN_ITEM_KIND(a->items[item]) == PEN_BLOCK_SPHERES)
            ck_assert_mem_eq(&a->spheres[index], &b->spheres[index], sizeof *a->spheres);
        if (a->items[item] & PEN_ITEM_LAST)
            return;
    }
}

static void same_tree(const struct pen_accel *a, const struct pen_accel *b)
{
    ck_assert_uint_eq(a->stats.nodes, b->stats.nodes);
    ck_assert_uint_eq(a->stats.depth, b->stats.depth);
    ck_assert_uint_eq(a->stats.leaves, b->stats.leaves);
    ck_assert_uint_eq(a->stats.bytes, b->stats.bytes);
    ck_assert(a->stats.sah_cost == b->stats.sah_cost && a->extent == b->extent &&
              a->scale == b->scale && a->mixed == b->mixed && a->packets == b->packets);
    ck_assert_mem_eq(a->nodes, b->nodes, a->stats.nodes * sizeof *a->nodes);
    ck_assert_mem_eq(a->mesh_frames, b->mesh_frames, 2 * sizeof *a->mesh_frames);
    ck_assert_mem_eq(a->prim_box, b->prim_box, (SPHERES + 2) * sizeof *a->prim_box);
    for (uint32_t i = 0; i < 8 * a->stats.nodes; i++) {
        const uint32_t child = a->nodes[i / 8].child[i % 8], rest = child & ~PEN_CHILD_LEAF;
        if (!(child & PEN_CHILD_LEAF))
            continue;
        if (!(rest & PEN_LEAF_BLOCKS)) {
            same_items(a, b, rest);
            continue;
        }
        for (uint32_t k = 0; k <= rest % PEN_LEAF_BLOCKS_MAX; k++)
            same_block(a, b, (rest & ~PEN_LEAF_BLOCKS) / PEN_LEAF_BLOCKS_MAX + k);
    }
}

START_TEST(test_build_threads__make_the_same_tree)
{
    static const int counts[] = {1, 2, 3, 8};
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_status st;
    make_prims();
    const struct pen_accel *one = pen_accel_build(&prims, PEN_ACCEL_AUTO, arena, &st);
    ck_assert(one && one->mesh_blocks && one->spheres && one->shape == PEN_SHAPE_WIDE);
    for (int i = 0; i < 4; i++) {
        const struct pen_accel *tree =
            pen_accel_build_threads(&prims, PEN_ACCEL_AUTO, counts[i], arena, &st);
        ck_assert(tree);
        same_tree(one, tree);
    }
    pen_arena_free(arena);
}
END_TEST

/* Each triangle is in one lane, in a leaf with its box around it. */
START_TEST(test_build_threads__holds_each_triangle_once)
{
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_status st;
    make_prims();
    const struct pen_accel *tree = pen_accel_build_threads(&prims, PEN_ACCEL_AUTO, 3, arena, &st);
    uint8_t *seen = calloc(prims.count, 1);
    ck_assert(tree && seen);
    for (uint32_t i = 0; i < 8 * tree->stats.nodes; i++) {
        const struct pen_node *node = &tree->nodes[i / 8];
        const uint32_t child = node->child[i % 8], rest = child & ~PEN_CHILD_LEAF;
        if (!(child & PEN_CHILD_LEAF) || !(rest & PEN_LEAF_BLOCKS))
            continue;
        const uint32_t first = (rest & ~PEN_LEAF_BLOCKS) / PEN_LEAF_BLOCKS_MAX;
        for (uint32_t k = 0; k < 4 * (rest % PEN_LEAF_BLOCKS_MAX + 1); k++) {
            const uint32_t prim = tree->mesh_blocks[first + k / 4].prim[k % 4];
            if (prim == PEN_NO_PRIM)
                continue;
            const struct pen_box box = pen_prim_bounds(&prims, prim);
            const double lo[3] = {box.lo.x, box.lo.y, box.lo.z};
            const double hi[3] = {box.hi.x, box.hi.y, box.hi.z};
            for (int axis = 0; axis < 3; axis++)
                ck_assert((double)node->plane[axis][i % 8] <= lo[axis] &&
                          (double)node->plane[3 + axis][i % 8] >= hi[axis]);
            ck_assert_int_eq(seen[prim]++, 0);
        }
    }
    uint32_t count = 0;
    for (uint32_t i = 0; i < prims.count; i++)
        count += seen[i];
    ck_assert_uint_ge(count, HILLS + SOUP); /* others are in leaves with spheres */
    free(seen);
    pen_arena_free(arena);
}
END_TEST

/* Without memory there is an error, or the same tree, which takes longer. */
START_TEST(test_build_threads__survives_failed_allocations)
{
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_status st = {.code = PEN_OK};
    make_prims();
    /* By threads too, so that the allocating functions have been found before one is refused. */
    const struct pen_accel *one = pen_accel_build_threads(&prims, PEN_ACCEL_AUTO, 3, arena, &st);
    bool refused = true;
    ck_assert(one);
    alloc_spare_new_threads();
    for (long n = 0; refused; n += 1 + n / 3) {
        struct pen_arena *own = pen_arena_new(0);
        alloc_fail_after(n);
        const struct pen_accel *tree = pen_accel_build_threads(&prims, PEN_ACCEL_AUTO, 3, own, &st);
        refused = alloc_succeed();
        ck_assert(tree || (refused && st.code == PEN_NO_MEMORY));
        if (tree)
            same_tree(one, tree);
        pen_arena_free(own);
    }
    pen_arena_free(arena);
}
END_TEST

PEN_SUITE("build_threads", test_build_threads__make_the_same_tree,
          test_build_threads__holds_each_triangle_once,
          test_build_threads__survives_failed_allocations)
