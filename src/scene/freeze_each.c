/* SPDX-License-Identifier: MIT */
/* One pass over the primitives of a description, each transformed to scene units. Freezing makes
 * two: the first counts and finds the local frame, the second fills the typed arrays. */
#include <stdlib.h>

#include "scene/internal/freeze.h"

static bool reserve_buffer(struct pen_freezer *f, const struct pen_desc_iter_item *at)
{
    enum pen_object_kind kind = at->object->kind;
    bool loop = kind == PEN_OBJECT_TRIANGLE || kind == PEN_OBJECT_POLYGON;
    uint32_t count = loop && at->moved ? at->object->u.polygon.count : 0;
    if (count <= f->buffer_capacity)
        return true;
    struct pen_vec3 *buffer = realloc(f->buffer, count * sizeof *buffer);
    if (!buffer)
        return pen_freeze_no_memory(f);
    f->buffer = buffer;
    f->buffer_capacity = count;
    return true;
}

static bool each(struct pen_freezer *f, bool left_out, pen_freeze_primitive *fn, void *user)
{
    struct pen_desc_iter iter;
    if (!pen_desc_iter_init(&iter, f->desc, f->st))
        return false;
    iter.left_out = left_out;
    struct pen_desc_iter_item at;
    struct pen_scene_prim scene_prim;
    enum pen_desc_iter_step step;
    while ((step = pen_desc_iter_next(&iter, &at, f->st)) == PEN_ITER_PRIMITIVE) {
        if (!reserve_buffer(f, &at))
            break;
        if (!pen_scene_prim_make(&at, f->buffer, &scene_prim, f->st) || !fn(f, &scene_prim, user)) {
            pen_desc_iter_pointer(&iter, f->st->at, sizeof f->st->at);
            break;
        }
    }
    pen_desc_iter_release(&iter);
    return step == PEN_ITER_END;
}

bool pen_freeze_each(struct pen_freezer *f, pen_freeze_primitive *fn, void *user)
{
    return each(f, false, fn, user);
}

bool pen_freeze_each_left_out(struct pen_freezer *f, pen_freeze_primitive *fn, void *user)
{
    return each(f, true, fn, user);
}
