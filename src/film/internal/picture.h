/* SPDX-License-Identifier: MIT */
/* The contents of a picture. Samples keep the precision of their file, so a large picture of 8 bits
 * takes no more memory than necessary. */
#ifndef PEN_FILM_INTERNAL_PICTURE_H
#define PEN_FILM_INTERNAL_PICTURE_H

#include <stdbool.h>

#include "film/encode.h"
#include "film/picture.h"

enum picture_kind { PICTURE_8, PICTURE_16, PICTURE_FLOAT };

struct pen_picture {
    int width, height, channels; /* 3, or 4 with alpha */
    enum picture_kind kind;
    enum pen_transfer transfer; /* of the samples; floats are not encoded */
    const void *samples; /* width * height * channels of unsigned char, uint16_t or float, by kind;
                          * top row first */
    void *owned;         /* the samples if the picture owns them, else NULL */
    double decoded[256]; /* the linear value of each code, for PICTURE_8 */
};

/* The `count` pixels of row y, from column x on. */
struct pen_picture_part {
    int x, y, count;
};

/* As pen_picture_encoded_row and pen_picture_linear_row, for a part of a row inside the picture. So
 * the memory of a filter need not grow with the width. */
void pen_picture_encoded_part(const struct pen_picture *picture, struct pen_picture_part part,
                              double *out);
void pen_picture_linear_part(const struct pen_picture *picture, struct pen_picture_part part,
                             double *out);

/* Whether the picture was read from a PFM file. */
bool pen_picture_is_pfm(const struct pen_picture *picture);

/* Makes a picture with zeroed samples, with 3 or 4 channels.
 * Fails: PEN_SYNTAX (no pixels), PEN_TOO_LARGE, PEN_NO_MEMORY. */
struct pen_picture *pen_picture_new(int64_t width, int64_t height, int channels,
                                    enum picture_kind kind, struct pen_status *st);

/* Readers of one format each; the bytes begin with the format's signature.
 * Fails: as pen_picture_read. */
struct pen_picture *pen_png_read(const unsigned char *bytes, size_t count, struct pen_status *st);
struct pen_picture *pen_pfm_read(const unsigned char *bytes, size_t count, struct pen_status *st);

#endif
