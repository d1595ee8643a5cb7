/* SPDX-License-Identifier: MIT */
/* The pixels of a view in two orders: as they are committed, tile by tile, and as an image, row by
 * row. */
#ifndef PEN_JOBS_INTERNAL_VIEW_PIXELS_H
#define PEN_JOBS_INTERNAL_VIEW_PIXELS_H

#include "film/encode.h"
#include "film/film.h"
#include "scene/settings.h"
#include "store/store.h"

/* The number of pixels in tiles first … first + count - 1. */
int64_t pen_tiles_pixels(const struct pen_settings *settings, int first, int count);

/* Copies tiles first … first + count - 1 out of an image, and into one. */
void pen_tiles_gather(const struct pen_settings *settings, int first, int count, const float *image,
                      float *tiles);
void pen_tiles_scatter(const struct pen_settings *settings, int first, int count,
                       const float *tiles, float *image);

/* Fills a film with the committed pixels of a view. mask (may be NULL) has one byte for each pixel,
 * which becomes 1 if the pixel is committed; begins (may be NULL) one for each tile, which becomes
 * 1 if it is the first of a batch; *filled becomes the number of committed pixels. Fails: as
 * pen_store_pixels; PEN_STORAGE (pixels outside the image). */
bool pen_view_pixels_load(struct pen_store *store, const char *id, int view,
                          const struct pen_settings *settings, struct pen_film *film,
                          unsigned char *mask, unsigned char *begins, int64_t *filled,
                          struct pen_status *st);

/* Begins the PNG of a film whose rows are not finished yet, with the bytes of pen_view_encode. Owns
 * and fails: as pen_png_begin. */
struct pen_png_writer *pen_view_png_begin(const struct pen_film *film,
                                          const struct pen_settings *settings, struct pen_buf *out,
                                          struct pen_status *st);

/* Encodes a film as png, png16 or pfm. Owns: release *out. Fails: PEN_NO_MEMORY. */
bool pen_view_encode(const struct pen_film *film, const struct pen_settings *settings,
                     const char *format, struct pen_buf *out, struct pen_status *st);

#endif
