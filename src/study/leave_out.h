/* SPDX-License-Identifier: MIT */
/* A scene without one of its effects. */
#ifndef PEN_STUDY_LEAVE_OUT_H
#define PEN_STUDY_LEAVE_OUT_H

#include "scene/scene.h"

/* Copies *from to *to without an effect, which is one bit of enum pen_effect. The change is
 *    ambient               no ambient light
 *    hard_shadows          lights with hard shadows cast none
 *    soft_shadows          lights have no radius
 *    shadow_transmittance  transmitting surfaces block shadow rays
 *    mirror                kr 0
 *    transmission          kt 0
 *    anti_aliasing         one sample per pixel; lens samples stay as they are
 *    specular              ks 0
 *    sky                   the horizon's colour
 *    depth_of_field        a pinhole camera
 *    patterns              the mean of the two colours
 *    refraction            ior 1
 *    glossy, frosted       no blur
 *    smooth_normals        meshes have no normals
 * The settings are changed in place.
 * Owns: the arena gets the changed parts of *to; all others are shared with *from.
 * Fails: false when out of memory. */
bool pen_scene_leave_out(const struct pen_scene_desc *from, unsigned effect,
                         struct pen_arena *arena, struct pen_scene_desc *to,
                         struct pen_settings *settings);

#endif
