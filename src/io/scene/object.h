/* SPDX-License-Identifier: MIT */
/* The transforms above an object, as the reader needs them: not to move anything (that is done
 * once, when the scene is frozen), but to refuse what cannot be moved. */
#ifndef PEN_IO_SCENE_OBJECT_H
#define PEN_IO_SCENE_OBJECT_H

#include "io/scene/reader.h"
#include "math/transform.h"

struct pen_chain {
    struct pen_transform f; /* all of them, composed */
    bool similar;           /* f is a similarity */
    /* The outermost transform with which it is none any more, or that is none by itself, and its
     * place; NULL if there is none such. */
    const struct pen_place *blame;
    struct pen_transform blamed;
    bool broken; /* one of them is invalid and reported: nothing below is blamed for it */
};

/* Reads a group's `transform`, which is then invertible. */
bool pen_group_transform_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                              struct pen_transform *f);

/* Puts f, the transform at `at`, inside the chain; `at` must outlive it. Fails if what they make
 * together is not invertible or too large. */
bool pen_chain_add(struct pen_reader *r, const struct pen_place *at, const struct pen_transform *f,
                   struct pen_chain *chain);

/* Refuses the quadric at `at` ("sphere") unless the chain is a similarity. */
bool pen_chain_takes_quadric(struct pen_reader *r, const struct pen_place *at, const char *what,
                             const struct pen_chain *chain);

/* Whether the corner's three points are not on one line, as far as rounding lets one tell. */
bool pen_corner_has_area(const struct pen_vec3 v[3]);

/* The normal of such a corner, on the side from which it runs counter-clockwise; of no special
 * length, but near 1 whatever the size of the corner. */
struct pen_vec3 pen_corner_normal(const struct pen_vec3 v[3]);

#endif
