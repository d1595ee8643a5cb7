/* SPDX-License-Identifier: MIT */
/* What a picture is inside: the samples as the file had them, so that a large one costs no more
 * memory than its file's own precision. */
#ifndef PEN_FILM_INTERNAL_PICTURE_H
#define PEN_FILM_INTERNAL_PICTURE_H

#include <stdbool.h>

#include "film/picture.h"

enum picture_kind { PICTURE_8, PICTURE_16, PICTURE_FLOAT };

struct pen_picture {
    int width, height;
    enum picture_kind kind;
    bool linear;         /* else sRGB-encoded; floats are always linear */
    const void *samples; /* width * height * 3 of unsigned char, uint16_t or float; top row first */
    void *owned;         /* to be freed with the picture: samples or NULL */
};

/* Checks the size and makes a picture with zeroed samples of its own. */
struct pen_picture *pen_picture_new(int64_t width, int64_t height, enum picture_kind kind,
                                    struct pen_status *st);

/* Readers of one format each; what they are given begins with its signature. */
struct pen_picture *pen_png_read(const unsigned char *bytes, size_t count, struct pen_status *st);
struct pen_picture *pen_pfm_read(const unsigned char *bytes, size_t count, struct pen_status *st);

#endif
