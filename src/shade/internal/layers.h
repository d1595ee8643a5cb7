/* SPDX-License-Identifier: MIT */
/* Coincident surfaces along one path. Rounding decides which of them a ray meets first, so the path
 * visits them in document order. */
#ifndef PEN_SHADE_INTERNAL_LAYERS_H
#define PEN_SHADE_INTERNAL_LAYERS_H

#include "scene/scene.h"

/* Layers beyond this number in one place are visited in the order of t. */
enum { LAYERS_MAX = 32 };

/* The layers at one place that a path has visited or will visit. */
struct layers {
    bool any;             /* the ray is among layers; if false, the other members are undefined */
    struct pen_hit after; /* all hits up to this one have been visited, or are waiting */
    struct pen_hit waiting[LAYERS_MAX]; /* in the order in which they are visited */
    int next, count;                    /* of `waiting` */
    struct pen_hit ahead[LAYERS_MAX];   /* hits after `after` that are visited or waiting */
    int ahead_count;
};

#endif
