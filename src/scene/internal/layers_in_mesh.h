/* SPDX-License-Identifier: MIT */
/* Which triangles of meshes may coincide with something. Within a mesh, only triangles of the same
 * three points count as coincident. With other primitives, any triangle may. */
#ifndef PEN_SCENE_INTERNAL_LAYERS_IN_MESH_H
#define PEN_SCENE_INTERNAL_LAYERS_IN_MESH_H

#include "geom/prims.h"

struct pen_layers_others;

/* The boxes of the primitives outside meshes and of the meshes.
 * Owns: free the result.
 * Fails: NULL when out of memory. */
struct pen_layers_others *pen_layers_others(const struct pen_prims *prims);

/* Whether a triangle of mesh number m comes near a primitive outside that mesh. */
bool pen_mesh_comes_near(const struct pen_prims *prims, const struct pen_layers_others *others,
                         uint32_t m, uint32_t triangle);

/* Calls fn for pairs of triangles with the same three points, by their primitive numbers, a < b. Of
 * many equal ones, some pairs are left out; then each has at least 16 pairs.
 * Fails: returns false when out of memory.
 * Cost: linear. */
bool pen_mesh_find_equal(const struct pen_mesh *mesh,
                         void (*fn)(void *user, uint32_t a, uint32_t b), void *user);

#endif
