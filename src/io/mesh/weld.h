/* SPDX-License-Identifier: MIT */
/* A table of vertices by their place. */
#ifndef PEN_IO_MESH_WELD_H
#define PEN_IO_MESH_WELD_H

#include "io/mesh/build.h"

/* {0} is empty. Its hash has a random key, so that no file can make it slow. The key changes no
 * result. */
struct pen_weld {
    uint32_t *slot; /* a vertex's number + 1, or 0 */
    uint32_t mask, used;
    uint64_t key[2];
};

/* The first vertex of the model at the place of `vertex`, one of its vertices, which is added to
 * the table if there is none. -0 is 0.
 * Fails: returns UINT32_MAX with *st. */
uint32_t pen_weld_vertex(struct pen_weld *w, struct pen_build *b, uint32_t vertex);

void pen_weld_release(struct pen_weld *w, struct pen_build *b);

#endif
