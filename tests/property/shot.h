/* SPDX-License-Identifier: MIT */
/* Small pictures of scenes made in code, with a narrow view. */
#ifndef TESTS_PROPERTY_SHOT_H
#define TESTS_PROPERTY_SHOT_H

#include "support/kit.h"

enum { SHOT_SIDE = 32, SHOT_PIXELS = SHOT_SIDE * SHOT_SIDE };

/* An empty scene for such a picture. */
void shot_begin(struct kit *kit);

/* Looks from eye at a window that is `wide` across, at `at`. */
void shot_look(struct kit *kit, struct pen_vec3 eye, struct pen_vec3 at, double wide);

/* Renders on the calling thread; returns the number of shadow rays. */
double shot_take(struct kit *kit, float rgb[3 * SHOT_PIXELS]);

/* Returns true if the picture has the warning that its pixels are too small for the numbers. */
bool shot_warns(struct kit *kit);

/* Returns the number of pixels that are not black. */
int shot_lit(const float rgb[3 * SHOT_PIXELS]);

#endif
