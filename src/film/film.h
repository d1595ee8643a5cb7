/* SPDX-License-Identifier: MIT */
/* The film: the pixels of a rendered image, as linear colour in binary32. A kernel computes a pixel
 * in double precision, and it is rounded once, into the film. Every file is encoded from the film.
 * 1.0 is display white, and larger values are legal. */
#ifndef PEN_FILM_FILM_H
#define PEN_FILM_FILM_H

#include <stdint.h>

#include "base/status.h"

enum { PEN_FILM_PIXELS_MAX = 64 * 1024 * 1024 };

/* An image. A caller with its own pixels may also fill in this struct itself. */
struct pen_film {
    int width, height; /* pixels */
    float *rgb;        /* width * height * 3; row 0 is the top one */
};

/* Makes a black film.
 * Owns: free with pen_film_free.
 * Fails: PEN_INVALID (a side below 1), PEN_TOO_LARGE (more than PEN_FILM_PIXELS_MAX),
 * PEN_NO_MEMORY. */
struct pen_film *pen_film_new(int width, int height, struct pen_status *st);

/* Frees a film. NULL is allowed. */
void pen_film_free(struct pen_film *film);

/* A hash of the size and of every bit of the pixels; the same on every machine. */
uint64_t pen_film_hash(const struct pen_film *film);

#endif
