/* SPDX-License-Identifier: MIT */
/* A scene without one of its effects. */
#ifndef PEN_STUDY_LEAVE_OUT_H
#define PEN_STUDY_LEAVE_OUT_H

#include "scene/scene.h"

/* What takes the place of an effect (one bit, enum pen_effect):
 *   ambient               no ambient light
 *   hard_shadows          lights whose shadows are hard cast none
 *   soft_shadows          lights have no radius
 *   shadow_transmittance  what is seen through blocks shadow rays
 *   mirror                kr 0
 *   transmission          kt 0
 *   anti_aliasing         one sample per pixel; through a lens as before
 *   specular              ks 0
 *   sky                   the horizon's colour
 *   depth_of_field        a pinhole
 *   patterns              the mean of the two colours
 *   refraction            ior 1
 *   glossy, frosted       no blur
 * Copies *from to *to, and changes the copy and the settings. What is changed is allocated in the
 * arena, the rest is shared. Fails: returns false when out of memory. */
bool pen_scene_leave_out(const struct pen_scene_desc *from, unsigned effect,
                         struct pen_arena *arena, struct pen_scene_desc *to,
                         struct pen_settings *settings);

#endif
