/* SPDX-License-Identifier: MIT */
/* Any bytes as a picture: PNG or PFM. An accepted picture has a size and encoded values from 0 to
 * 1. */
#include "film/picture.h"
#include "fuzz/fuzz.h"

enum { PIXELS = 1 << 22 }; /* larger pictures are not looked at, which would take long */

/* The size that a PNG's head states: libpng allocates for it, which takes time and no bug. */
static int is_large(const uint8_t *data, size_t size)
{
    if (size < 24 || data[0] != 0x89)
        return 0;
    uint64_t width = 0, height = 0;
    for (int i = 0; i < 4; i++) {
        width = width << 8 | data[16 + i];
        height = height << 8 | data[20 + i];
    }
    return width * height > PIXELS;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pen_status st = {0};
    if (is_large(data, size))
        return 0;
    struct pen_picture *picture = pen_picture_read(data, size, &st);
    must(picture || st.code != PEN_OK);
    if (!picture)
        return 0;
    const int width = pen_picture_width(picture), height = pen_picture_height(picture);
    must(width > 0 && height > 0);
    double *row = malloc((size_t)width * 3 * sizeof *row);
    must(row != NULL);
    for (int y = 0; y<height; y += height> 64 ? height / 64 : 1) {
        pen_picture_linear_row(picture, y, row);
        pen_picture_encoded_row(picture, y, row);
        for (int i = 0; i < 3 * width; i++)
            must(row[i] >= 0 && row[i] <= 1);
    }
    free(row);
    pen_picture_free(picture);
    return 0;
}
