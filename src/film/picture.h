/* SPDX-License-Identifier: MIT */
/* Pictures read from files, for comparison. A file may come from an untrusted source: for any
 * bytes, reading ends with a picture or an error. */
#ifndef PEN_FILM_PICTURE_H
#define PEN_FILM_PICTURE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "film/encode.h"
#include "film/film.h"

struct pen_picture;

/* Reads a PNG or PFM file. A PNG may be of any kind: grey and palettes become colours, and
 * transparency becomes alpha.
 * Owns: free with pen_picture_free.
 * Fails: PEN_MEDIA_TYPE (neither PNG nor PFM), PEN_SYNTAX (damaged), PEN_TOO_LARGE (more than
 * PEN_FILM_PIXELS_MAX), PEN_NO_MEMORY. */
struct pen_picture *pen_picture_read(const void *bytes, size_t count, struct pen_status *st);

/* Fills a film from a PFM file that has its size.
 * Fails: PEN_SYNTAX (damaged, or another size); the film then holds a part of it. */
bool pen_pfm_load(const void *data, size_t bytes, struct pen_film *film, struct pen_status *st);

/* A film as a picture; it borrows the film's pixels. They are linear values, or screen values if
 * that is the transfer function.
 * Fails: PEN_NO_MEMORY. */
struct pen_picture *pen_picture_of_film(const struct pen_film *film, enum pen_transfer transfer,
                                        struct pen_status *st);

/* The picture of a film's PFM file, but with that transfer function. Takes the film, after failure
 * too. Fails: PEN_NO_MEMORY. */
struct pen_picture *pen_picture_take_film(struct pen_film *film, enum pen_transfer transfer,
                                          struct pen_status *st);

/* Reads the samples unchanged, ignoring the file's transfer function: as the values of the film, if
 * the scene has transfer display or linear. */
void pen_picture_set_linear(struct pen_picture *picture);

/* Prepares two pictures for comparison. If one has screen values, the other is read as screen
 * values too if it is an sRGB file, or a PFM file, which does not state its transfer function.
 * Returns true if the files state different transfer functions although their samples are equal;
 * both are then read in the same way. */
bool pen_picture_match(struct pen_picture *a, struct pen_picture *b);

/* Frees a picture. NULL is allowed. */
void pen_picture_free(struct pen_picture *picture);

int pen_picture_width(const struct pen_picture *picture);
int pen_picture_height(const struct pen_picture *picture);

/* Row y (0 is the top one) as width * 3 values in [0, 1] as a screen shows them. Linear files are
 * encoded as sRGB: PFM, and PNG whose gAMA chunk states gamma 1. Other PNG files already contain
 * such values. */
void pen_picture_encoded_row(const struct pen_picture *picture, int y, double *out);

/* Row y as linear values: in [0, 1] from a PNG file, unchanged from a PFM file. Screen values
 * become the light that the screen shows. */
void pen_picture_linear_row(const struct pen_picture *picture, int y, double *out);

/* Row y as width values of alpha, from 0 to 1; 1 if the file has no alpha. */
void pen_picture_alpha_row(const struct pen_picture *picture, int y, double *out);

#endif
