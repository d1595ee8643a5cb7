/* SPDX-License-Identifier: MIT */
/* The pixels of a view in two orders: tile by tile, as they are committed, and row by row, as an
 * image. */
#ifndef PEN_JOBS_INTERNAL_VIEW_PIXELS_H
#define PEN_JOBS_INTERNAL_VIEW_PIXELS_H

#include "film/encode.h"
#include "film/film.h"
#include "scene/settings.h"
#include "store/store.h"

/* Returns the number of pixels in tiles first … first + count - 1. */
int64_t pen_tiles_pixels(const struct pen_settings *settings, int first, int count);

/* Copy tiles first … first + count - 1 out of an image, and into an image. */
void pen_tiles_gather(const struct pen_settings *settings, int first, int count, const float *image,
                      float *tiles);
void pen_tiles_scatter(const struct pen_settings *settings, int first, int count,
                       const float *tiles, float *image);

/* Fills a film with the committed pixels of a view, and sets *filled to their number. The byte of
 * each committed pixel in `mask` (may be NULL) becomes 1. The byte of each tile in `begins` (may be
 * NULL) becomes 1 if the tile is the first of a batch.
 * Fails: as pen_store_pixels; PEN_STORAGE (pixels outside the image). */
bool pen_view_pixels_load(struct pen_store *store, const char *id, int view,
                          const struct pen_settings *settings, struct pen_film *film,
                          unsigned char *mask, unsigned char *begins, int64_t *filled,
                          struct pen_status *st);

/* Begins the PNG of a film whose rows are not finished yet. Its bytes are those of pen_view_encode.
 * Owns: as pen_png_begin.
 * Fails: as pen_png_begin. */
struct pen_png_writer *pen_view_png_begin(const struct pen_film *film,
                                          const struct pen_settings *settings, struct pen_buf *out,
                                          struct pen_status *st);

/* Encodes a film as png, png16 or pfm.
 * Owns: release *out.
 * Fails: PEN_NO_MEMORY. */
bool pen_view_encode(const struct pen_film *film, const struct pen_settings *settings,
                     const char *format, struct pen_buf *out, struct pen_status *st);

#endif
