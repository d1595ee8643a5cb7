/* SPDX-License-Identifier: MIT */
/* T-junctions: a vertex of one triangle or polygon (a "loop") is inside an edge of another loop,
 * and both loops run along that line. The edge and the edges beside it are then rounded
 * differently, and a ray may pass between them. The following are not T-junctions:
 *  - a vertex that only touches an edge (the foot of a post);
 *  - an edge that two loops share end to end, as in a box: it is closed, with any loops beside it;
 *  - a vertex that is exactly on the edge's line, as with primitives parallel to the axes. */
#ifndef PEN_SCENE_TJUNCTION_H
#define PEN_SCENE_TJUNCTION_H

#include "scene/desc.h"

/* Scenes with more edges are not searched; no T-junction is found in them. */
enum { PEN_TJUNCTION_EDGES_MAX = 20000 };

/* A T-junction. Loops are numbered from 0 in document order, depth first. */
struct pen_tjunction {
    uint32_t loop, vertex; /* the vertex and its loop */
    uint32_t edge_loop;    /* the first loop with an edge that contains the vertex */
};

typedef void pen_tjunction_fn(void *user, const struct pen_tjunction *found);

/* Calls `found` for vertices at a T-junction, in document order. It finds all of them if the search
 * takes fewer than steps_max steps, of some 25 ns each. Edges are searched in document order, so
 * the edges within the steps depend only on the scene. Returns whether all edges were searched;
 * none is if memory runs out, or if there are more than PEN_TJUNCTION_EDGES_MAX. */
bool pen_tjunctions_find(const struct pen_scene_desc *desc, uint64_t steps_max,
                         pen_tjunction_fn *found, void *user);

#endif
