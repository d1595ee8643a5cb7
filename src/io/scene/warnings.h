/* SPDX-License-Identifier: MIT */
/* Notes on valid scenes. A note is a status with code PEN_OK. */
#ifndef PEN_IO_SCENE_WARNINGS_H
#define PEN_IO_SCENE_WARNINGS_H

#include "io/scene_json.h"

/* Vertices of triangles and polygons that lie inside an edge of another one along which both run.
 * Edges beyond PEN_TJUNCTION_EDGES_MAX are not looked at: then nothing is said at all. */
enum { PEN_TJUNCTION_EDGES_MAX = 20000 };
void pen_tjunction_warnings(const struct pen_scene_desc *desc, const char *at,
                            struct pen_errors *warnings);

#endif
