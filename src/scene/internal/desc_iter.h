/* SPDX-License-Identifier: MIT */
/* The primitives of a description in the order of the document, depth first, each with the composed
 * transform of the groups around it. The walk keeps its own stack: a document cannot make it
 * overflow the thread's. */
#ifndef PEN_SCENE_INTERNAL_DESC_ITER_H
#define PEN_SCENE_INTERNAL_DESC_ITER_H

#include "scene/desc.h"

struct pen_desc_iter_level {
    const struct pen_object_desc *objects;
    uint32_t count, next;
    bool moved; /* `transform` is not the identity */
    struct pen_transform transform;
    bool similar; /* the transform may place quadrics, and scales them by `scale` */
    double scale;
};

struct pen_desc_iter {
    struct pen_desc_iter_level *levels;
    uint32_t depth, capacity;
};

/* What the walk stands at. */
struct pen_desc_iter_item {
    const struct pen_object_desc *object; /* never a group */
    bool moved;
    const struct pen_transform *transform; /* to scene units; valid until the next step */
    bool similar;                          /* it may place quadrics, and scales them by `scale` */
    double scale;
};

/* Owns: release with pen_desc_iter_release, also after a failure. Fails: PEN_NO_MEMORY. */
bool pen_desc_iter_init(struct pen_desc_iter *iter, const struct pen_scene_desc *desc,
                        struct pen_status *st);
void pen_desc_iter_release(struct pen_desc_iter *iter);

enum pen_desc_iter_step { PEN_ITER_PRIMITIVE, PEN_ITER_END, PEN_ITER_FAILED };

/* Goes to the next primitive. Fails: PEN_NO_MEMORY. */
enum pen_desc_iter_step pen_desc_iter_next(struct pen_desc_iter *iter,
                                           struct pen_desc_iter_item *item, struct pen_status *st);

/* The JSON Pointer of the primitive the walk stands at: "/objects/3/objects/0". Cut if too long. */
void pen_desc_iter_pointer(const struct pen_desc_iter *iter, char *out, size_t bytes);

#endif
