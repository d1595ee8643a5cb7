/* SPDX-License-Identifier: MIT */
/* Views in which no primitive is visible. */
#ifndef PEN_SCENE_EMPTY_VIEW_H
#define PEN_SCENE_EMPTY_VIEW_H

#include <stdbool.h>
#include <stddef.h>

#include "scene/scene.h"

/* Writes a warning with a remedy to `out` if no camera ray of the view can meet a primitive. That
 * is certain if all primitives are behind the eye, or all beyond one side of the pyramid of rays.
 * Returns false otherwise, also if no single side excludes them all, and for scenes without
 * primitives.
 * Cost: up to the first primitive that may be visible; no ray is traced. */
bool pen_view_empty_warning(const struct pen_scene *scene, int view, int width, int height,
                            char *out, size_t bytes);

#endif
