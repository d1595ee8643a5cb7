/* SPDX-License-Identifier: MIT */
/* Building: which builder makes which kind of accelerator, and the statistics of what it built. */
#include "accel/internal/build_generic.h"
#include "accel/internal/tree_layout.h"
#include "base/clock.h"

const struct pen_hit pen_after_start = {0, PEN_NO_PRIM, UINT8_MAX};

/* PEN_ACCEL_NONE: one list of all primitives. */
static bool build_none(struct pen_tree_layout *layout)
{
    return layout->count == 0 || pen_tree_layout_add_leaf(layout, 0, layout->count) != PEN_NO_CHILD;
}

static bool build_layout(struct pen_tree_layout *layout, enum pen_accelerator kind,
                         const struct pen_groups *groups)
{
    switch (kind) {
    case PEN_ACCEL_NONE:
        return build_none(layout);
    case PEN_ACCEL_CBR:
        return pen_build_lists(layout, NULL);
    case PEN_ACCEL_MANUAL:
        return pen_build_lists(layout, groups);
    case PEN_ACCEL_MEDIAN:
        return pen_build_median(layout);
    case PEN_ACCEL_AUTO:
        break;
    }
    return pen_build_sah(layout);
}

static bool build(const struct pen_prims *prims, const struct pen_groups *groups,
                  unsigned generic_kinds, struct pen_arena *arena, struct pen_accel *accel)
{
    struct pen_tree_layout layout;
    bool ok = pen_tree_layout_init(&layout, prims, generic_kinds) &&
              build_layout(&layout, accel->stats.kind, groups) &&
              pen_accel_pack(&layout, arena, accel);
    if (ok)
        accel->stats.sah_cost = pen_tree_layout_cost(&layout);
    pen_tree_layout_release(&layout);
    return ok;
}

static struct pen_accel *build_kind(const struct pen_prims *prims, enum pen_accelerator kind,
                                    const struct pen_groups *groups, unsigned generic_kinds,
                                    struct pen_arena *arena, struct pen_status *st)
{
    if (prims->count > PEN_ITEM_INDEX_MAX) {
        pen_fail(st, PEN_TOO_LARGE, "%u primitives; an acceleration structure holds at most %u",
                 prims->count, PEN_ITEM_INDEX_MAX);
        return NULL;
    }
    int64_t start = pen_clock_ns();
    size_t before = pen_arena_used(arena);
    struct pen_accel *accel = pen_arena_alloc(arena, 1, sizeof *accel);
    if (accel)
        accel->stats.kind = kind;
    if (!accel || !build(prims, groups, generic_kinds, arena, accel)) {
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
    return build_kind(prims, kind, NULL, 0, arena, st);
}

struct pen_accel *pen_accel_build_manual(const struct pen_prims *prims,
                                         const struct pen_groups *groups, struct pen_arena *arena,
                                         struct pen_status *st)
{
    return build_kind(prims, PEN_ACCEL_MANUAL, groups, 0, arena, st);
}

struct pen_accel *pen_accel_build_generic(const struct pen_prims *prims, enum pen_accelerator kind,
                                          unsigned generic_kinds, struct pen_arena *arena,
                                          struct pen_status *st)
{
    return build_kind(prims, kind, NULL, generic_kinds, arena, st);
}

const struct pen_accel_stats *pen_accel_get_stats(const struct pen_accel *accel)
{
    return &accel->stats;
}
