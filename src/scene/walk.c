/* SPDX-License-Identifier: MIT */
/* The walk over groups: a stack of levels, the innermost group last. Transforms are composed in
 * double, outermost first; where no group has one, nothing is multiplied and nothing rounded. */
#include "scene/internal/walk.h"

#include <stdio.h>
#include <stdlib.h>

static bool push(struct pen_walk *walk, const struct pen_walk_level *level, struct pen_status *st)
{
    if (walk->depth == walk->capacity) {
        uint32_t capacity = walk->capacity ? 2 * walk->capacity : 16;
        struct pen_walk_level *levels = realloc(walk->levels, capacity * sizeof *levels);
        if (!levels)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory while walking the groups");
        walk->levels = levels;
        walk->capacity = capacity;
    }
    walk->levels[walk->depth++] = *level;
    return true;
}

bool pen_walk_init(struct pen_walk *walk, const struct pen_scene_desc *desc, struct pen_status *st)
{
    *walk = (struct pen_walk){0};
    struct pen_walk_level level = {
        .objects = desc->objects,
        .count = desc->object_count,
        .similar = true,
        .scale = 1,
    };
    return push(walk, &level, st);
}

void pen_walk_release(struct pen_walk *walk)
{
    free(walk->levels);
    *walk = (struct pen_walk){0};
}

static struct pen_walk_level enter(const struct pen_walk_level *outer,
                                   const struct pen_object_desc *group)
{
    struct pen_walk_level inner = *outer;
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

enum pen_walk_step pen_walk_next(struct pen_walk *walk, struct pen_walk_primitive *body,
                                 struct pen_status *st)
{
    while (walk->depth > 0) {
        struct pen_walk_level *level = &walk->levels[walk->depth - 1];
        if (level->next == level->count) {
            walk->depth--;
            continue;
        }
        const struct pen_object_desc *object = &level->objects[level->next++];
        if (object->kind == PEN_OBJECT_GROUP) {
            struct pen_walk_level inner = enter(level, object);
            if (!push(walk, &inner, st))
                return PEN_WALK_FAILED;
            continue;
        }
        *body = (struct pen_walk_primitive){object, level->moved, &level->transform, level->similar,
                                            level->scale};
        return PEN_WALK_BODY;
    }
    return PEN_WALK_END;
}

void pen_walk_pointer(const struct pen_walk *walk, char *out, size_t bytes)
{
    size_t used = 0;
    out[0] = 0;
    for (uint32_t i = 0; i < walk->depth && used < bytes; i++)
        used += (size_t)snprintf(out + used, bytes - used, "/objects/%u", walk->levels[i].next - 1);
}
