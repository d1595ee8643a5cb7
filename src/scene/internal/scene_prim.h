/* SPDX-License-Identifier: MIT */
/* Primitives in scene units: the transforms of enclosing groups, applied once, in double. */
#ifndef PEN_SCENE_INTERNAL_SCENE_PRIM_H
#define PEN_SCENE_INTERNAL_SCENE_PRIM_H

#include "geom/prims.h"
#include "scene/internal/desc_iter.h"

struct pen_scene_prim {
    enum pen_prim_kind kind;
    int material;                         /* index, -1: default */
    const struct pen_transform *moved_by; /* to scene units; NULL: not moved */
    const struct pen_vec3 *own;       /* its vertices before the transforms, in the description */
    const struct pen_mesh_desc *mesh; /* NULL: one primitive. Else all triangles of a mesh: `kind`
                                         is that of triangles; `material` and `from` are not used */
    struct pen_prim_source from; /* its vertices are in the caller's buffer or in the description */
};

/* Transforms a primitive to scene units. `buffer` must have space for its vertices. Mirrors keep
 * the outside outside: for a quadric that needs no work. For a plane, the normal is transformed by
 * the inverse transpose. For a triangle or polygon, the order of its vertices is reversed.
 * Fails: PEN_INVALID, without a JSON Pointer (a quadric whose transform is not a similarity, or a
 * result outside the range of doubles). */
bool pen_scene_prim_make(const struct pen_desc_iter_item *item, struct pen_vec3 *buffer,
                         struct pen_scene_prim *scene_prim, struct pen_status *st);

#endif
