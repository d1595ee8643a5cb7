/* SPDX-License-Identifier: MIT */
/* The effects that a frozen scene needs with any settings. */
#ifndef PEN_SCENE_INTERNAL_EFFECTS_H
#define PEN_SCENE_INTERNAL_EFFECTS_H

#include "scene/scene.h"

unsigned pen_effects_of_scene(const struct pen_scene *scene);

#endif
