/* SPDX-License-Identifier: MIT */
/* Errors of pixels, shown as a picture. */
#ifndef PEN_FILM_ERROR_MAP_H
#define PEN_FILM_ERROR_MAP_H

#include "base/status.h"
#include "film/film.h"

enum pen_error_map {
    PEN_ERROR_MAP_COLOURS, /* magma: 0 is black, then purple and red, 1 is pale yellow */
    PEN_ERROR_MAP_VALUES   /* the errors themselves, as grey */
};

/* A picture of width * height errors in [0, 1], row 0 at the top. The colours are ordered by
 * lightness, so grey prints and colour-blind readers show the same order. They are for the sRGB
 * transfer function. Errors are shown in 256 steps.
 * Owns: free with pen_film_free.
 * Fails: as pen_film_new. */
struct pen_film *pen_error_map(const float *errors, int width, int height, enum pen_error_map kind,
                               struct pen_status *st);

#endif
