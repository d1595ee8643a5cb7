/* SPDX-License-Identifier: MIT */
/* The groups of a document as ranges of primitive numbers, for the accelerator `manual`. Primitives
 * are numbered depth first, so the primitives of a group are a range. A group without primitives is
 * left out. The iterator gives the path to each primitive; groups begin and end where it changes.
 */
#include <stdlib.h>

#include "scene/internal/freeze.h"

/* A group that contains the current primitive. It is identified by its position in the enclosing
 * group: the iterator's `next` at that level. */
struct open_group {
    uint32_t next;  /* the iterator's `next` at the level of the enclosing group */
    uint32_t range; /* index into gatherer.range */
};

struct gatherer {
    struct pen_group_range *range; /* in the order in which groups open */
    uint32_t count, capacity;
    struct open_group *open; /* the outermost first */
    uint32_t depth, depth_capacity;
};

static bool open_group(struct gatherer *g, uint32_t next, uint32_t prim)
{
    if (g->count == g->capacity) {
        uint32_t capacity = g->capacity ? 2 * g->capacity : 64;
        struct pen_group_range *range = realloc(g->range, capacity * sizeof *range);
        if (!range)
            return false;
        g->range = range;
        g->capacity = capacity;
    }
    if (g->depth == g->depth_capacity) {
        uint32_t capacity = g->depth_capacity ? 2 * g->depth_capacity : 16;
        struct open_group *open = realloc(g->open, capacity * sizeof *open);
        if (!open)
            return false;
        g->open = open;
        g->depth_capacity = capacity;
    }
    g->open[g->depth++] = (struct open_group){next, g->count};
    g->range[g->count++].begin = prim;
    return true;
}

static void close_groups(struct gatherer *g, uint32_t depth, uint32_t prim)
{
    while (g->depth > depth)
        g->range[g->open[--g->depth].range].end = prim;
}

/* Closes the groups that do not contain primitive number `prim`, and opens those whose first
 * primitive it is. */
static bool update_open_groups(struct gatherer *g, const struct pen_desc_iter *iter, uint32_t prim)
{
    uint32_t same = 0;
    while (same < g->depth && same + 1 < iter->depth &&
           g->open[same].next == iter->levels[same].next)
        same++;
    close_groups(g, same, prim);
    for (uint32_t level = same; level + 1 < iter->depth; level++) {
        if (!open_group(g, iter->levels[level].next, prim))
            return false;
    }
    return true;
}

static bool gather(struct pen_freezer *f, struct gatherer *g)
{
    struct pen_desc_iter iter;
    struct pen_desc_iter_item at;
    enum pen_desc_iter_step step;
    uint32_t prim = 0;
    if (!pen_desc_iter_init(&iter, f->desc, f->st))
        return false;
    while ((step = pen_desc_iter_next(&iter, &at, f->st)) == PEN_ITER_PRIMITIVE) {
        if (!update_open_groups(g, &iter, prim)) {
            pen_freeze_no_memory(f);
            break;
        }
        prim += at.object->kind == PEN_OBJECT_MESH ? at.object->u.mesh->triangle_count : 1;
    }
    close_groups(g, 0, prim);
    pen_desc_iter_release(&iter);
    return step == PEN_ITER_END;
}

struct pen_accel *pen_freeze_manual(struct pen_freezer *f)
{
    struct gatherer g = {0};
    struct pen_accel *accel = NULL;
    if (gather(f, &g)) {
        struct pen_groups groups = {g.range, g.count};
        accel = pen_accel_build_manual(&f->scene->prims, &groups, f->scene->arena, f->st);
    }
    free(g.range);
    free(g.open);
    return accel;
}
