/* SPDX-License-Identifier: MIT */
/* Building: the builder of each kind of accelerator, and the statistics of the result. */
#include "accel/internal/test_doors.h"
#include "accel/internal/tree_layout.h"
#include "base/clock.h"

const struct pen_hit pen_after_start = {0, PEN_NO_PRIM, UINT8_MAX};

/* A structure to build. */
struct request {
    const struct pen_prims *prims;
    enum pen_accelerator kind;
    const struct pen_groups *groups; /* for PEN_ACCEL_MANUAL; NULL: none */
    unsigned generic_kinds;
    const enum pen_auto_choice *choice; /* for PEN_ACCEL_AUTO; NULL: the model's choice */
    int threads;                        /* at most; 0: one */
};

/* Fewer primitives are built by one thread, which is as fast. */
enum { PRIMS_FOR_THREADS = 1 << 15 };

/* PEN_ACCEL_NONE: one list of all primitives. */
static bool build_none(struct pen_tree_layout *layout)
{
    return layout->count == 0 || pen_tree_layout_add_leaf(layout, 0, layout->count) != PEN_NO_CHILD;
}

/* PEN_ACCEL_AUTO. The costs are those of the tree, so it is built first. A list is in document
 * order, which the tree's builder has changed, so the layout begins again. */
static bool build_auto(struct pen_tree_layout *layout, const struct request *request,
                       struct pen_accel_stats *stats)
{
    if (!pen_build_sah(layout))
        return false;
    pen_auto_expect(layout, stats->expected);
    stats->choice = request->choice ? *request->choice : pen_auto_choose(stats->expected);
    if (stats->choice != PEN_AUTO_NONE)
        return true;
    pen_tree_layout_release(layout);
    *layout =
        (struct pen_tree_layout){.prims = request->prims, .generic_kinds = request->generic_kinds};
    return pen_tree_layout_init(layout) && build_none(layout);
}

static bool build_layout(struct pen_tree_layout *layout, const struct request *request,
                         struct pen_accel_stats *stats)
{
    switch (request->kind) {
    case PEN_ACCEL_NONE:
        return build_none(layout);
    case PEN_ACCEL_CBR:
        return pen_build_lists(layout, NULL);
    case PEN_ACCEL_MANUAL:
        return pen_build_lists(layout, request->groups);
    case PEN_ACCEL_MEDIAN:
        return pen_build_median(layout);
    case PEN_ACCEL_AUTO:
        break;
    }
    return build_auto(layout, request, stats);
}

static bool build_in(struct pen_thread_pool *pool, const struct request *request,
                     struct pen_arena *arena, struct pen_accel *accel)
{
    const uint32_t meshes = request->kind == PEN_ACCEL_AUTO ? request->prims->mesh_count : 0;
    struct pen_mesh_frame *frames = pen_arena_alloc(arena, meshes, sizeof *frames);
    const bool blocks = frames && meshes > 0 && pen_mesh_frames_make(request->prims, frames);
    struct pen_tree_layout layout = {.pool = pool,
                                     .prims = request->prims,
                                     .generic_kinds = request->generic_kinds,
                                     .frames = blocks ? frames : NULL};
    bool ok = frames && pen_tree_layout_init(&layout) &&
              build_layout(&layout, request, &accel->stats) &&
              pen_accel_pack(&layout, arena, accel);
    if (ok)
        accel->stats.sah_cost = pen_tree_layout_cost(&layout);
    accel->packets = layout.shape == PEN_SHAPE_WIDE && accel->stats.choice == PEN_AUTO_PACKETS;
    pen_tree_layout_release(&layout);
    return ok;
}

static bool build(const struct request *request, struct pen_arena *arena, struct pen_accel *accel)
{
    struct pen_status st; /* without a pool it takes longer */
    struct pen_thread_pool *pool = NULL;
    if (request->threads > 1 && request->prims->count >= PRIMS_FOR_THREADS)
        pool = pen_thread_pool_new(request->threads, &st);
    const bool ok = build_in(pool, request, arena, accel);
    pen_thread_pool_free(pool);
    return ok;
}

static struct pen_accel *build_request(const struct request *request, struct pen_arena *arena,
                                       struct pen_status *st)
{
    if (request->prims->count > PEN_ITEM_INDEX_MAX) {
        pen_fail(st, PEN_TOO_LARGE, "%u primitives; an acceleration structure holds at most %u",
                 request->prims->count, PEN_ITEM_INDEX_MAX);
        return NULL;
    }
    int64_t start = pen_clock_ns();
    size_t before = pen_arena_used(arena);
    struct pen_accel *accel = pen_arena_alloc(arena, 1, sizeof *accel);
    if (accel)
        accel->stats.kind = request->kind;
    if (!accel || !build(request, arena, accel)) {
        pen_fail(st, PEN_NO_MEMORY, "not enough memory for the acceleration structure");
        return NULL;
    }
    accel->stats.bytes = pen_arena_used(arena) - before;
    accel->stats.build_ms = (double)(pen_clock_ns() - start) / 1e6;
    return accel;
}

struct pen_accel *pen_accel_build(const struct pen_prims *prims, enum pen_accelerator kind,
                                  struct pen_arena *arena, struct pen_status *st)
{
    return build_request(&(struct request){.prims = prims, .kind = kind}, arena, st);
}

struct pen_accel *pen_accel_build_threads(const struct pen_prims *prims, enum pen_accelerator kind,
                                          int threads, struct pen_arena *arena,
                                          struct pen_status *st)
{
    const struct request request = {.prims = prims, .kind = kind, .threads = threads};
    return build_request(&request, arena, st);
}

struct pen_accel *pen_accel_build_manual(const struct pen_prims *prims,
                                         const struct pen_groups *groups, struct pen_arena *arena,
                                         struct pen_status *st)
{
    const struct request request = {.prims = prims, .kind = PEN_ACCEL_MANUAL, .groups = groups};
    return build_request(&request, arena, st);
}

struct pen_accel *pen_accel_build_generic(const struct pen_prims *prims, enum pen_accelerator kind,
                                          unsigned generic_kinds, struct pen_arena *arena,
                                          struct pen_status *st)
{
    const enum pen_auto_choice packets = PEN_AUTO_PACKETS;
    const struct request request = {
        .prims = prims, .kind = kind, .generic_kinds = generic_kinds, .choice = &packets};
    return build_request(&request, arena, st);
}

struct pen_accel *pen_accel_build_choice(const struct pen_prims *prims, enum pen_auto_choice choice,
                                         struct pen_arena *arena, struct pen_status *st)
{
    const struct request request = {.prims = prims, .kind = PEN_ACCEL_AUTO, .choice = &choice};
    return build_request(&request, arena, st);
}

const struct pen_accel_stats *pen_accel_get_stats(const struct pen_accel *accel)
{
    return &accel->stats;
}
