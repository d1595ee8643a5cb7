/* SPDX-License-Identifier: MIT */
/* Pictures read from files, to be compared. A file may come from an untrusted source: whatever its
 * bytes, reading ends with a picture or an error. */
#ifndef PEN_FILM_PICTURE_H
#define PEN_FILM_PICTURE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "film/encode.h"
#include "film/film.h"

struct pen_picture;

/* Reads a PNG (any kind; grey and palettes become colours, and transparency alpha) or a PFM file.
 * Owns: free with pen_picture_free. Fails: PEN_MEDIA_TYPE (neither PNG nor PFM), PEN_SYNTAX
 * (damaged), PEN_TOO_LARGE (more than PEN_FILM_PIXELS_MAX), PEN_NO_MEMORY. */
struct pen_picture *pen_picture_read(const void *bytes, size_t count, struct pen_status *st);

/* Fills a film from a PFM file that has its size. Fails: PEN_SYNTAX (damaged, or another size); the
 * film then holds a part of it. */
bool pen_pfm_load(const void *data, size_t bytes, struct pen_film *film, struct pen_status *st);

/* A film as a picture; it borrows the film's pixels. They are linear values, or values for a screen
 * if that is the transfer function. Fails: PEN_NO_MEMORY. */
struct pen_picture *pen_picture_of_film(const struct pen_film *film, enum pen_transfer transfer,
                                        struct pen_status *st);

/* The picture of a film's PFM file, but with that transfer function. Takes the film, after failure
 * too. Fails: PEN_NO_MEMORY. */
struct pen_picture *pen_picture_take_film(struct pen_film *film, enum pen_transfer transfer,
                                          struct pen_status *st);

/* Reads the samples as they are, whatever the file says: as the values of the film, if the scene
 * has transfer display or linear. */
void pen_picture_set_linear(struct pen_picture *picture);

/* Makes two pictures alike, so that they can be compared: if one has values for a screen, those of
 * an sRGB file, or of a PFM file, which does not say, are read as such, too. Returns whether the
 * files state different transfer functions although their samples are equal; they are then read
 * alike. */
bool pen_picture_match(struct pen_picture *a, struct pen_picture *b);

/* NULL is allowed. */
void pen_picture_free(struct pen_picture *picture);

int pen_picture_width(const struct pen_picture *picture);
int pen_picture_height(const struct pen_picture *picture);

/* Row y (0 is the top one) as width * 3 values in [0, 1] as a screen shows them. Linear files are
 * encoded as sRGB: PFM, and PNG whose gAMA chunk states gamma 1. Other PNG files are so already. */
void pen_picture_encoded_row(const struct pen_picture *picture, int y, double *out);

/* Row y as linear values: in [0, 1] from a PNG file, unchanged from a PFM file. Of values for a
 * screen, the light that it shows. */
void pen_picture_linear_row(const struct pen_picture *picture, int y, double *out);

/* Row y as width values of alpha, from 0 to 1; 1 if the file has no alpha. */
void pen_picture_alpha_row(const struct pen_picture *picture, int y, double *out);

#endif
