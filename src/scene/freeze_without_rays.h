/* SPDX-License-Identifier: MIT */
/* Freezing of a scene that is measured and checked, but never rendered. */
#ifndef PEN_SCENE_FREEZE_WITHOUT_RAYS_H
#define PEN_SCENE_FREEZE_WITHOUT_RAYS_H

#include "scene/scene.h"

/* As pen_scene_freeze, without the data that only rays need and that may take quadratic time. These
 * are: the places where primitives may coincide (layer_first is NULL), the triangles of polygons
 * that are not quite plane, and the acceleration structure (accel is NULL). Views, primitives,
 * materials and solids are complete.
 * Owns: free with pen_scene_free; keeps no pointer into `desc`.
 * Fails: as pen_scene_freeze.
 * Cost: O(n log n) for n primitives and their vertices, and O(n) for each view. */
struct pen_scene *pen_scene_freeze_without_rays(const struct pen_scene_desc *desc,
                                                struct pen_status *st);

#endif
