/* SPDX-License-Identifier: MIT */
/* The materials of an OBJ file, from its MTL files. */
#ifndef PEN_IO_MESH_MTL_H
#define PEN_IO_MESH_MTL_H

#include "io/mesh/build.h"

struct pen_mtl_material {
    size_t name, length; /* in the text */
    uint32_t used;       /* its place in the model, + 1; 0: no face uses it yet */
    struct pen_model_material is;
};

/* {0} is empty. The first material is that of faces that have none. */
struct pen_mtl {
    struct pen_buf text; /* of all MTL files, one after another */
    const char *name;    /* of the last file, in the OBJ file */
    size_t length;
    struct pen_mtl_material *material;
    uint32_t count, space, files;
};

/* Adds the material with this name, of the place `name` in the text. */
bool pen_mtl_add(struct pen_mtl *mtl, struct pen_build *b, size_t name, size_t length);

/* Reads the MTL files that a statement mtllib names.
 * Fails: returns false. The error has the place of the statement, and the MTL's line in words. */
bool pen_mtl_read(struct pen_mtl *mtl, struct pen_build *b);

void pen_mtl_release(struct pen_mtl *mtl, struct pen_build *b);

#endif
