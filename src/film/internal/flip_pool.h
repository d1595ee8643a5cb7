/* SPDX-License-Identifier: MIT */
#ifndef PEN_FILM_INTERNAL_FLIP_POOL_H
#define PEN_FILM_INTERNAL_FLIP_POOL_H

#include "film/flip.h"

/* Pools width * height errors, all >= 0.
 * Fails: PEN_NO_MEMORY. */
bool pen_flip_pool(const float *errors, int width, int height, struct pen_flip *out,
                   struct pen_status *st);

#endif
