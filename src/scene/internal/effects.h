/* SPDX-License-Identifier: MIT */
/* The effects of a frozen scene. */
#ifndef PEN_SCENE_INTERNAL_EFFECTS_H
#define PEN_SCENE_INTERNAL_EFFECTS_H

#include "scene/scene.h"

/* Sets scene->effects and scene->factors. */
void pen_effects_find(struct pen_scene *scene);

#endif
