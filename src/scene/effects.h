/* SPDX-License-Identifier: MIT */
/* The effects that a frozen scene calls for by itself, before any settings. */
#ifndef SCENE_EFFECTS_H
#define SCENE_EFFECTS_H

#include "pen/scene/scene.h"

unsigned pen_effects_of_scene(const struct pen_scene *scene);

#endif
