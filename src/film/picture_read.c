/* SPDX-License-Identifier: MIT */
/* Selects the reader of a picture's file by its first bytes. */
#include <string.h>

#include "film/internal/picture.h"

struct pen_picture *pen_picture_read(const void *bytes, size_t count, struct pen_status *st)
{
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    const unsigned char *data = bytes;
    if (count >= sizeof png && memcmp(data, png, sizeof png) == 0)
        return pen_png_read(data, count, st);
    if (count >= 3 && data[0] == 'P' && (data[1] == 'F' || data[1] == 'f'))
        return pen_pfm_read(data, count, st);
    pen_fail(st, PEN_MEDIA_TYPE, "neither a PNG nor a PFM file");
    return NULL;
}
