/* SPDX-License-Identifier: MIT */
/* An iterator over the primitives of a description in document order, depth first, each with the
 * composed transform of its enclosing groups. Its own stack is on the heap, so a deeply nested
 * document cannot overflow the thread's stack. */
#ifndef PEN_SCENE_INTERNAL_DESC_ITER_H
#define PEN_SCENE_INTERNAL_DESC_ITER_H

#include "scene/desc.h"

struct pen_desc_iter_level {
    const struct pen_object_desc *objects;
    uint32_t count, next;
    bool moved; /* false: no enclosing group has a transform, and `transform` is not set */
    struct pen_transform transform;
    bool similar; /* `transform` is a similarity, which quadrics require; it scales by `scale` */
    double scale;
};

struct pen_desc_iter {
    struct pen_desc_iter_level *levels;
    uint32_t depth, capacity;
    bool left_out; /* iterates over objects that are left out (struct pen_object_desc) instead of
                      primitives */
};

/* A primitive of the iteration. */
struct pen_desc_iter_item {
    const struct pen_object_desc *object; /* never a group */
    bool moved;
    const struct pen_transform *transform; /* to scene units; valid until the next step */
    bool similar;                          /* as in pen_desc_iter_level */
    double scale;
};

/* Begins an iteration.
 * Owns: release with pen_desc_iter_release, also after a failure.
 * Fails: PEN_NO_MEMORY. */
bool pen_desc_iter_init(struct pen_desc_iter *iter, const struct pen_scene_desc *desc,
                        struct pen_status *st);
void pen_desc_iter_release(struct pen_desc_iter *iter);

enum pen_desc_iter_step { PEN_ITER_PRIMITIVE, PEN_ITER_END, PEN_ITER_FAILED };

/* Steps to the next primitive.
 * Fails: PEN_NO_MEMORY. */
enum pen_desc_iter_step pen_desc_iter_next(struct pen_desc_iter *iter,
                                           struct pen_desc_iter_item *item, struct pen_status *st);

/* Writes the JSON Pointer of the current primitive: "/objects/3/objects/0". Truncates it if it is
 * too long. */
void pen_desc_iter_pointer(const struct pen_desc_iter *iter, char *out, size_t bytes);

#endif
