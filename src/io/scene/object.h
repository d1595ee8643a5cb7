/* SPDX-License-Identifier: MIT */
/* The transforms of the groups that contain an object. The reader applies none of them; freezing
 * does, once. The reader refuses transforms that are not invertible, and quadrics under transforms
 * that are not similarities. Also the area test of three points, for triangles and for planes in
 * XML. */
#ifndef PEN_IO_SCENE_OBJECT_H
#define PEN_IO_SCENE_OBJECT_H

#include "io/scene/reader.h"
#include "math/transform.h"

struct pen_transform_chain {
    struct pen_transform f; /* all of them, composed */
    bool similar;           /* f is a similarity */
    /* The outermost transform that is not a similarity, or with which the composition is no longer
     * one, for error messages. stretch_at is its place, or NULL if there is none. */
    const struct pen_place *stretch_at;
    struct pen_transform stretch;
    bool invalid; /* an invalid transform was reported: objects inside are not checked */
};

/* Reads a group's `transform` and refuses a matrix that is not invertible. */
bool pen_group_transform_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                              struct pen_transform *f);

/* Appends f, the transform at `at`, as the innermost of the chain; `at` must outlive the chain.
 * Fails: returns false if the composition is not invertible or has a number beyond PEN_NUMBER_MAX.
 */
bool pen_transform_chain_add(struct pen_reader *r, const struct pen_place *at,
                             const struct pen_transform *f, struct pen_transform_chain *chain);

/* Refuses the quadric at `at` unless the chain is a similarity. `what` is its name ("sphere"). */
bool pen_transform_chain_check_quadric(struct pen_reader *r, const struct pen_place *at,
                                       const char *what, const struct pen_transform_chain *chain);

/* Reads a mesh, whose material has been read into *object.
 * Fails: also as pen_models_read. */
bool pen_mesh_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                   struct pen_object_desc *object);

/* Whether three points are not on one line, decided exactly. */
bool pen_points_have_area(const struct pen_vec3 v[3]);

#endif
