/* SPDX-License-Identifier: MIT */
/* The same scene twice: with meshes, and with the triangles of the meshes stored one by one. */
#ifndef TESTS_SUPPORT_TWIN_H
#define TESTS_SUPPORT_TWIN_H

#include "support/world.h"

enum { TWIN_MESHES = 4 };

struct twin {
    struct world *stored; /* every primitive is stored */
    struct pen_prims prims;
    struct pen_prim_ref ref[WORLD_MAX];
    struct pen_mesh mesh[TWIN_MESHES];
    float vertex[3 * WORLD_MAX];
    uint32_t corner[3 * WORLD_MAX];
    uint32_t vertices, corners; /* numbers in use */
};

/* Begins a twin without primitives; w must live as long. */
void twin_clear(struct twin *t, struct world *w);

/* Begins a mesh; twin_mesh_end makes primitives of what was added between. */
void twin_mesh_begin(struct twin *t, struct pen_vec3 shift, double unit);
uint32_t twin_vertex(struct twin *t, struct pen_vec3 v);
void twin_triangle(struct twin *t, uint32_t a, uint32_t b, uint32_t c);
void twin_mesh_end(struct twin *t);

/* A closed bumpy sphere, a grid of hills, and separate triangles, in the mesh that has begun; sizes
 * are about 1. */
void twin_ball(struct twin *t, struct random *r, uint32_t stacks, uint32_t slices);
void twin_hills(struct twin *t, struct random *r, uint32_t side);
void twin_soup(struct twin *t, struct random *r, uint32_t count, double size);

/* Takes the primitives that were added to the stored world since the last mesh. Call it before each
 * twin_mesh_begin and at the end. */
void twin_take(struct twin *t);

#endif
