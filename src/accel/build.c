/* SPDX-License-Identifier: MIT */
/* Building: which builder makes which kind of tree, and what it says about itself. */
#include "pen/base/clock.h"
#include "plan.h"

const struct pen_hit pen_after_start = {0, PEN_NO_PRIM, UINT8_MAX};

static float half_area(const struct pen_node *node, int lane)
{
    float x = node->plane[3][lane] - node->plane[0][lane];
    float y = node->plane[4][lane] - node->plane[1][lane];
    float z = node->plane[5][lane] - node->plane[2][lane];
    return x >= 0 ? x * y + y * z + z * x : 0;
}

static float leaf_cost(const struct pen_plan *plan, uint32_t number)
{
    struct pen_leaf leaf = ((const struct pen_leaf *)plan->leaves.data)[number];
    uint32_t n[PEN_BLOCK_FINITE_COUNT] = {0};
    for (uint32_t i = leaf.begin; i < leaf.begin + leaf.count; i++)
        n[plan->ref[i].kind]++;
    return pen_leaf_cost(n);
}

/* Expected tests for a random ray that meets the root's box. */
static double sah_cost(const struct pen_plan *plan)
{
    const struct pen_node *node = plan->nodes.data;
    if (plan->nodes.count == 0)
        return plan->leaves.count > 0 ? (double)leaf_cost(plan, 0) : 0;
    struct pen_node all = node[0];
    for (int a = 0; a < 3; a++) {
        for (int lane = 1; lane < PEN_WIDE; lane++) {
            float *lo = all.plane[a], *hi = all.plane[3 + a];
            lo[0] = lo[lane] < lo[0] ? lo[lane] : lo[0];
            hi[0] = hi[lane] > hi[0] ? hi[lane] : hi[0];
        }
    }
    double root = (double)half_area(&all, 0), sum = (double)pen_node_cost;
    for (uint32_t i = 0; i < plan->nodes.count && root > 0; i++) {
        for (int lane = 0; lane < PEN_WIDE; lane++) {
            uint32_t child = node[i].child[lane];
            float cost = child == PEN_NO_CHILD    ? 0
                         : child & PEN_CHILD_LEAF ? leaf_cost(plan, child & ~PEN_CHILD_LEAF)
                                                  : pen_node_cost;
            sum += (double)(half_area(&node[i], lane) * cost) / root;
        }
    }
    return sum;
}

/* PEN_ACCEL_NONE: one list of all. */
static bool build_list(struct pen_plan *plan)
{
    return plan->count == 0 || pen_plan_leaf(plan, 0, plan->count) != PEN_NO_CHILD;
}

static bool build(const struct pen_prims *prims, struct pen_arena *arena, struct pen_accel *accel)
{
    struct pen_plan plan;
    bool ok = pen_plan_init(&plan, prims);
    if (ok)
        ok = accel->stats.kind == PEN_ACCEL_NONE ? build_list(&plan) : pen_build_sah(&plan);
    if (ok)
        ok = pen_pack(&plan, arena, accel);
    if (ok)
        accel->stats.sah_cost = sah_cost(&plan) + plan.infinite;
    pen_plan_release(&plan);
    return ok;
}

struct pen_accel *pen_accel_build(const struct pen_prims *prims, enum pen_accelerator kind,
                                  struct pen_arena *arena, struct pen_status *st)
{
    if (kind != PEN_ACCEL_NONE && kind != PEN_ACCEL_AUTO) {
        pen_fail(st, PEN_UNSUPPORTED, "this accelerator is known, not supported yet");
        return NULL;
    }
    int64_t start = pen_clock_ns();
    size_t before = pen_arena_used(arena);
    struct pen_accel *accel = pen_arena_alloc(arena, 1, sizeof *accel);
    if (accel)
        accel->stats.kind = kind;
    if (!accel || !build(prims, arena, accel)) {
        pen_fail(st, PEN_NO_MEMORY, "not enough memory for the acceleration structure");
        return NULL;
    }
    accel->stats.bytes = pen_arena_used(arena) - before;
    accel->stats.build_ms = (double)(pen_clock_ns() - start) / 1e6;
    return accel;
}

const struct pen_accel_stats *pen_accel_get_stats(const struct pen_accel *accel)
{
    return &accel->stats;
}
