/* SPDX-License-Identifier: MIT */
/* Small copies of pictures. */
#ifndef PEN_FILM_SHRINK_H
#define PEN_FILM_SHRINK_H

#include "base/status.h"
#include "film/film.h"
#include "film/picture.h"

/* A copy whose longer edge has `edge` pixels, at most as many as the picture's. The shorter edge
 * keeps the aspect, rounded, and has at least one pixel. A pixel of the copy is the mean of the
 * linear values in the area that it covers. Alpha is left out.
 * Owns: free with pen_film_free. Fails: NULL; PEN_NO_MEMORY.
 * Cost: about 10 ns for each pixel of an 8-bit picture. */
struct pen_film *pen_picture_shrink(const struct pen_picture *picture, int edge,
                                    struct pen_status *st);

#endif
