/* SPDX-License-Identifier: MIT */
/* The iterator's stack has a level for each group that contains the current object, the innermost
 * last. Transforms are composed in double, outermost first. If no group has a transform, nothing is
 * multiplied, hence nothing rounded. */
#include "scene/internal/desc_iter.h"

#include <stdio.h>
#include <stdlib.h>

static bool push(struct pen_desc_iter *iter, const struct pen_desc_iter_level *level,
                 struct pen_status *st)
{
    if (iter->depth == iter->capacity) {
        uint32_t capacity = iter->capacity ? 2 * iter->capacity : 16;
        struct pen_desc_iter_level *levels = realloc(iter->levels, capacity * sizeof *levels);
        if (!levels)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory while reading the groups");
        iter->levels = levels;
        iter->capacity = capacity;
    }
    iter->levels[iter->depth++] = *level;
    return true;
}

bool pen_desc_iter_init(struct pen_desc_iter *iter, const struct pen_scene_desc *desc,
                        struct pen_status *st)
{
    *iter = (struct pen_desc_iter){0};
    struct pen_desc_iter_level level = {
        .objects = desc->objects,
        .count = desc->object_count,
        .similar = true,
        .scale = 1,
    };
    return push(iter, &level, st);
}

void pen_desc_iter_release(struct pen_desc_iter *iter)
{
    free(iter->levels);
    *iter = (struct pen_desc_iter){0};
}

static struct pen_desc_iter_level enter(const struct pen_desc_iter_level *outer,
                                        const struct pen_object_desc *group)
{
    struct pen_desc_iter_level inner = *outer;
    inner.objects = group->u.group.objects;
    inner.count = group->u.group.count;
    inner.next = 0;
    if (!group->u.group.has_transform)
        return inner;
    const struct pen_transform *part = &group->u.group.transform;
    inner.moved = true;
    inner.transform = outer->moved ? pen_transform_compose(&outer->transform, part) : *part;
    inner.similar = pen_transform_similarity(&inner.transform, &inner.scale);
    return inner;
}

enum pen_desc_iter_step pen_desc_iter_next(struct pen_desc_iter *iter,
                                           struct pen_desc_iter_item *item, struct pen_status *st)
{
    while (iter->depth > 0) {
        struct pen_desc_iter_level *level = &iter->levels[iter->depth - 1];
        if (level->next == level->count) {
            iter->depth--;
            continue;
        }
        const struct pen_object_desc *object = &level->objects[level->next++];
        if (object->kind == PEN_OBJECT_GROUP) {
            struct pen_desc_iter_level inner = enter(level, object);
            if (!push(iter, &inner, st))
                return PEN_ITER_FAILED;
            continue;
        }
        if (object->left_out != iter->left_out)
            continue;
        *item = (struct pen_desc_iter_item){object, level->moved, &level->transform, level->similar,
                                            level->scale};
        return PEN_ITER_PRIMITIVE;
    }
    return PEN_ITER_END;
}

static void add_meshes(const struct pen_object_desc *objects, uint32_t count,
                       struct pen_mesh_totals *totals)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *o = &objects[i];
        if (o->kind == PEN_OBJECT_GROUP) {
            add_meshes(o->u.group.objects, o->u.group.count, totals);
        } else if (o->kind == PEN_OBJECT_MESH) {
            totals->meshes++;
            totals->triangles += o->u.mesh->triangle_count;
        }
    }
}

struct pen_mesh_totals pen_desc_meshes(const struct pen_scene_desc *desc)
{
    struct pen_mesh_totals totals = {0};
    add_meshes(desc->objects, desc->object_count, &totals);
    return totals;
}

void pen_desc_iter_pointer(const struct pen_desc_iter *iter, char *out, size_t bytes)
{
    size_t used = 0;
    out[0] = 0;
    for (uint32_t i = 0; i < iter->depth && used < bytes; i++)
        used += (size_t)snprintf(out + used, bytes - used, "/objects/%u", iter->levels[i].next - 1);
}
