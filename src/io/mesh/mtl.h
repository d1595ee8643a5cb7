/* SPDX-License-Identifier: MIT */
/* The materials of an OBJ file, from its MTL files. */
#ifndef PEN_IO_MESH_MTL_H
#define PEN_IO_MESH_MTL_H

#include "io/mesh/build.h"

enum { MTL_LIBRARIES = 16 };

struct pen_mtl_material {
    const char *name; /* in the text of a library */
    size_t length;
    uint32_t used; /* its place in the model, + 1; 0: no face uses it yet */
    struct pen_model_material is;
};

/* {0} is empty. */
struct pen_mtl {
    struct pen_buf library[MTL_LIBRARIES];
    const char *name[MTL_LIBRARIES]; /* in the OBJ file */
    size_t length[MTL_LIBRARIES];
    uint32_t libraries;
    struct pen_mtl_material *material; /* the first is that of faces without a material */
    uint32_t materials, space;
    uint32_t *slot; /* of a table by name: the number of a material + 1, or 0 */
    uint32_t slots;
};

/* Reads the MTL files that a statement mtllib names. Those that were read are not read again.
 * Fails: returns false; the error is at the statement, or names the MTL's line. */
bool pen_mtl_read(struct pen_mtl *mtl, struct pen_build *b);

/* After the last MTL: makes it possible to find materials. */
bool pen_mtl_index(struct pen_mtl *mtl, struct pen_build *b);

/* The material of this name, NULL if there is none. */
struct pen_mtl_material *pen_mtl_find(const struct pen_mtl *mtl, const char *name, size_t length);

void pen_mtl_release(struct pen_mtl *mtl, struct pen_build *b);

#endif
